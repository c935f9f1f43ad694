//! Ray casts.

use super::pieces::Piece;
use super::{QueryError, QueryFilter, SpatialQuery, Target};
use crate::settings::Columns;
use crate::solver::sort;
use bevy_ecs::prelude::*;
use bevy_shape::Ray3d;
use glam::Vec3;
use parry3d::partitioning::Bvh;
use parry3d::query::Ray;

/// A point where a ray hits a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayHit {
    /// The body.
    pub entity: Entity,
    /// The collider: a child of the body, or the body itself.
    pub collider: Entity,
    /// Distance from the ray's origin, m.
    pub distance: f32,
    /// The point, world, m.
    pub point: Vec3,
    /// Outward unit normal of the body's surface at that point, world. Zero if the ray starts inside a solid body.
    pub normal: Vec3,
}

/// Cost of a ray relative to the items that [`PhysicsThreads`](crate::settings::PhysicsThreads) counts.
const RAY_COST: usize = 64;

/// Number of rays that one thread casts at a time, at least.
const RAYS_PER_TASK: usize = 16;

impl Target<'_> {
    fn distance_along(&self, ray: &Ray, max_distance: f32, filter: &QueryFilter) -> Option<f32> {
        let far = far(max_distance, filter);
        let along = |piece: Piece| {
            let distance = piece
                .shape
                .cast_ray(&piece.at, ray, far, filter.is_solid())?;
            filter.reaches(distance, max_distance).then_some(distance)
        };
        self.best(filter, along, |distance| *distance)
    }

    fn ray_hit(&self, ray: &Ray, max_distance: f32, filter: &QueryFilter) -> Option<RayHit> {
        let far = far(max_distance, filter);
        let along = |piece: Piece| {
            let (shape, at) = (piece.shape, &piece.at);
            let hit = shape.cast_ray_and_get_normal(at, ray, far, filter.is_solid())?;
            let distance = hit.time_of_impact;
            filter.reaches(distance, max_distance).then(|| RayHit {
                entity: self.body.entity,
                collider: piece.collider,
                distance,
                point: ray.point_at(distance),
                normal: hit.normal.normalize_or_zero(),
            })
        };
        self.best(filter, along, |hit| hit.distance)
    }
}

/// How far parry must search to find hits within `max_distance`, m. For a ray that starts in a hollow shape and ends inside, parry
/// reports a hit at the ray's end.
fn far(max_distance: f32, filter: &QueryFilter) -> f32 {
    match filter.is_solid() {
        true => max_distance,
        false => f32::MAX,
    }
}

/// The ray and its maximum distance in m, if both are valid.
fn checked(ray: Ray3d, max_distance: f32) -> Result<(Ray, f32), QueryError> {
    if !ray.origin.is_finite() || !ray.direction.is_finite() {
        return Err(QueryError::NotFinite("the ray"));
    }
    Ok((Ray::new(ray.origin, *ray.direction), at_most(max_distance)?))
}

/// The distance in m, if it is valid. Infinity becomes the largest finite number.
pub(super) fn at_most(max_distance: f32) -> Result<f32, QueryError> {
    match max_distance >= 0.0 {
        true => Ok(max_distance.min(f32::MAX)),
        false => Err(QueryError::InvalidDistance(max_distance)),
    }
}

impl SpatialQuery<'_, '_> {
    /// The first body that a ray hits within `max_distance` (m), which may be infinite.
    ///
    /// # Errors
    /// [`QueryError`] if the ray is not finite or the distance is negative.
    pub fn cast_ray(
        &self,
        ray: Ray3d,
        max_distance: f32,
        filter: &QueryFilter,
    ) -> Result<Option<RayHit>, QueryError> {
        let (ray, max_distance) = checked(ray, max_distance)?;
        let distance = |slot, best| {
            self.target(slot, filter)?
                .distance_along(&ray, best, filter)
        };
        let search = |tree: &Bvh, first: u32, max_distance| {
            tree.cast_ray(&ray, max_distance, |leaf, best| {
                distance(first + leaf, best)
            })
        };
        let hit = |slot| {
            self.target(slot, filter)?
                .ray_hit(&ray, max_distance, filter)
        };
        Ok(self.nearest(max_distance, search, distance, hit))
    }

    /// All bodies that a ray hits within `max_distance` (m), nearest first. Each body is reported once, where the ray enters it.
    ///
    /// # Errors
    /// As [`Self::cast_ray`].
    pub fn cast_ray_through(
        &self,
        ray: Ray3d,
        max_distance: f32,
        filter: &QueryFilter,
    ) -> Result<Vec<RayHit>, QueryError> {
        let (ray, max_distance) = checked(ray, max_distance)?;
        let near = self
            .view()
            .along(&|node| node.cast_ray(&ray, max_distance) < f32::MAX);
        let hits = self.all(near, |slot| {
            self.target(slot, filter)?
                .ray_hit(&ray, max_distance, filter)
        });
        let mut hits: Vec<RayHit> = hits.into_iter().map(|(_, hit)| hit).collect();
        sort::by_key(&mut hits, |hit| hit.distance);
        Ok(hits)
    }

    /// The first hits of many rays, in the order of the rays; as [`Self::cast_ray`], in parallel on
    /// [`PhysicsThreads`](crate::settings::PhysicsThreads).
    ///
    /// # Errors
    /// As [`Self::cast_ray`], for the first ray that is invalid.
    pub fn cast_rays(
        &self,
        rays: &[Ray3d],
        max_distance: f32,
        filter: &QueryFilter,
    ) -> Result<Vec<Option<RayHit>>, QueryError> {
        let cast = |&ray: &Ray3d| self.cast_ray(ray, max_distance, filter);
        let weight = RAY_COST * rays.len();
        match self.threads.runs_in_parallel(weight) {
            true => {
                let mut hits = vec![Ok(None); rays.len()];
                self.threads.run(weight, || {
                    (rays, &mut *hits).share(RAYS_PER_TASK, &|(ray, hit)| *hit = cast(ray));
                });
                hits.into_iter().collect()
            }
            false => rays.iter().map(cast).collect(),
        }
    }
}
