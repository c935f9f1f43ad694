//! Which bodies have gone farther in a step than they were meant to, and left their box in the tree: one that was hit, say. The next step finds
//! out by itself; who asks the world until then ([`query`](crate::query)) has to look at them beside the tree.

use super::{Broadphase, expected_travel};
use crate::body::{BodyIndex, BodyState, BodyTable, Inactive, Pose, Quarantined};
use crate::settings::{Gravity, StepTime};
use bevy_ecs::prelude::*;
use parry3d::bounding_volume::BoundingVolume;

/// After the stage *integration*. See the module's text.
pub fn escaped_aabb(
    mut broadphase: ResMut<Broadphase>,
    table: Res<BodyTable>,
    time: Res<StepTime>,
    gravity: Res<Gravity>,
    bodies: Query<
        (Entity, &BodyIndex, &Pose),
        (Changed<Pose>, Without<Quarantined>, Without<Inactive>),
    >,
) {
    broadphase.escaped_aabb.clear();
    for (entity, index, pose) in &bodies {
        let body = table.get(index.0).filter(|body| body.entity == entity);
        if let Some(body) = body
            && way(body, pose) > expected_travel(body, gravity.0, time.dt)
            && let Some(shape) = body.shape()
            && let Some(fat) = &broadphase.fat[index.0 as usize]
            && !fat.contains(&shape.compute_aabb(&pose.to_parry()))
        {
            broadphase.escaped_aabb.push(index.0);
        }
    }
    broadphase.escaped_aabb.sort_unstable();
}

/// Bound on how far a point of a body has come since the start of the step, m.
fn way(body: &BodyState, pose: &Pose) -> f32 {
    let center = pose.transform_point(body.mass.local_center);
    let turned = pose.rotation * body.pose.rotation.inverse();
    center.distance(body.center) + 2.0 * turned.xyz().length() * body.radius
}
