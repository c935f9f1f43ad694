//! Joints whose bodies come and go.

use super::*;
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::message::Messages;

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
