//! Edits of joints at run time, between any two stages too.

use super::{ball, body, chain, drain, forces};
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::body::Inactive;
use drystone::diagnosis::BodyProblem;
use drystone::prelude::*;
use drystone::schedule::{PhysicsSchedule, PhysicsSystems};
use support::Lab;

/// A pendulum at rest below its hook, asleep.
fn asleep() -> (Lab, Entity, Entity) {
    let mut lab = Lab::new();
    lab.dt = 1.0 / 60.0;
    let bob = ball(&mut lab, 1.0, Vec3::ZERO);
    let hook = lab.spawn(SphericalJoint::new(None, bob).with_anchor(Vec3::Y));
    lab.run(2.0);
    assert!(lab.world.get::<Sleeping>(bob).unwrap().asleep, "it sleeps");
    assert!(lab.world.entity(bob).contains::<Inactive>());
    (lab, bob, hook)
}

fn sleeps(lab: &Lab, body: Entity) -> bool {
    lab.world.get::<Sleeping>(body).unwrap().asleep
}

#[test]
fn removing_a_joint_in_any_way_wakes_its_bodies() {
    type Remove = fn(&mut World, Entity);
    let ways: [(&str, Remove); 5] = [
        ("despawn", |world, hook| _ = world.despawn(hook)),
        ("remove", |world, hook| {
            world.entity_mut(hook).remove::<SphericalJoint>();
        }),
        ("disable", |world, hook| {
            world.entity_mut(hook).insert(JointDisabled);
        }),
        ("disable the entity", |world, hook| {
            world.entity_mut(hook).insert(Disabled);
        }),
        ("invalid", |world, hook| {
            let mut joint = world.get_mut::<SphericalJoint>(hook).unwrap();
            joint.friction = f32::NAN;
        }),
    ];
    for (name, remove) in ways {
        let (mut lab, bob, hook) = asleep();
        remove(&mut lab.world, hook);
        lab.run(0.5);
        assert!(
            lab.position(bob).y < -1.0,
            "{name}: it falls: {}",
            lab.position(bob)
        );
    }
}

#[test]
fn a_joint_that_is_switched_on_again_works_again() {
    type Switch = fn(&mut EntityWorldMut);
    let ways: [(Switch, Switch); 2] = [
        (
            |hook| _ = hook.insert(JointDisabled),
            |hook| _ = hook.remove::<JointDisabled>(),
        ),
        (
            |hook| _ = hook.insert(Disabled),
            |hook| _ = hook.remove::<Disabled>(),
        ),
    ];
    for (off, on) in ways {
        let (mut lab, bob, hook) = asleep();
        off(&mut lab.world.entity_mut(hook));
        lab.run(0.2);
        assert_eq!(forces(&lab, hook), JointForces::default());
        on(&mut lab.world.entity_mut(hook));
        lab.run(1.0);
        let far = lab.position(bob).distance(Vec3::Y);
        assert!((far - 1.0).abs() < 0.01, "{far}");
    }
}

#[test]
fn a_change_wakes_and_an_equal_value_does_not() {
    let (mut lab, bob, hook) = asleep();
    let mut joint = lab.world.get_mut::<SphericalJoint>(hook).unwrap();
    joint.set_changed();
    lab.run(0.1);
    assert!(sleeps(&lab, bob), "nothing has changed");
    let mut joint = lab.world.get_mut::<SphericalJoint>(hook).unwrap();
    joint.frame1.anchor = JointAnchor::Local(Vec3::Y * 1.5);
    lab.step();
    assert!(!sleeps(&lab, bob));
    lab.run(3.0);
    assert!(
        (lab.position(bob).y - 0.5).abs() < 0.01,
        "{}",
        lab.position(bob)
    );
}

#[test]
fn a_joint_that_is_added_wakes_both() {
    let mut lab = Lab::new();
    lab.dt = 1.0 / 60.0;
    lab.ground();
    let [one, other] = [0.0, 3.0].map(|x| lab.cube(Vec3::new(x, 0.5, 0.0)));
    lab.run(2.0);
    assert!(sleeps(&lab, one) && sleeps(&lab, other));
    lab.spawn(DistanceJoint::new(one, other));
    lab.step();
    assert!(!sleeps(&lab, one) && !sleeps(&lab, other));
    // They are one structure now, and sleep together.
    lab.run(2.0);
    assert!(sleeps(&lab, one) && sleeps(&lab, other));
    let structure = supports(&mut lab.world, |supports| supports.structure(one)).unwrap();
    assert_eq!(structure, [one, other]);
    lab.set_velocity(other, Vec3::X * 0.01, Vec3::ZERO);
    lab.step();
    assert!(!sleeps(&lab, one), "they wake together");
}

#[test]
fn jointed_bodies_do_not_collide_unless_asked() {
    let mut lab = Lab::shipped(1.0 / 60.0);
    lab.world.insert_resource(Gravity(Vec3::ZERO));
    let one = lab.cube(Vec3::ZERO);
    let other = lab.cube(Vec3::X * 0.5);
    let joint = lab.spawn(SphericalJoint::new(one, other));
    lab.run(0.5);
    let pairs = |lab: &mut Lab| lab.world.query::<&ContactPair>().iter(&lab.world).count();
    assert_eq!(pairs(&mut lab), 0);
    assert_eq!(lab.position(other), Vec3::X * 0.5);
    assert_eq!(lab.world.get::<CollisionExceptions>(one), None);
    // A second joint changes nothing, nor does its end.
    let second = lab.spawn(SphericalJoint::new(other, one));
    lab.run(0.1);
    lab.world.despawn(second);
    lab.run(0.1);
    assert_eq!(pairs(&mut lab), 0);
    lab.world
        .get_mut::<SphericalJoint>(joint)
        .unwrap()
        .collision = true;
    lab.run(0.1);
    assert_eq!(pairs(&mut lab), 1);
    lab.world
        .get_mut::<SphericalJoint>(joint)
        .unwrap()
        .collision = false;
    lab.run(0.1);
    assert_eq!(pairs(&mut lab), 0);
    // When the joint goes they are pushed apart.
    lab.world.despawn(joint);
    lab.run(2.0);
    let far = lab.position(one).distance(lab.position(other));
    assert!(far > 0.9, "{far}");
}

#[test]
fn a_despawned_body_is_reported_and_the_joint_waits_for_another() {
    let mut lab = Lab::shipped(1.0 / 60.0);
    let (bodies, joints) = chain(&mut lab, 3, 1.0, Vec3::Y * 2.0);
    lab.world
        .entity_mut(joints[1])
        .insert(Name::new("weak link"));
    lab.run(0.5);
    lab.world.despawn(bodies[0]);
    lab.step();
    let told = drain::<JointError>(&mut lab);
    assert_eq!(told.len(), 2, "{told:?}");
    assert_eq!(told[1].joint, joints[1]);
    assert_eq!(
        told[1].problem,
        JointProblem::NotABody { entity: bodies[0] }
    );
    let line = told[1].to_string();
    for part in ["weak link", &bodies[0].to_string(), &bodies[1].to_string()] {
        assert!(line.contains(part), "{line}");
    }
    lab.run(0.3);
    assert_eq!(drain::<JointError>(&mut lab), [], "only once");
    assert!(lab.position(bodies[2]).y < 0.9, "the rest falls");
    // Tied to the world, it holds again.
    let mut joint = lab.world.get_mut::<SphericalJoint>(joints[1]).unwrap();
    joint.body1 = None;
    joint.frame1.anchor = JointAnchor::Local(Vec3::Y * 2.0);
    lab.run(4.0);
    assert!(!lab.world.entity(joints[1]).contains::<QuarantinedJoint>());
    assert!(
        (lab.position(bodies[1]).y - 1.8).abs() < 0.02,
        "{}",
        lab.position(bodies[1])
    );
}

use drystone::joint::JointProblem;

#[test]
fn a_joint_waits_for_a_disabled_body() {
    let mut lab = Lab::shipped(1.0 / 60.0);
    let (bodies, joints) = chain(&mut lab, 2, 1.0, Vec3::Y * 2.0);
    lab.run(0.5);
    lab.world.entity_mut(bodies[0]).insert(Disabled);
    lab.run(0.05);
    assert_eq!(forces(&lab, joints[1]), JointForces::default());
    lab.world.entity_mut(bodies[0]).remove::<Disabled>();
    lab.run(1.5);
    assert_eq!(drain::<JointError>(&mut lab), []);
    let far = lab.position(bodies[1]).distance(lab.position(bodies[0]));
    assert!((far - 0.4).abs() < 0.02, "{far}");
    assert_eq!(lab.errors(), []);
}

#[test]
fn bodies_may_come_later_than_the_joint() {
    let mut lab = Lab::shipped(1.0 / 60.0);
    let later = lab.world.spawn_empty().id();
    let joint = lab.spawn(SphericalJoint::new(None, later).with_anchor(Vec3::Y));
    lab.run(0.2);
    assert_eq!(drain::<JointError>(&mut lab).len(), 1);
    let shape = (RigidBody::Dynamic, Collider::ball(0.1), Mass(1.0));
    lab.world
        .entity_mut(later)
        .insert((shape, Transform::default()));
    lab.run(1.0);
    assert!(!lab.world.entity(joint).contains::<QuarantinedJoint>());
    assert!(
        lab.position(later).length() < 5e-3,
        "{}",
        lab.position(later)
    );
}

#[derive(Resource)]
struct Dice(fastrand::Rng);

/// Random edits of joints and their bodies.
fn fuzz(world: &mut World) {
    let mut dice = world.resource::<Dice>().0.clone();
    let mut joints = world.query_filtered::<Entity, With<JointForces>>();
    let joints: Vec<Entity> = joints.iter(world).collect();
    let mut bodies = world.query_filtered::<Entity, (With<Collider>, With<Mass>)>();
    let bodies: Vec<Entity> = bodies.iter(world).collect();
    for _ in 0..dice.u8(0..3) {
        let (Some(&one), Some(&other)) = (dice.choice(&bodies), dice.choice(&bodies)) else {
            break;
        };
        let joint = dice.choice(&joints).copied();
        let joint = joint.and_then(|joint| world.get_entity_mut(joint).ok());
        match (dice.u8(0..14), joint) {
            (0, _) => _ = world.spawn(SphericalJoint::new(one, other)),
            (1, _) => _ = world.spawn(FixedJoint::new(None, other)),
            (2, _) => _ = world.spawn(DistanceJoint::new(one, None).with_max_distance(3.0)),
            (3, Some(joint)) => joint.despawn(),
            (4, Some(mut joint)) => _ = joint.insert(JointDisabled),
            (5, Some(mut joint)) => _ = joint.remove::<JointDisabled>(),
            (6, Some(mut joint)) => _ = joint.remove::<(SphericalJoint, FixedJoint)>(),
            (7, Some(mut joint)) => _ = joint.insert(Disabled),
            (8, Some(mut joint)) => {
                if let Some(mut of) = joint.get_mut::<SphericalJoint>() {
                    of.friction = if dice.bool() { 10.0 } else { f32::NAN };
                }
            }
            (9, Some(mut joint)) => {
                if let Some(mut of) = joint.get_mut::<SphericalJoint>() {
                    of.body1 = Some(one);
                    of.collision = dice.bool();
                }
            }
            (10, Some(mut joint)) => _ = joint.remove::<JointForces>(),
            (11, Some(mut joint)) => _ = joint.insert(BreakForce::new(500.0)),
            (12, _) => _ = world.despawn(one),
            (_, _) => {
                let at = Transform::from_xyz(4.0 * dice.f32(), 3.0 + dice.f32(), 0.0);
                let brick = Collider::cuboid(1.0, 0.5, 0.5);
                world.spawn((RigidBody::Dynamic, brick, Mass(50.0), at));
            }
        }
    }
    world.resource_mut::<Dice>().0 = dice;
}

#[test]
fn edits_between_two_stages_never_panic() {
    for preset in [
        SolverSettings::default(),
        SolverSettings::new(drystone::solver::Nncg::default()),
    ] {
        for gap in PhysicsSystems::ORDER.array_windows() {
            let [earlier, later] = *gap;
            let mut lab = Lab::new();
            lab.dt = 1.0 / 60.0;
            lab.world.insert_resource(preset.clone());
            lab.world.insert_resource(Dice(fastrand::Rng::with_seed(5)));
            lab.ground();
            chain(&mut lab, 5, 2.0, Vec3::Y * 4.0);
            for i in 0..4 {
                lab.cube(Vec3::new(1.5 * i as f32, 0.5, 0.0));
            }
            let mut schedules = lab.world.resource_mut::<Schedules>();
            let physics = schedules.get_mut(PhysicsSchedule).unwrap();
            let between = fuzz.run_if(resource_exists::<Dice>);
            physics.add_systems(between.after(earlier).before(later).ambiguous_with_all());
            for _ in 0..200 {
                lab.step();
            }
            // Joints that contradict each other may make a solve diverge; it is undone and reported then.
            for error in lab.errors() {
                assert_eq!(error.problem, BodyProblem::Diverged, "{gap:?}");
            }
            // Left alone, everything comes to rest, and what has no joint lies on the ground.
            lab.world.remove_resource::<Dice>();
            let mut joints = lab
                .world
                .query_filtered::<Entity, (With<JointForces>, Allow<Disabled>)>();
            for joint in joints.iter(&lab.world).collect::<Vec<_>>() {
                lab.world.despawn(joint);
            }
            lab.run(5.0);
            let mut bodies = lab.world.query_filtered::<&Pose, With<RigidBody>>();
            for pose in bodies.iter(&lab.world) {
                assert!(
                    pose.is_finite() && pose.position.y > -0.1,
                    "{gap:?}: {pose:?}"
                );
            }
        }
    }
}

/// A motor that is driven from a system in each step.
#[test]
fn a_motor_may_be_changed_in_every_step() {
    let mut lab = Lab::shipped(1.0 / 60.0);
    lab.world.insert_resource(Gravity(Vec3::ZERO));
    let arm = body(
        &mut lab,
        Collider::cuboid(1.0, 0.1, 0.1),
        1.0,
        Vec3::X * 0.5,
    );
    let hinge = RevoluteJoint::new(None, arm).with_anchor(Vec3::ZERO);
    let hinge = lab.spawn(hinge);
    for step in 0..120 {
        let angle = 0.01 * step as f32;
        let mut joint = lab.world.get_mut::<RevoluteJoint>(hinge).unwrap();
        joint.motor = Some(JointMotor::servo(angle, 1_000.0));
        lab.step();
    }
    let at = lab.position(arm);
    assert!((f32::atan2(at.y, at.x) - 1.19).abs() < 0.02, "{at}");
}
