//! The colliders of a body, one by one, for bodies with colliders on child entities.

use super::{QueryFilter, Target};
use bevy_ecs::entity::Entity;
use parry3d::math::Pose as ParryPose;
use parry3d::shape::Shape;

/// A collider of a body, or a convex piece of one.
#[derive(Clone, Copy)]
pub(super) struct Piece<'a> {
    /// The entity of the collider: a child of the body, or the body itself.
    pub collider: Entity,
    pub shape: &'a dyn Shape,
    /// Its pose in the world.
    pub at: ParryPose,
}

impl<'a> Target<'a> {
    /// The whole shape, as the collider of the body.
    fn whole(&self) -> Piece<'a> {
        Piece {
            collider: self.body.entity,
            shape: self.shape,
            at: self.pose.to_parry(),
        }
    }

    /// Calls a function with the pieces that a query may return, in order, until it returns true: the whole shape of a body without child
    /// colliders. Returns true if it did.
    pub fn any_piece(
        &self,
        filter: &QueryFilter,
        found: &mut dyn FnMut(Piece<'a>) -> bool,
    ) -> bool {
        let parts = self.body.parts.as_deref();
        let Some(parts) = parts.filter(|parts| parts.has_pieces()) else {
            return found(self.whole());
        };
        let Some(compound) = self.shape.as_compound() else {
            return false;
        };
        let at = self.pose.to_parry();
        for (piece, (local, shape)) in (0..).zip(compound.shapes()) {
            let collider = self.body.collider_entity(parts.owner(piece));
            if filter.admits_part(collider, parts.layers(piece))
                && found(Piece {
                    collider,
                    shape: &**shape,
                    at: at * *local,
                })
            {
                return true;
            }
        }
        false
    }

    /// The best of the hits on the pieces, by a key that is to be small. The first of equal ones counts.
    #[inline]
    pub fn best<H>(
        &self,
        filter: &QueryFilter,
        mut hit: impl FnMut(Piece<'a>) -> Option<H>,
        key: impl Fn(&H) -> f32,
    ) -> Option<H> {
        if self.body.parts.is_none() {
            return hit(self.whole());
        }
        let mut best = None;
        self.any_piece(filter, &mut |piece| {
            if let Some(next) = hit(piece)
                && best.as_ref().is_none_or(|best| key(&next) < key(best))
            {
                best = Some(next);
            }
            false
        });
        best
    }
}
