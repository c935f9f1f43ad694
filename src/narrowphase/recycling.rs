//! When a manifold may be kept: while the two bodies have hardly moved against each other since it was detected.
//!
//! Normal and arms stay frozen in the world, only distances follow. That saves most of collision detection at rest, and it
//! steadies: arms that are found anew in every step pump energy into tall stacks. (Box2D, Box3D and Rapier recycle contacts
//! for the same reasons.)
//!
//! Of bodies that were apart nothing has to be kept but by how much: until they have come as far towards each other, they need not be
//! looked at. In a heap that falls those are nine pairs of ten.

use crate::body::BodyState;
use crate::contact::{Manifold, NarrowphaseCache, Stand};
use crate::narrowphase::ParryManifold;
use glam::Quat;

impl Stand {
    pub(crate) fn of(a: &BodyState, b: &BodyState, reach: f32, apart: f32) -> Self {
        Self {
            between: a.center - b.center,
            rotations: [a.pose.rotation, b.pose.rotation],
            reach,
            apart,
        }
    }

    /// Bound on how far two points of the surfaces have moved against each other, or turned away from where they looked, m.
    #[inline]
    fn moved(&self, a: &BodyState, b: &BodyState) -> f32 {
        let turned = |body: &BodyState, was: Quat| {
            let now = body.pose.rotation;
            // A half-space has no radius; it turns, or it doesn't.
            if now == was {
                return 0.0;
            }
            2.0 * (now * was.inverse()).xyz().length() * body.radius
        };
        (a.center - b.center - self.between).length()
            + turned(a, self.rotations[0])
            + turned(b, self.rotations[1])
    }

    /// The points that the two touched in, still within `limit` of each other, where parry has found none although nothing has moved
    /// by more than that: its search may fail where surfaces just touch.
    pub(crate) fn lost(
        &self,
        old: &Manifold,
        cache: &NarrowphaseCache,
        a: &BodyState,
        b: &BodyState,
        limit: f32,
    ) -> Option<Manifold> {
        let found = |m: &ParryManifold| !m.points.is_empty();
        if cache.manifolds.is_empty()
            || cache.manifolds.iter().any(found)
            || self.moved(a, b) > limit
        {
            return None;
        }
        let mut old = old.clone();
        refresh(&mut old, a, b);
        let touches = old.points.iter().any(|point| point.distance <= limit);
        touches.then_some(old)
    }

    /// Nothing has moved by more than `limit`, and nothing that now counts lay beyond the reach of the search.
    #[inline]
    pub(crate) fn holds(&self, a: &BodyState, b: &BodyState, limit: f32, reach: f32) -> bool {
        let moved = self.moved(a, b);
        moved <= limit && reach + moved <= self.reach
    }

    /// They are farther apart than `reach` still, wherever they have moved.
    fn is_apart(&self, a: &BodyState, b: &BodyState, reach: f32) -> bool {
        self.apart > reach && reach + self.moved(a, b) < self.apart
    }
}

/// True where two bodies are known to be farther apart than `reach`, m: the spheres that hold them are, or they were when they were
/// last searched and have moved too little since.
pub(crate) fn are_apart(
    a: &BodyState,
    b: &BodyState,
    cache: &NarrowphaseCache,
    reach: f32,
) -> bool {
    // No half-space has a sphere: it has no end.
    let touching = a.radius + b.radius + reach;
    (a.center - b.center).length_squared() > touching * touching
        || cache.stand.is_some_and(|stand| stand.is_apart(a, b, reach))
}

/// Brings the distances of a kept manifold up to date.
#[inline]
pub(crate) fn refresh(manifold: &mut Manifold, a: &BodyState, b: &BodyState) {
    let Manifold { patches, points } = manifold;
    for patch in patches.iter() {
        for point in &mut points[patch.range()] {
            let on_a = a.pose.transform_point(point.local[0]);
            let on_b = b.pose.transform_point(point.local[1]);
            point.position = 0.5 * (on_a + on_b);
            point.distance = point.detected + patch.normal.dot(on_a - on_b);
        }
    }
}
