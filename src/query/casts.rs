//! Shape casts: the bodies that a shape touches on a straight path.

use super::pieces::Piece;
use super::rays::at_most;
use super::touches::{Touches, contact};
use super::way::Way;
use super::{QueryError, QueryFilter, SpatialQuery, Target};
use crate::body::{Pose, collider::Collider};
use crate::solver::sort;
use bevy_ecs::prelude::*;
use bevy_math::Dir3;
use glam::Vec3;
use parry3d::bounding_volume::Aabb;
use parry3d::math::Pose as ParryPose;
use parry3d::partitioning::{Bvh, BvhNode};
use parry3d::query::{Ray, RayCast};
use std::cell::Cell;

/// The first contact of a moving shape with a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CastHit {
    /// The body.
    pub entity: Entity,
    /// The collider: a child of the body, or the body itself.
    pub collider: Entity,
    /// Distance that the shape has travelled, m; 0 if it overlaps the body from the start, or touches it and moves against it.
    pub distance: f32,
    /// The point of contact, world, m.
    pub point: Vec3,
    /// Outward unit normal of the body's surface at that point, world.
    pub normal: Vec3,
}

/// A shape on its path.
struct Cast<'a> {
    collider: &'a Collider,
    from: Pose,
    direction: Vec3,
    max_distance: f32,
    /// Its bounding box at the start.
    aabb: Aabb,
    /// Its contacts at the start.
    touches: Touches,
}

impl<'a> Cast<'a> {
    fn new(
        query: &SpatialQuery,
        collider: &'a Collider,
        from: Pose,
        direction: Dir3,
        max_distance: f32,
        filter: &QueryFilter,
    ) -> Result<Self, QueryError> {
        if !direction.is_finite() {
            return Err(QueryError::NotFinite("the direction"));
        }
        let from = posed(collider, from)?;
        Ok(Self {
            collider,
            from,
            direction: *direction,
            max_distance: at_most(max_distance)?,
            aabb: collider.shape().compute_aabb(&from.to_parry()),
            touches: query.touches(collider, &from, filter),
        })
    }

    /// Distance that its box travels until it touches another, m; [`f32::MAX`] if it does not.
    fn way_to(&self, node: &BvhNode) -> f32 {
        let half = self.aabb.half_extents();
        let widened = Aabb::new(node.mins() - half, node.maxs() + half);
        let ray = Ray::new(self.aabb.center(), self.direction);
        widened
            .cast_local_ray(&ray, self.max_distance, true)
            .unwrap_or(f32::MAX)
    }

    /// The way of a piece of a body as the shape sees it. The shape comes first because parry's answer depends on it, by some tenths of a
    /// millimetre.
    fn way_of(&self, piece: &ParryPose, max_distance: f32) -> Way {
        let from = self.from.to_parry();
        let back = from.rotation.inverse();
        Way {
            from: from.inv_mul(piece),
            direction: back * -self.direction,
            max_distance,
            touches: self.touches.turned(back).reversed(),
        }
    }

    /// Computes the hit on a body within `max_distance` (m), if there is one.
    fn hit(
        &self,
        target: &Target,
        max_distance: f32,
        filter: &QueryFilter,
    ) -> Result<Option<CastHit>, QueryError> {
        let shape = &**self.collider.shape();
        let from = self.from.to_parry();
        let entity = target.body.entity;
        let mut failed = None;
        let touch = |piece: Piece| {
            let at = piece.at;
            let way = self.way_of(&at, max_distance);
            let hit = way.first_hit(piece.shape, shape).unwrap_or_else(|_| {
                failed = Some(QueryError::Unsupported(entity));
                None
            });
            let hit = hit.filter(|hit| hit.time_of_impact <= max_distance)?;
            if filter.ignores_start() {
                let start = contact(piece.shape, shape, &at.inv_mul(&from), self.touches.reach);
                // Surfaces cannot be compared so; of them only what is hit at once is known to be touched.
                if start.map_or(hit.time_of_impact <= 0.0, |start| start.is_some()) {
                    return None;
                }
            }
            Some(CastHit {
                entity,
                collider: piece.collider,
                distance: hit.time_of_impact,
                point: at.transform_point(hit.witness2),
                normal: at.rotation * hit.normal2,
            })
        };
        let best = target.best(filter, touch, |hit| hit.distance);
        failed.map_or(Ok(best), Err)
    }
}

/// The normalized pose of a shape, if the shape can be used in a query and the pose is finite.
pub(super) fn posed(collider: &Collider, pose: Pose) -> Result<Pose, QueryError> {
    if collider.shape().as_halfspace().is_some() {
        return Err(QueryError::Unbounded);
    }
    if collider.is_degenerate() {
        return Err(QueryError::DegenerateShape);
    }
    let pose = pose.normalized();
    match pose.is_finite() {
        true => Ok(pose),
        false => Err(QueryError::NotFinite("the pose")),
    }
}

impl SpatialQuery<'_, '_> {
    /// The first body that a shape touches on a straight path without rotation: from a pose, in a direction, within `max_distance` (m).
    ///
    /// A shape that rests on something may be cast from there: what it touches is hit, at distance 0, if the shape moves against it, and is
    /// not hit if the shape moves along it or away. Overlaps and gaps of up to 0.05 mm count as touching, and more far from the origin.
    ///
    /// # Errors
    /// [`QueryError`] if the pose or direction is not finite, the distance is negative, the shape is degenerate or unbounded, or it
    /// cannot be compared with that of a body on its path.
    pub fn cast_shape(
        &self,
        collider: &Collider,
        from: Pose,
        direction: Dir3,
        max_distance: f32,
        filter: &QueryFilter,
    ) -> Result<Option<CastHit>, QueryError> {
        let cast = Cast::new(self, collider, from, direction, max_distance, filter)?;
        let failed = Cell::new(None);
        let hit = |slot, max_distance| {
            let hit = cast.hit(&self.target(slot, filter)?, max_distance, filter);
            hit.unwrap_or_else(|error| {
                failed.set(Some(error));
                None
            })
        };
        let distance = |slot, best| hit(slot, best).map(|hit| hit.distance);
        let search = |tree: &Bvh, first: u32, max_distance| {
            tree.find_best(
                max_distance,
                |node: &BvhNode, _| cast.way_to(node),
                |leaf, best| distance(first + leaf, best),
            )
        };
        let nearest = self.nearest(cast.max_distance, search, distance, |slot| {
            hit(slot, cast.max_distance)
        });
        failed.take().map_or(Ok(nearest), Err)
    }

    /// All bodies that the shape would touch within `max_distance` (m) if nothing stopped it, nearest first.
    ///
    /// # Errors
    /// As [`Self::cast_shape`].
    pub fn cast_shape_through(
        &self,
        collider: &Collider,
        from: Pose,
        direction: Dir3,
        max_distance: f32,
        filter: &QueryFilter,
    ) -> Result<Vec<CastHit>, QueryError> {
        let cast = Cast::new(self, collider, from, direction, max_distance, filter)?;
        let near = self.view().along(&|node| cast.way_to(node) < f32::MAX);
        let hits = self.all(near, |slot| {
            let hit = cast.hit(&self.target(slot, filter)?, cast.max_distance, filter);
            hit.transpose()
        });
        let hits = hits.into_iter().map(|(_, hit)| hit);
        let mut hits: Vec<CastHit> = hits.collect::<Result<_, _>>()?;
        sort::by_key(&mut hits, |hit| hit.distance);
        Ok(hits)
    }
}
