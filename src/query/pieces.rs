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

    /// The pieces that a query may return: the whole shape of a body without child colliders.
    #[inline]
    pub fn pieces(&self, filter: &QueryFilter) -> impl Iterator<Item = Piece<'a>> {
        let at = self.pose.to_parry();
        let body = self.body;
        let parts = body.parts.as_deref().filter(|parts| parts.has_pieces());
        let whole = parts.is_none().then(|| self.whole());
        let compound = parts.and_then(|parts| Some((parts, self.shape.as_compound()?)));
        let pieces = compound.into_iter().flat_map(move |(parts, compound)| {
            (0..)
                .zip(compound.shapes())
                .filter_map(move |(piece, (local, shape))| {
                    let collider = body.collider_entity(parts.owner(piece));
                    filter
                        .admits_part(collider, parts.layers(piece))
                        .then(|| Piece {
                            collider,
                            shape: &**shape,
                            at: at * *local,
                        })
                })
        });
        whole.into_iter().chain(pieces)
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
        let hits = self.pieces(filter).filter_map(&mut hit);
        hits.reduce(|best, next| if key(&next) < key(&best) { next } else { best })
    }
}
