//! Joints: what each type does, edits at run time, bad input, breaking, copies, sleep, and scenes.

mod breaking;
mod cone;
mod edits;
mod input;
mod loose;
mod scenes;
mod sleep;
mod swept;
mod table;
mod types;
mod worlds;

use bevy_ecs::message::Messages;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::prelude::*;
use support::Lab;

/// A body of this mass (kg) without forces but gravity.
fn body(lab: &mut Lab, collider: Collider, mass: f32, at: Vec3) -> Entity {
    let body = (RigidBody::Dynamic, collider, Mass(mass));
    lab.spawn((body, Transform::from_translation(at)))
}

fn ball(lab: &mut Lab, mass: f32, at: Vec3) -> Entity {
    body(lab, Collider::ball(0.1), mass, at)
}

/// The force of a joint on body 2, N.
fn forces(lab: &Lab, joint: Entity) -> JointForces {
    *lab.world.get::<JointForces>(joint).unwrap()
}

/// The messages of a kind since the last call.
fn drain<T: Message>(lab: &mut Lab) -> Vec<T> {
    lab.world.resource_mut::<Messages<T>>().drain().collect()
}

/// A chain of capsules that hangs from the world at a point; the first is the uppermost. Each of its links is 0.4 m long.
fn chain(lab: &mut Lab, links: usize, mass: f32, from: Vec3) -> (Vec<Entity>, Vec<Entity>) {
    let link = Collider::capsule(0.05, 0.3);
    let mut joints = Vec::new();
    let mut bodies: Vec<Entity> = Vec::new();
    for i in 0..links {
        let top = from - Vec3::Y * (0.4 * i as f32);
        let new = body(lab, link.clone(), mass, top - Vec3::Y * 0.2);
        let joint = SphericalJoint::new(bodies.last().copied(), new).with_anchor(top);
        joints.push(lab.spawn(joint));
        bodies.push(new);
    }
    (bodies, joints)
}
