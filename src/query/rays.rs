//! What a ray hits.

use super::{QueryError, QueryFilter, SpatialQuery, Target};
use bevy_ecs::prelude::*;
use bevy_shape::Ray3d;
use glam::Vec3;
use parry3d::partitioning::Bvh;
use parry3d::query::Ray;
use rayon::prelude::*;

/// Where a ray hits a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayHit {
    /// The body.
    pub entity: Entity,
    /// From the ray's origin, m.
    pub distance: f32,
    /// World, m.
    pub point: Vec3,
    /// Unit vector out of the body's surface there; zero where the ray begins inside of it.
    pub normal: Vec3,
}

/// By how much dearer a ray is than what [`PhysicsThreads`](crate::settings::PhysicsThreads) counts.
const WEIGHT: usize = 64;

impl Target<'_> {
    fn distance_along(&self, ray: &Ray, max_distance: f32, filter: &QueryFilter) -> Option<f32> {
        let (at, far) = (self.pose.to_parry(), far(max_distance, filter));
        let distance = self.shape.cast_ray(&at, ray, far, filter.is_solid())?;
        filter.reaches(distance, max_distance).then_some(distance)
    }

    fn ray_hit(&self, ray: &Ray, max_distance: f32, filter: &QueryFilter) -> Option<RayHit> {
        let (at, far) = (self.pose.to_parry(), far(max_distance, filter));
        let hit = (self.shape).cast_ray_and_get_normal(&at, ray, far, filter.is_solid())?;
        let distance = hit.time_of_impact;
        filter.reaches(distance, max_distance).then(|| RayHit {
            entity: self.body.entity,
            distance,
            point: ray.point_at(distance),
            normal: hit.normal.normalize_or_zero(),
        })
    }
}

/// How far to look so as to find what is nearer than `max_distance`, m. Parry says of a ray that does not leave a box on its way that it leaves it
/// at its end.
fn far(max_distance: f32, filter: &QueryFilter) -> f32 {
    match filter.is_solid() {
        true => max_distance,
        false => f32::MAX,
    }
}

/// A ray and how far it goes, m, if they can be.
fn checked(ray: Ray3d, max_distance: f32) -> Result<(Ray, f32), QueryError> {
    if !ray.origin.is_finite() || !ray.direction.is_finite() {
        return Err(QueryError::NotFinite("the ray"));
    }
    Ok((Ray::new(ray.origin, *ray.direction), at_most(max_distance)?))
}

/// A distance, m, if it can be; infinity is far enough for every body.
pub(super) fn at_most(max_distance: f32) -> Result<f32, QueryError> {
    match max_distance >= 0.0 {
        true => Ok(max_distance.min(f32::MAX)),
        false => Err(QueryError::InvalidDistance(max_distance)),
    }
}

impl SpatialQuery<'_, '_> {
    /// The first body that a ray hits nearer than `max_distance` (m), which may be infinite.
    ///
    /// # Errors
    /// Where the ray is not finite or the distance negative.
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

    /// Whatever a ray hits up to `max_distance` (m), nearest first; each body once, where the ray enters it.
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
            .along(|node| node.cast_ray(&ray, max_distance) < f32::MAX);
        let hits = self.all(near, |slot| {
            self.target(slot, filter)?
                .ray_hit(&ray, max_distance, filter)
        });
        let mut hits: Vec<RayHit> = hits.into_iter().map(|(_, hit)| hit).collect();
        hits.sort_by(|a, b| a.distance.total_cmp(&b.distance));
        Ok(hits)
    }

    /// [`Self::cast_ray`] for many rays, in their order, on as many threads as physics may use.
    ///
    /// # Errors
    /// As [`Self::cast_ray`], for the first that is wrong.
    pub fn cast_rays(
        &self,
        rays: &[Ray3d],
        max_distance: f32,
        filter: &QueryFilter,
    ) -> Result<Vec<Option<RayHit>>, QueryError> {
        let cast = |&ray: &Ray3d| self.cast_ray(ray, max_distance, filter);
        let weight = WEIGHT * rays.len();
        match self.threads.share(weight) {
            true => (self.threads).run(weight, || rays.par_iter().map(cast).collect()),
            false => rays.iter().map(cast).collect(),
        }
    }
}
