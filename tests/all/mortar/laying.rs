//! What is bonded, and when.

use super::*;
use bevy_ecs::entity_disabling::Disabled;
use drystone::masonry::{Bond, Wall};
use drystone::preview::{Edit, preview};

#[test]
fn mortar_is_used_up_by_what_it_touches_first() {
    let mut lab = Lab::shipped(1.0 / 60.0);
    root(&mut lab, Vec3::ZERO);
    // One that lies, one that is dropped, and one that never touches anything.
    let laid = brick(&mut lab, Vec3::Y * EDGE, Mortar::default());
    let dropped = brick(&mut lab, Vec3::Y * (2.0 * EDGE + 0.3), Mortar::default());
    lab.world.spawn((
        RigidBody::Static,
        cube(),
        Transform::from_xyz(5.0, 0.0, 0.0),
        Mortar::default(),
    ));
    lab.step();
    assert_eq!(bonds(&mut lab), 1);
    let fresh = |lab: &mut Lab| {
        let mut fresh = lab.world.query::<&Mortar>();
        fresh.iter(&lab.world).count()
    };
    assert!(!lab.world.entity(laid).contains::<Mortar>());
    assert_eq!(fresh(&mut lab), 2);
    lab.run(0.2);
    assert!(lab.velocity(dropped).linear.y < -1.0);
    assert_eq!(bonds(&mut lab), 1, "it falls");
    lab.run(1.0);
    assert_eq!((bonds(&mut lab), fresh(&mut lab)), (2, 1));
    // The drop has not broken the bond below.
    assert!(broken(&mut lab).is_empty());
    assert!(lab.position(dropped).distance(Vec3::Y * 2.0 * EDGE) < 2e-3);
}

/// Dry bricks are bonded as they lie once they get mortar, asleep or not.
#[test]
fn a_dry_wall_can_be_bonded_later() {
    for sleeps in [false, true] {
        let mut lab = if sleeps {
            Lab::new()
        } else {
            Lab::shipped(1.0 / 60.0)
        };
        let ground = lab.ground();
        let blocks = Wall::new(Bond::Running).blocks().unwrap().into_iter();
        let bricks: Vec<Entity> = blocks.map(|block| lab.spawn(block.bundle())).collect();
        lab.run(2.0);
        assert_eq!(bonds(&mut lab), 0);
        let starts: Vec<Vec3> = bricks.iter().map(|&brick| lab.position(brick)).collect();
        for &brick in &bricks {
            lab.world.entity_mut(brick).insert(FOREVER);
        }
        lab.run(1.0);
        // Rows of 5, 6, … bricks: with their beds on the ground, between courses, and heads.
        let count = bonds(&mut lab);
        assert!(count > 80, "{count}");
        for (&brick, start) in bricks.iter().zip(&starts) {
            assert!(lab.position(brick).distance(*start) < 1e-4);
        }
        // It now hangs on what is left of its lowest course.
        for &brick in &bricks[1..5] {
            lab.world.despawn(brick);
        }
        lab.run(1.0);
        let last = bricks.len() - 1;
        assert!(lab.position(bricks[last]).distance(starts[last]) < 1e-3);
        assert!(lab.world.get_entity(ground).is_ok());
    }
}

/// The weaker of two mortars counts.
#[test]
fn the_weaker_mortar_counts() {
    let mut lab = Lab::shipped(1.0 / 60.0);
    brick(&mut lab, Vec3::ZERO, Mortar::new(3e5, 1e5));
    brick(&mut lab, Vec3::Y * EDGE, Mortar::new(2e5, 4e5));
    lab.step();
    let mut joints = lab.world.query::<&MortarJoint>();
    let found = joints.single(&lab.world).unwrap().mortar;
    assert_eq!(found, Mortar::new(2e5, 1e5));
}

#[test]
fn bad_mortar_does_not_bond() {
    for bad in [f32::NAN, -1.0] {
        let mut lab = Lab::shipped(1.0 / 60.0);
        root(&mut lab, Vec3::ZERO);
        let loose = brick(&mut lab, Vec3::X * EDGE, tensile(bad));
        lab.run(0.5);
        assert!(!lab.world.entity(loose).contains::<Mortar>());
        assert!(lab.position(loose).y < -0.5, "it is dry");
    }
}

/// Edges and corners do not bond, and neither do balls.
#[test]
fn only_faces_bond() {
    let mut lab = Lab::shipped(1.0 / 60.0);
    lab.ground();
    let ball = lab.body(Collider::ball(0.5), Vec3::Y * 0.5);
    lab.world.entity_mut(ball).insert(Mortar::default());
    let on_edge = Transform::from_xyz(3.0, EDGE * 0.5f32.sqrt(), 0.0)
        .with_rotation(Quat::from_rotation_z(std::f32::consts::FRAC_PI_4));
    lab.spawn((RigidBody::Dynamic, cube(), on_edge, Mortar::default()));
    lab.step();
    assert_eq!(bonds(&mut lab), 0);
}

/// A brick that is disabled and enabled again is where it was, bonded: edits are undone like that.
#[test]
fn a_brick_that_comes_back_is_still_bonded() {
    let mut lab = Lab::shipped(1.0 / 60.0);
    let all = cantilever(&mut lab, 2, FOREVER);
    lab.run(0.5);
    lab.world.entity_mut(all[2]).insert(Disabled);
    lab.run(0.5);
    lab.world.entity_mut(all[2]).remove::<Disabled>();
    lab.run(0.5);
    assert!(
        lab.position(all[2])
            .distance(Vec3::new(2.0 * EDGE, 10.0, 0.0))
            < 1e-3
    );
    assert!(broken(&mut lab).is_empty());
}

#[test]
fn previews_take_bonds_along() {
    let mut lab = Lab::new();
    let all = cantilever(&mut lab, 5, tensile(0.45e6));
    lab.run(2.0);
    let moved = |edit: &Edit| {
        let preview = preview(&lab.world, edit).unwrap();
        let moved = preview.moved.iter();
        moved.map(|moved| moved.body).collect::<Vec<_>>()
    };
    assert_eq!(moved(&Edit::Remove(vec![all[5]])), []);
    assert_eq!(moved(&Edit::Remove(vec![all[3]])), [all[4], all[5]]);
    let on = |i: usize| {
        let position = lab.position(all[i]) + Vec3::Y * (EDGE + 0.002);
        let pose = drystone::body::Pose {
            position,
            ..Default::default()
        };
        // 250 kg by its density.
        Edit::Place(Collider::cuboid(EDGE, EDGE, EDGE), pose)
    };
    assert_eq!(moved(&on(1)), []);
    assert_eq!(moved(&on(5)), all[1..]);
}
