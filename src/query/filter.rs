//! Which bodies count.

use crate::body::BodyState;
use crate::collider::CollisionLayers;
use bevy_ecs::prelude::*;

/// Which bodies an answer may name; all of them by default.
///
/// ```
/// # use bevy_ecs::prelude::*;
/// # use drystone::prelude::*;
/// # let (hand, ghosts) = (Entity::PLACEHOLDER, Vec::<Entity>::new());
/// let held = [hand];
/// let filter = QueryFilter::default()
///     .dynamic_only()
///     .excluding(&held)
///     .with_layers(CollisionLayers { memberships: 1, filters: 0b110 });
/// let is_real = |entity| !ghosts.contains(&entity);
/// let filter = filter.that(&is_real);
/// ```
#[derive(Clone, Copy, Default)]
pub struct QueryFilter<'a> {
    layers: Option<CollisionLayers>,
    excluded: &'a [Entity],
    predicate: Option<&'a (dyn Fn(Entity) -> bool + Sync)>,
    dynamic_only: bool,
    hollow: bool,
    ignores_start: bool,
}

impl<'a> QueryFilter<'a> {
    /// Only what a body of these layers would collide with.
    pub fn with_layers(mut self, layers: CollisionLayers) -> Self {
        self.layers = Some(layers);
        self
    }

    /// None of these.
    pub fn excluding(mut self, entities: &'a [Entity]) -> Self {
        self.excluded = entities;
        self
    }

    /// Only those for which this holds. It is asked last, and on several threads by what asks for many at once.
    pub fn that(mut self, predicate: &'a (dyn Fn(Entity) -> bool + Sync)) -> Self {
        self.predicate = Some(predicate);
        self
    }

    /// Only dynamic bodies.
    pub fn dynamic_only(mut self) -> Self {
        self.dynamic_only = true;
        self
    }

    /// A ray that begins in a body hits it where it leaves it, and not at once.
    pub fn hollow(mut self) -> Self {
        self.hollow = true;
        self
    }

    /// Rays and shapes do not hit the bodies that they begin in or touch at their start, as a brick on its way does not hit the one that it
    /// lies on. Such a body is not hit later on the way either.
    pub fn ignoring_start(mut self) -> Self {
        self.ignores_start = true;
        self
    }

    /// Whether a hit at a distance, m, counts, where `most` is the farthest.
    pub(super) fn reaches(&self, distance: f32, most: f32) -> bool {
        distance <= most && (distance > 0.0 || !self.ignores_start)
    }

    /// Whether a ray hits the body that it begins in at once.
    pub(super) fn is_solid(&self) -> bool {
        !self.hollow || self.ignores_start
    }

    #[inline]
    pub(super) fn admits(&self, body: &BodyState) -> bool {
        (!self.dynamic_only || body.is_dynamic())
            && self.layers.is_none_or(|l| l.collides_with(body.properties.layers))
            && !self.excluded.contains(&body.entity)
            && self.predicate.is_none_or(|holds| holds(body.entity))
    }
}
