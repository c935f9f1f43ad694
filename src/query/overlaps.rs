//! Overlap tests: the bodies that a shape overlaps, and whether it fits somewhere.

use super::casts::posed;
use super::pieces::Piece;
use super::touches::contact;
use super::{QueryError, QueryFilter, SpatialQuery, Target};
use crate::body::Pose;
use crate::body::collider::{Collider, is_surface};
use bevy_ecs::prelude::*;
use glam::Vec3;

/// How far a shape is inside a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Overlap {
    /// The body.
    pub entity: Entity,
    /// The collider in which the shape is deepest: a child of the body, or the body itself.
    pub collider: Entity,
    /// Penetration depth, m.
    pub depth: f32,
    /// Outward unit normal of the body's surface, world. Moved by `depth` along it, the shape just touches the body. For a body of
    /// several parts (triangles or convex shapes) this is about the part in which the shape is deepest.
    pub normal: Vec3,
    /// The point of the body's surface where the shape is deepest, world, m.
    pub point: Vec3,
}

impl Target<'_> {
    /// How far a shape is inside of it, if it is.
    fn overlap(
        &self,
        collider: &Collider,
        pose: Pose,
        filter: &QueryFilter,
    ) -> Result<Option<Overlap>, QueryError> {
        let entity = self.body.entity;
        let unsupported = QueryError::Unsupported(entity);
        // Neither has an inside that the other could be in.
        if is_surface(self.shape) && collider.is_surface() {
            return Err(unsupported);
        }
        let from = pose.to_parry();
        let mut failed = None;
        let overlap = |piece: Piece| {
            let there = piece.at.inv_mul(&from);
            let found = contact(piece.shape, &**collider.shape(), &there, 0.0);
            let found = found.unwrap_or_else(|_| {
                failed = Some(unsupported.clone());
                None
            });
            let found = found.filter(|contact| contact.dist < 0.0)?;
            Some(Overlap {
                entity,
                collider: piece.collider,
                depth: -found.dist,
                normal: piece.at.rotation * found.normal1,
                point: piece.at.transform_point(found.point1),
            })
        };
        let deepest = self.best(filter, overlap, |overlap| -overlap.depth);
        failed.map_or(Ok(deepest), Err)
    }
}

impl SpatialQuery<'_, '_> {
    /// The bodies that a shape at a pose overlaps by more than `tolerance` (m), in order of spawning.
    ///
    /// # Errors
    /// [`QueryError`] if the pose is not finite, the tolerance is negative, the shape is degenerate or unbounded, or both it and a nearby
    /// body are surfaces (meshes or height fields), which have no inside.
    pub fn overlaps(
        &self,
        collider: &Collider,
        pose: Pose,
        tolerance: f32,
        filter: &QueryFilter,
    ) -> Result<Vec<Overlap>, QueryError> {
        let pose = posed(collider, pose)?;
        let tolerance = super::rays::at_most(tolerance)?;
        let aabb = collider.shape().compute_aabb(&pose.to_parry());
        let hits = self.all(self.view().near(&aabb), |slot| {
            let overlap = self.target(slot, filter)?.overlap(collider, pose, filter);
            overlap.transpose()
        });
        let hits = hits.into_iter().map(|(_, hit)| hit);
        let deep =
            |hit: &Result<Overlap, _>| hit.as_ref().map_or(true, |hit| hit.depth > tolerance);
        hits.filter(deep).collect()
    }

    /// Returns true if a shape at a pose overlaps no body by more than `tolerance` (m).
    ///
    /// A brick that lies on others touches them, so with a tolerance of 0 it fits nowhere. Use a millimetre.
    ///
    /// # Errors
    /// As [`Self::overlaps`].
    pub fn fits(
        &self,
        collider: &Collider,
        pose: Pose,
        tolerance: f32,
        filter: &QueryFilter,
    ) -> Result<bool, QueryError> {
        Ok(self.overlaps(collider, pose, tolerance, filter)?.is_empty())
    }
}
