//! Joints whose bodies come and go.

use super::*;
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::message::Messages;
use drystone::diagnosis::BodyProblem;

fn errors(world: &mut World) -> Vec<String> {
    let mut errors = world.resource_mut::<Messages<JointError>>();
    errors.drain().map(|error| error.to_string()).collect()
}

/// How a body is taken out of the simulation for a while.
#[derive(Clone, Copy, Debug)]
enum Out {
    RigidBodyDisabled,
    Disabled,
    Streamed,
    Quarantined,
}

const ALL: [Out; 4] = [
    Out::RigidBodyDisabled,
    Out::Disabled,
    Out::Streamed,
    Out::Quarantined,
];

impl Out {
    /// Takes the body out, and returns what puts it back.
    fn take(self, world: &mut World, body: Entity) -> Box<dyn FnOnce(&mut World)> {
        match self {
            Self::RigidBodyDisabled => {
                world.entity_mut(body).insert(RigidBodyDisabled);
                Box::new(move |world| _ = world.entity_mut(body).remove::<RigidBodyDisabled>())
            }
            Self::Disabled => {
                world.entity_mut(body).insert(Disabled);
                Box::new(move |world| _ = world.entity_mut(body).remove::<Disabled>())
            }
            Self::Streamed => {
                let region = drystone::streaming::take_out(world, [body]).unwrap();
                Box::new(move |world| _ = drystone::streaming::put_back(world, region))
            }
            Self::Quarantined => {
                world.entity_mut(body).insert(Mass(f32::NAN));
                Box::new(move |world| {
                    world.entity_mut(body).insert(Mass(1.0));
                })
            }
        }
    }
}

/// A cube asleep on the ground.
fn cube_on_ground(world: &mut World) -> Entity {
    world.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
    let body = world
        .spawn((RigidBody::Dynamic, cube(1.0), at(0.0, 0.5, 0.0)))
        .id();
    steps(world, 120);
    body
}

/// Lifts the ground away: only the joint holds the body.
fn holds(world: &mut World, body: Entity) -> bool {
    let grounds: Vec<Entity> = world
        .query::<(Entity, &RigidBody)>()
        .iter(world)
        .filter(|(_, kind)| **kind == RigidBody::Static)
        .map(|(entity, _)| entity)
        .collect();
    for ground in grounds {
        world.despawn(ground);
    }
    steps(world, 60);
    (position(world, body).y - 0.5).abs() < 0.01
}

#[test]
fn a_joint_to_a_body_that_is_out_waits_without_an_error() {
    for out in ALL {
        for swapped in [false, true] {
            let mut app = app();
            let world = app.world_mut();
            let body = cube_on_ground(world);
            let back = out.take(world, body);
            steps(world, 2);
            let ends = if swapped {
                [Some(body), None]
            } else {
                [None, Some(body)]
            };
            let joint = world.spawn(FixedJoint::new(ends[0], ends[1])).id();
            steps(world, 2);
            assert_eq!(errors(world), Vec::<String>::new(), "{out:?}");
            assert!(world.get::<QuarantinedJoint>(joint).is_none());
            back(world);
            steps(world, 2);
            assert!(holds(world, body), "{out:?}");
            assert_eq!(errors(world), Vec::<String>::new(), "{out:?}");
        }
    }
}

#[test]
fn a_joint_acts_again_when_its_body_comes_back() {
    // A body that has a joint cannot be taken out by streaming.
    for out in [Out::RigidBodyDisabled, Out::Disabled, Out::Quarantined] {
        let mut app = app();
        let world = app.world_mut();
        let body = cube_on_ground(world);
        world.spawn(FixedJoint::new(None, body));
        steps(world, 2);
        let back = out.take(world, body);
        steps(world, 5);
        back(world);
        steps(world, 2);
        assert_eq!(errors(world), Vec::<String>::new(), "{out:?}");
        assert!(holds(world, body), "{out:?}");
    }
}

#[test]
fn a_joint_to_what_is_no_body_is_an_error_still() {
    let mut app = app();
    let world = app.world_mut();
    let body = world.spawn((RigidBody::Dynamic, cube(1.0))).id();
    let other = world.spawn(Transform::default()).id();
    let gone = world.spawn_empty().id();
    world.despawn(gone);
    for none in [other, gone] {
        world.spawn(FixedJoint::new(none, body));
        steps(world, 1);
        assert_eq!(errors(world).len(), 1);
    }
}

/// Takes steps, and returns what was said of bodies.
fn warnings(world: &mut World, count: usize) -> Vec<(Entity, BodyProblem)> {
    let mut all = Vec::new();
    for _ in 0..count {
        steps(world, 1);
        let mut errors = world.resource_mut::<Messages<BodyError>>();
        all.extend(errors.drain().map(|error| (error.entity, error.problem)));
    }
    all
}

/// Two bodies with a joint between them, of 1 kg and `ratio` kg.
fn pair(world: &mut World, ratio: f32, swapped: bool) -> [Entity; 2] {
    let body = |mass, x| {
        (
            RigidBody::Dynamic,
            cube(0.5),
            Mass(mass),
            GravityScale(0.0),
            at(x, 0.0, 0.0),
        )
    };
    let [light, heavy] = [body(1.0, 0.0), body(ratio, 2.0)].map(|body| world.spawn(body).id());
    let ends = if swapped {
        [heavy, light]
    } else {
        [light, heavy]
    };
    world.spawn(FixedJoint::new(ends[0], ends[1]));
    [light, heavy]
}

#[test]
fn a_joint_at_an_extreme_mass_ratio_is_told_once() {
    for swapped in [false, true] {
        let mut app = app();
        let world = app.world_mut();
        let [light, heavy] = pair(world, 1e7, swapped);
        // It counts also where one body dominates the other in contacts.
        world.entity_mut(light).insert(Dominance(1));
        let problem = BodyProblem::ExtremeJointRatio { other: light };
        assert_eq!(warnings(world, 30), [(heavy, problem)]);
        assert!(world.get::<Quarantined>(heavy).is_none());
    }
}

#[test]
fn usual_joints_are_not_warned_of() {
    for ratio in [1.0, 1e3, 5e4] {
        let mut app = app();
        let world = app.world_mut();
        pair(world, ratio, false);
        let anchor = world
            .spawn((RigidBody::Kinematic, cube(1.0), at(0.0, 9.0, 0.0)))
            .id();
        let body = (RigidBody::Dynamic, cube(0.1), Mass(1e-3), at(0.0, 7.0, 0.0));
        let body = world.spawn(body).id();
        world.spawn(FixedJoint::new(anchor, body));
        assert_eq!(warnings(world, 10), [], "{ratio}");
    }
}

/// A body that dominates is as good as infinitely heavy, whatever it weighs.
#[test]
fn masses_in_contact_are_not_warned_of_where_they_do_not_count() {
    for dominance in [0, 1, -1] {
        let mut app = app();
        let world = app.world_mut();
        world.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
        world.spawn((RigidBody::Dynamic, cube(1.0), Mass(1e5), at(0.0, 0.5, 0.0)));
        let feather = (
            RigidBody::Dynamic,
            cube(1.0),
            Mass(1.0),
            Dominance(dominance),
        );
        world.spawn((feather, at(0.0, 1.5, 0.0)));
        assert_eq!(
            warnings(world, 10).len(),
            usize::from(dominance == 0),
            "{dominance}"
        );
    }
}
