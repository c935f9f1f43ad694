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

    /// Whether a ray hits the body that it begins in at once.
    pub(super) fn is_solid(&self) -> bool {
        !self.hollow
    }

    #[inline]
    pub(super) fn admits(&self, body: &BodyState) -> bool {
        (!self.dynamic_only || body.is_dynamic())
            && self.layers.is_none_or(|l| l.collides_with(body.layers))
            && !self.excluded.contains(&body.entity)
            && self.predicate.is_none_or(|holds| holds(body.entity))
    }
}
