//! Bodies that moved farther in a step than expected and left their box in the tree, for example after an impact. The next step updates
//! their boxes. Until then [queries](crate::query) must test these bodies in addition to the tree.

use super::{Broadphase, expected_travel};
use crate::body::{ActiveBodies, BodyState, BodyTable, Pose};
use crate::settings::{Gravity, StepTime};
use bevy_ecs::prelude::*;
use parry3d::bounding_volume::BoundingVolume;

/// Finds the bodies that have left their box. It runs after the stage *integration*.
pub fn escaped_aabb(
    mut broadphase: ResMut<Broadphase>,
    table: Res<BodyTable>,
    time: Res<StepTime>,
    gravity: Res<Gravity>,
    mut bodies: ActiveBodies,
) {
    broadphase.escaped_aabb.clear();
    let moved = bodies.iter_mut().filter(|body| body.pose.is_changed());
    for body in moved {
        let (entity, index, pose) = (body.entity, body.index, &*body.pose);
        let body = table.get(index.0).filter(|body| body.entity == entity);
        if let Some(body) = body
            && (broadphase.flights.get(index.0).is_some()
                || way(body, pose) > expected_travel(body, gravity.0, time.dt))
            && let Some(shape) = body.shape()
            && let Some(fat) = &broadphase.fat[index.0 as usize]
            && !fat.contains(&shape.compute_aabb(&pose.to_parry()))
        {
            broadphase.escaped_aabb.push(index.0);
        }
    }
    broadphase.escaped_aabb.sort_unstable();
}

/// Upper bound of the distance that a point of a body has moved since the start of the step, m.
fn way(body: &BodyState, pose: &Pose) -> f32 {
    let center = pose.transform_point(body.mass.local_center);
    let turned = pose.rotation * body.pose.rotation.inverse();
    center.distance(body.center) + 2.0 * turned.xyz().length() * body.radius
}
