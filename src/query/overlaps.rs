//! What a shape overlaps, and whether it fits.

use super::casts::posed;
use super::{QueryError, QueryFilter, SpatialQuery, Target};
use crate::body::Pose;
use crate::collider::Collider;
use bevy_ecs::prelude::*;
use parry3d::query::contact;

impl Target<'_> {
    /// How deep a shape is in it, m, if it is.
    fn depth(&self, collider: &Collider, pose: Pose) -> Option<f32> {
        let (at, from) = (self.pose.to_parry(), pose.to_parry());
        let found = contact(&at, self.shape, &from, &**collider.shape(), 0.0);
        let depth = -found.ok().flatten()?.dist;
        (depth > 0.0).then_some(depth)
    }
}

impl SpatialQuery<'_, '_> {
    /// The bodies that a shape at a pose is in by more than `tolerance` (m), the eldest first, and by how much (m): what has to be moved
    /// to part them.
    ///
    /// # Errors
    /// Where the pose is not finite, the tolerance negative, or the shape has no volume or no end.
    pub fn overlaps(
        &self,
        collider: &Collider,
        pose: Pose,
        tolerance: f32,
        filter: &QueryFilter,
    ) -> Result<Vec<(Entity, f32)>, QueryError> {
        let pose = posed(collider, pose)?;
        let tolerance = super::rays::at_most(tolerance)?;
        let aabb = collider.shape().compute_aabb(&pose.to_parry());
        let hits = self.all(self.view().near(&aabb), |slot| {
            let depth = self.target(slot, filter)?.depth(collider, pose)?;
            (depth > tolerance).then_some(depth)
        });
        let hits = hits.into_iter();
        Ok(hits.map(|(body, depth)| (body.entity, depth)).collect())
    }

    /// Whether a collider fits at a pose: it is in no body by more than `tolerance` (m). A brick laid on others touches them, so that a
    /// tolerance of nothing would let it in nowhere; a millimetre will do.
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
