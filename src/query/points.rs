//! Point queries: the bodies that contain a point, and the body nearest to it.

use super::pieces::Piece;
use super::rays::at_most;
use super::{QueryError, QueryFilter, SpatialQuery, Target};
use bevy_ecs::prelude::*;
use glam::Vec3;
use parry3d::bounding_volume::Aabb;
use parry3d::partitioning::{Bvh, BvhNode};
use parry3d::query::PointQuery;

/// The point of a body that is closest to the point asked about.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointHit {
    /// The body.
    pub entity: Entity,
    /// The collider: a child of the body, or the body itself.
    pub collider: Entity,
    /// The closest point, world, m; the point asked about if it is inside the body.
    pub point: Vec3,
    /// Distance between the two points, m; 0 inside the body.
    pub distance: f32,
    /// Whether the point asked about is inside the body. Meshes and height fields have no inside.
    pub is_inside: bool,
}

impl Target<'_> {
    fn nearest_to(&self, point: Vec3, filter: &QueryFilter) -> Option<PointHit> {
        let project = |piece: Piece| {
            let found = (piece.shape).project_point(&piece.at, point, true);
            Some(PointHit {
                entity: self.body.entity,
                collider: piece.collider,
                point: found.point,
                distance: found.point.distance(point),
                is_inside: found.is_inside,
            })
        };
        self.best(filter, project, |hit| hit.distance)
    }
}

fn checked(point: Vec3) -> Result<Vec3, QueryError> {
    match point.is_finite() {
        true => Ok(point),
        false => Err(QueryError::NotFinite("the point")),
    }
}

impl SpatialQuery<'_, '_> {
    /// The bodies that contain a point (world, m), in order of spawning.
    ///
    /// # Errors
    /// [`QueryError::NotFinite`] if the point is not finite.
    pub fn bodies_at(&self, point: Vec3, filter: &QueryFilter) -> Result<Vec<Entity>, QueryError> {
        let point = checked(point)?;
        let here = Aabb::new(point, point);
        let hits = self.all(self.view().near(&here), |slot| {
            let target = self.target(slot, filter)?;
            let mut contains = |piece: Piece| piece.shape.contains_point(&piece.at, point);
            target.any_piece(filter, &mut contains).then_some(())
        });
        Ok(hits.into_iter().map(|(body, ())| body.entity).collect())
    }

    /// The closest point of any body within `max_distance` (m) of a point (world, m).
    ///
    /// # Errors
    /// [`QueryError`] if the point is not finite or the distance is negative.
    pub fn closest_point(
        &self,
        point: Vec3,
        max_distance: f32,
        filter: &QueryFilter,
    ) -> Result<Option<PointHit>, QueryError> {
        let (point, max_distance) = (checked(point)?, at_most(max_distance)?);
        let hit = |slot| self.target(slot, filter)?.nearest_to(point, filter);
        let distance = |slot, _| hit(slot).map(|hit| hit.distance);
        let search = |tree: &Bvh, first: u32, max_distance| {
            tree.find_best(
                max_distance,
                |node: &BvhNode, _| node.aabb().distance_to_local_point(point, true),
                |leaf, best| distance(first + leaf, best),
            )
        };
        Ok(self.nearest(max_distance, search, distance, hit))
    }
}
