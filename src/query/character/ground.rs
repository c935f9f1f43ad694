//! The ground of a character.

use super::MoveAndSlide;
use crate::body::{Pose, collider::Collider};
use crate::query::{CastHit, QueryError, QueryFilter, SpatialQuery};
use bevy_ecs::prelude::*;
use bevy_math::Dir3;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::Reflect;
use bevy_shape::Ray3d;
use glam::Vec3;

/// Ground that is flat enough to stand on.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect), reflect(Debug, PartialEq))]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Ground {
    /// The body.
    pub entity: Entity,
    /// Outward unit normal of its surface, world.
    pub normal: Vec3,
    /// The point below the character, world, m.
    pub point: Vec3,
    /// Distance of the character from it, straight down, m.
    pub distance: f32,
    /// Velocity of the ground at that point in the last step, m/s: that of a moving platform or of a
    /// [belt](crate::collider::SurfaceVelocity).
    pub velocity: Vec3,
}

impl SpatialQuery<'_, '_> {
    /// The ground under a shape at a pose, if it is flat enough to stand on, and no farther down than twice the margin.
    ///
    /// # Errors
    /// As [`move_and_slide`](Self::move_and_slide).
    pub fn ground(
        &self,
        collider: &Collider,
        pose: Pose,
        rules: &MoveAndSlide,
        filter: &QueryFilter,
    ) -> Result<Option<Ground>, QueryError> {
        rules.check()?;
        self.ground_within(collider, pose, 2.0 * rules.margin, rules, filter)
    }

    /// The ground no farther down than `reach`, m.
    pub(super) fn ground_within(
        &self,
        collider: &Collider,
        pose: Pose,
        reach: f32,
        rules: &MoveAndSlide,
        filter: &QueryFilter,
    ) -> Result<Option<Ground>, QueryError> {
        let hit = self.cast_shape(collider, pose, -rules.up, reach, filter)?;
        let Some(hit) = hit else {
            return Ok(None);
        };
        let normal = self.face_below(&hit, rules, filter)?;
        let ground = normal.map(|normal| Ground {
            entity: hit.entity,
            normal,
            point: hit.point,
            distance: hit.distance,
            velocity: self.surface_velocity_at(hit.entity, hit.point),
        });
        Ok(ground)
    }

    /// The normal of the surface on which a shape came down, if it is flat enough to stand on. A round shape touches the edge of a step
    /// with a normal of its own; what counts there is the face behind the edge.
    pub(super) fn face_below(
        &self,
        hit: &CastHit,
        rules: &MoveAndSlide,
        filter: &QueryFilter,
    ) -> Result<Option<Vec3>, QueryError> {
        /// How far behind the edge, above it and below it the face is searched, m.
        const SEARCH_DISTANCE: f32 = 0.01;
        if rules.is_walkable(hit.normal) {
            return Ok(Some(hit.normal));
        }
        let Ok(behind) = Dir3::new(-rules.level(hit.normal)) else {
            return Ok(None);
        };
        let from = hit.point + (*behind + *rules.up) * SEARCH_DISTANCE;
        let down = Ray3d::new(from, -rules.up);
        let face = self.cast_ray(down, 3.0 * SEARCH_DISTANCE, filter)?;
        let face = face.filter(|face| face.entity == hit.entity && face.distance > 0.0);
        Ok(face
            .map(|face| face.normal)
            .filter(|&normal| rules.is_walkable(normal)))
    }

    /// Velocity of the surface of a body at a point of the world, m/s, in the last step.
    fn surface_velocity_at(&self, body: Entity, point: Vec3) -> Vec3 {
        self.state(body).map_or(Vec3::ZERO, |body| {
            body.velocity_at(point) + body.surface_velocity()
        })
    }

    /// Velocity of a point of a body that is at a point of the world now, m/s, by the way that it went in the step that is under way.
    pub(crate) fn went(&self, body: Entity, point: Vec3) -> Vec3 {
        let (Some(body), Some(now)) = (self.state(body), self.pose(body)) else {
            return Vec3::ZERO;
        };
        match now == body.pose {
            true => Vec3::ZERO,
            false => {
                let before = body
                    .pose
                    .transform_point(now.inverse_transform_point(point));
                (point - before) / self.step.dt
            }
        }
    }
}
