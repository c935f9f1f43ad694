//! Dynamic bodies below a kinematic body that is moved by its `Transform` stay where they are in the world.
//!
//! Such a body gets the velocity that takes it to its new place by the end of the step, and friction takes along what lies on it. If the
//! hierarchy did so too, a brick on a ship would move twice as far as the ship. So the `Transform` of each dynamic body below is replaced
//! by the one that leaves the body where it was when the last step ended, before *prepare* compares the two.

use crate::body::{
    BodyTable, Pose, RigidBody, Teleport, local_pose, parts::scale_of, user_pose, velocity_between,
};
use crate::components::holders_in;
use crate::settings::{SpeedLimits, StepTime};
use bevy_ecs::component::Components;
use bevy_ecs::entity::EntityHashSet;
use bevy_ecs::hierarchy::{ChildOf, Children};
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use glam::Vec3;

type Placed = QueryState<(&'static Transform, Option<&'static ChildOf>)>;

/// Rounding of a pose that is computed by way of another frame, as a share of the coordinates; and of the parts of a rotation. Those of a
/// frame may not be of unit length, because users turn it.
const POSITION_ROUNDING: f32 = 1e-6;
const ROTATION_ROUNDING: f32 = 1e-5;

/// Part of the stage *prepare*.
pub fn stay(world: &mut World, placed: &mut Placed) {
    let all = [
        Components::component_id::<Children>,
        Components::component_id::<RigidBody>,
    ];
    let sent = holders_in(world, &all).into_iter();
    let sent: EntityHashSet = sent.filter(|&body| is_sent(world, placed, body)).collect();
    for &carrier in &sent {
        let mut above = world.get::<ChildOf>(carrier).map(ChildOf::parent);
        while let Some(at) = above.filter(|at| !sent.contains(at)) {
            above = world.get::<ChildOf>(at).map(ChildOf::parent);
        }
        // Those below another one are found from there.
        if above.is_none() {
            visit(world, placed, carrier);
        }
    }
}

/// Visits the entities below a kinematic body, parents before their children.
fn visit(world: &mut World, placed: &mut Placed, carrier: Entity) {
    let mut stack = Vec::new();
    descend(world, carrier, before(world, carrier), &mut stack);
    // `frame` is that of the parent as it was when the last step ended.
    while let Some((at, frame)) = stack.pop() {
        let Some(&local) = world.get::<Transform>(at) else {
            continue;
        };
        let mut here = frame.mul_transform(local);
        let table = world.resource::<BodyTable>();
        if table.slot_of(world, at).is_some() {
            match world.get::<RigidBody>(at) {
                Some(RigidBody::Dynamic) => {
                    let put = Pose {
                        position: here.translation,
                        // Rounding makes it longer from step to step, and *prepare* bears that.
                        rotation: here.rotation.normalize(),
                    };
                    let arm = here.translation.distance(frame.translation);
                    let known = world.get::<Pose>(at).copied();
                    // A body that the user has moved below its parent goes there.
                    let pose = known
                        .filter(|known| is_near(known, &put, arm))
                        .unwrap_or(put);
                    let parent = world.get::<ChildOf>(at);
                    let local = local_pose(pose, parent, placed.query(world));
                    // A frame of size zero has no inside.
                    if local.is_finite()
                        && let Some(mut transform) = world.get_mut::<Transform>(at)
                    {
                        (transform.translation, transform.rotation) =
                            (local.position, local.rotation);
                    }
                    (here.translation, here.rotation) = (pose.position, pose.rotation);
                }
                Some(RigidBody::Kinematic) if is_sent(world, placed, at) => {
                    here = before(world, at);
                }
                // A static body is moved at once, and so is what is below it.
                _ => continue,
            }
        }
        descend(world, at, here, &mut stack);
    }
}

fn descend(world: &World, at: Entity, frame: Transform, stack: &mut Vec<(Entity, Transform)>) {
    if let Some(children) = world.get::<Children>(at) {
        stack.extend(children.iter().map(|child| (child, frame)));
    }
}

/// The frame of a body when the last step ended.
fn before(world: &World, body: Entity) -> Transform {
    let pose = world.get::<Pose>(body).copied().unwrap_or_default();
    Transform {
        translation: pose.position,
        rotation: pose.rotation,
        scale: scale_of(world, body),
    }
}

/// Whether *prepare* will give a body the velocity that takes it to its `Transform`.
fn is_sent(world: &World, placed: &mut Placed, body: Entity) -> bool {
    let is_kinematic = world.get::<RigidBody>(body) == Some(&RigidBody::Kinematic);
    if !is_kinematic || world.get::<Teleport>(body).is_some() {
        return false;
    }
    let table = world.resource::<BodyTable>();
    let state = table.slot_of(world, body).and_then(|slot| table.get(slot));
    let (Some(state), Some(transform), Some(&pose)) =
        (state, world.get::<Transform>(body), world.get::<Pose>(body))
    else {
        return false;
    };
    let placement = (transform, world.get::<ChildOf>(body));
    let (time, speeds) = (
        world.resource::<StepTime>(),
        world.resource::<SpeedLimits>(),
    );
    user_pose(placement, pose, false, placed.query(world)).is_some_and(|to| {
        let center = state.mass.local_center;
        to.is_finite() && speeds.allow(&velocity_between(&pose, &to, center, time.whole()))
    })
}

/// Whether two poses differ by rounding; `arm` is the distance from the frame by way of which one of them was computed, m.
fn is_near(one: &Pose, other: &Pose, arm: f32) -> bool {
    let far = one.position.abs().max_element() + 1.0;
    let turn = |sign: f32| {
        let off = one.rotation.to_array().into_iter();
        let off = off.zip(other.rotation.to_array());
        off.fold(0.0, |most: f32, (a, b)| most.max((a - sign * b).abs()))
    };
    let off: Vec3 = (one.position - other.position).abs();
    off.max_element() <= POSITION_ROUNDING * far + ROTATION_ROUNDING * arm
        && turn(1.0).min(turn(-1.0)) <= ROTATION_ROUNDING
}
