//! What breaks, what is left, and what wakes.

use super::*;
use bevy_ecs::message::Messages;
use drystone::body::{ExternalForce, Inactive, Sleeping};
use drystone::joint::JointError;
use drystone::masonry::{Bond, Wall};

/// A cantilever at twice its limit breaks at its root alone, and falls in one piece.
#[test]
fn an_overloaded_cantilever_falls_in_one_piece() {
    for dt in STEPS {
        let mut lab = Lab::shipped(dt);
        // M/W of ten cubes is 1.47 MPa.
        let all = cantilever(&mut lab, 10, tensile(0.7e6));
        lab.run(0.8);
        let broke = broken(&mut lab);
        assert_eq!(broke.len(), 1, "dt {dt}: {broke:?}");
        assert_eq!([broke[0].body, broke[0].other], [all[0], all[1]]);
        assert_eq!(broke[0].how, MortarFailure::Tension);
        assert!(broke[0].stress > 0.7e6, "{broke:?}");
        assert!(broke[0].point.distance(Vec3::new(0.25, 10.0, 0.0)) < 1e-3);
        assert_eq!(bonds(&mut lab), 9);
        let [first, last] = [all[1], all[10]].map(|body| lab.position(body));
        assert!(last.y < 8.5, "it falls");
        assert!(
            (first.distance(last) - 9.0 * EDGE).abs() < 1e-3,
            "it is straight"
        );
    }
}

/// A block on a slope whose bond is broken by a push slides as one without mortar from that pose.
#[test]
fn broken_mortar_leaves_dry_stone() {
    for dt in [1.0 / 60.0, 1.0 / 30.0] {
        let angle = 0.7f32;
        let slope = Quat::from_rotation_z(-angle);
        let at = Transform::from_translation(slope * (Vec3::Y * 0.5 * EDGE)).with_rotation(slope);
        let block = |lab: &mut Lab, at: Transform, velocity: Velocity| {
            let block = (RigidBody::Dynamic, cube(), Mass(MASS), at, velocity);
            lab.spawn((block, Friction::new(0.5)))
        };
        let mut lab = Lab::shipped(dt);
        lab.slope(angle, 0.5);
        let bonded = block(&mut lab, at, Velocity::default());
        lab.world.entity_mut(bonded).insert(Mortar::new(1e5, 1e4));
        lab.run(0.5);
        assert!(
            lab.position(bonded).distance(at.translation) < 1e-5,
            "it holds"
        );
        assert_eq!(bonds(&mut lab), 1);
        let down = slope * Vec3::X;
        let push = ExternalForce {
            force: 4e3 * down,
            ..Default::default()
        };
        lab.world.entity_mut(bonded).insert(push);
        let mut broke = Vec::new();
        while broke.is_empty() {
            lab.step();
            broke = broken(&mut lab);
        }
        assert_eq!(broke[0].how, MortarFailure::Shear);
        lab.world
            .entity_mut(bonded)
            .insert(ExternalForce::default());
        assert_eq!(bonds(&mut lab), 0);

        let mut dry = Lab::shipped(dt);
        dry.slope(angle, 0.5);
        let pose = lab.pose(bonded);
        let at = Transform::from_translation(pose.position).with_rotation(pose.rotation);
        let velocity = lab.velocity(bonded);
        let loose = block(&mut dry, at, velocity);
        lab.run(1.0);
        dry.run(1.0);
        let [a, b] = [lab.position(bonded), dry.position(loose)];
        let way = a.distance(pose.position);
        println!("dt {dt}: slid {way} m, {} mm apart", 1e3 * a.distance(b));
        assert!(way > 1.0 && a.distance(b) < 1e-4 * way, "{a} {b}");
    }
}

/// A wall of mortar is bonded brick by brick in the first step, and loses bricks to a ball; one that does not break loses none.
#[test]
fn a_ball_breaks_a_hole_into_a_wall() {
    let lost = |mortar: Mortar, dt: f32| {
        let mut lab = Lab::shipped(dt);
        lab.ground();
        let blocks = Wall::new(Bond::Running).blocks().unwrap().into_iter();
        let bricks: Vec<Entity> = blocks
            .map(|block| lab.spawn((block.bundle(), mortar)))
            .collect();
        lab.run(0.5);
        assert!(broken(&mut lab).is_empty());
        let starts: Vec<Vec3> = bricks.iter().map(|&brick| lab.position(brick)).collect();
        lab.spawn((
            (RigidBody::Dynamic, Collider::ball(0.4), Mass(2_000.0)),
            Velocity::linear(Vec3::new(0.0, 0.0, -20.0)),
            Transform::from_xyz(0.2, 1.8, 1.5),
        ));
        lab.run(1.5);
        let moved = bricks.iter().zip(starts);
        let moved = moved.filter(|(brick, start)| lab.position(**brick).distance(*start) > 0.3);
        (moved.count(), broken(&mut lab).len())
    };
    for dt in [1.0 / 60.0, 1.0 / 30.0] {
        let [weak, strong] = [Mortar::default(), FOREVER].map(|mortar| lost(mortar, dt));
        println!("dt {dt}: weak {weak:?}, strong {strong:?}");
        assert!(weak.0 > 3 && weak.1 > 10, "{weak:?}");
        assert_eq!(strong.1, 0);
    }
}

#[test]
fn a_sleeping_cantilever_breaks_under_a_brick_that_is_laid_on_it() {
    let mut lab = Lab::new();
    // Five cubes: 0.37 MPa; with another on the last one: 0.50 MPa.
    let all = cantilever(&mut lab, 5, tensile(0.45e6));
    lab.run(2.0);
    assert!(lab.world.get::<Sleeping>(all[5]).unwrap().asleep);
    assert!(lab.world.entity(all[3]).contains::<Inactive>());
    assert!(broken(&mut lab).is_empty());
    let at = lab.position(all[5]) + Vec3::Y * (EDGE + 0.002);
    brick(&mut lab, at, ());
    lab.run(0.5);
    let broke = broken(&mut lab);
    assert_eq!(broke.len(), 1, "{broke:?}");
    assert_eq!(broke[0].body, all[0]);
    assert!(lab.position(all[5]).y < 9.8);
}

#[test]
fn a_hand_breaks_a_sleeping_cantilever() {
    let mut lab = Lab::new();
    let all = cantilever(&mut lab, 5, tensile(0.45e6));
    lab.run(2.0);
    assert!(lab.world.get::<Sleeping>(all[5]).unwrap().asleep);
    let down = lab.position(all[5]) - Vec3::Y * 3.0;
    lab.world
        .entity_mut(all[5])
        .insert(Grab::gentle(3_000.0, Vec3::ZERO, down));
    lab.run(0.5);
    assert_eq!(broken(&mut lab)[0].body, all[0]);
}

/// Nobody else knows the bonds of a brick. If they stayed, each of them would be looked at in every step from then on.
#[test]
fn bricks_that_are_despawned_take_their_bonds_along() {
    let mut lab = Lab::shipped(1.0 / 60.0);
    lab.ground();
    let bricks = Wall::new(Bond::Running).blocks().unwrap().into_iter();
    let bricks: Vec<Entity> = bricks
        .map(|brick| lab.spawn((brick.bundle(), Mortar::default())))
        .collect();
    lab.run(0.2);
    let all = bonds(&mut lab);
    for &brick in &bricks[10..] {
        lab.world.despawn(brick);
    }
    lab.step();
    let left = bonds(&mut lab);
    assert!((1..all).contains(&left), "{left} of {all}");
    let mut joints = lab.world.query::<&MortarJoint>();
    for joint in joints.iter(&lab.world) {
        let ends = [joint.body1, joint.body2];
        let lives = |body: Option<Entity>| body.is_some_and(|it| lab.world.get_entity(it).is_ok());
        assert!(ends.into_iter().all(lives));
    }
    for &brick in &bricks[..10] {
        lab.world.despawn(brick);
    }
    lab.step();
    assert_eq!(bonds(&mut lab), 0);
    assert!(lab.world.resource::<Messages<JointError>>().is_empty());
}

/// The user despawns a bond: the bricks wake and are dry.
#[test]
fn a_bond_may_be_despawned() {
    let mut lab = Lab::new();
    let all = cantilever(&mut lab, 3, FOREVER);
    lab.run(2.0);
    let mut joints = lab.world.query::<(Entity, &MortarJoint)>();
    let found = joints.iter(&lab.world);
    let mut found = found.filter(|(_, joint)| joint.body2 == Some(all[2]));
    let (joint, of) = found.next().unwrap();
    assert!((of.area() - EDGE * EDGE).abs() < 1e-6);
    lab.world.despawn(joint);
    lab.run(0.5);
    assert!(lab.position(all[2]).y < 9.5 && lab.position(all[1]).y > 9.99);
    assert!(broken(&mut lab).is_empty());
}

#[test]
fn an_edit_that_moves_a_brick_breaks_its_bonds_alone() {
    for asleep in [false, true] {
        let mut lab = if asleep {
            Lab::new()
        } else {
            Lab::shipped(1.0 / 60.0)
        };
        lab.ground();
        let blocks = Wall::new(Bond::Running).blocks().unwrap().into_iter();
        let bricks: Vec<Entity> = blocks
            .map(|block| lab.spawn((block.bundle(), Mortar::default())))
            .collect();
        lab.run(2.0);
        let top = bricks.len() - 3;
        let starts: Vec<Vec3> = bricks.iter().map(|&brick| lab.position(brick)).collect();
        let count = bonds(&mut lab);
        let away = Transform::from_xyz(0.0, 6.0, 3.0);
        lab.world.entity_mut(bricks[top]).insert(away);
        lab.run(0.3);
        let broke = broken(&mut lab);
        assert!(broke.len() >= 3);
        for broke in &broke {
            assert!([broke.body, broke.other].contains(&bricks[top]));
            assert_eq!((broke.how, broke.stress), (MortarFailure::Misfit, 0.0));
        }
        assert_eq!(bonds(&mut lab), count - broke.len());
        for (i, (&brick, start)) in bricks.iter().zip(starts).enumerate() {
            let moved = lab.position(brick).distance(start);
            assert!(i == top || moved < 1e-4, "{i} {moved}");
        }
        // It falls freely.
        let fallen = 6.0 - lab.position(bricks[top]).y;
        assert!((fallen - 0.44).abs() < 0.05, "{fallen}");
    }
}

#[derive(Resource, Default)]
struct Heard(Vec<(Entity, Entity)>);

#[test]
fn both_bodies_hear_of_it() {
    let mut lab = Lab::shipped(1.0 / 60.0);
    lab.world.init_resource::<Heard>();
    lab.world
        .add_observer(|broke: On<MortarBroke>, mut heard: ResMut<Heard>| {
            heard.0.push((broke.body, broke.other));
        });
    lab.world.flush();
    let all = cantilever(&mut lab, 2, tensile(1e3));
    lab.run(0.1);
    let heard = &lab.world.resource::<Heard>().0;
    assert!(heard.contains(&(all[0], all[1])) && heard.contains(&(all[1], all[0])));
}
