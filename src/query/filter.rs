//! Filters: which bodies a query considers, and how it treats the body it starts in.

use crate::body::{BodyState, collider::CollisionLayers};
use bevy_ecs::prelude::*;
use std::fmt;

/// Rules that decide which bodies a spatial query may return. By default a query considers all bodies, and treats shapes as solid.
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
/// let filter = filter.with_predicate(&is_real);
/// ```
#[derive(Clone, Copy)]
#[must_use]
pub struct QueryFilter<'a> {
    layers: Option<CollisionLayers>,
    excluded: &'a [Entity],
    predicate: Option<&'a (dyn Fn(Entity) -> bool + Sync)>,
    dynamic_only: bool,
    solid: bool,
    ignores_start: bool,
}

impl Default for QueryFilter<'_> {
    fn default() -> Self {
        Self {
            layers: None,
            excluded: &[],
            predicate: None,
            dynamic_only: false,
            solid: true,
            ignores_start: false,
        }
    }
}

impl fmt::Debug for QueryFilter<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("QueryFilter")
            .field("layers", &self.layers)
            .field("excluded", &self.excluded)
            .field("has_predicate", &self.predicate.is_some())
            .field("dynamic_only", &self.dynamic_only)
            .field("solid", &self.solid)
            .field("ignores_start", &self.ignores_start)
            .finish()
    }
}

impl<'a> QueryFilter<'a> {
    /// Considers only bodies, and colliders of bodies, that a body with these layers would collide with. Default: all.
    pub fn with_layers(mut self, layers: CollisionLayers) -> Self {
        self.layers = Some(layers);
        self
    }

    /// Ignores these bodies, and these colliders on children of bodies. Default: none.
    pub fn excluding(mut self, entities: &'a [Entity]) -> Self {
        self.excluded = entities;
        self
    }

    /// Considers only bodies for which the predicate returns true. Default: no predicate.
    ///
    /// The predicate runs after all other rules. Batch queries such as [`cast_rays`](super::SpatialQuery::cast_rays) call it from several
    /// threads.
    pub fn with_predicate(mut self, predicate: &'a (dyn Fn(Entity) -> bool + Sync)) -> Self {
        self.predicate = Some(predicate);
        self
    }

    /// Considers only dynamic bodies. Default: bodies of every kind.
    pub fn dynamic_only(mut self) -> Self {
        self.dynamic_only = true;
        self
    }

    /// Sets whether rays treat shapes as solid. Default: `true`.
    ///
    /// A ray that starts inside a solid shape hits it at once, at distance 0. A ray that starts inside a hollow shape (`false`) hits it
    /// where the ray leaves it.
    pub fn solid(mut self, solid: bool) -> Self {
        self.solid = solid;
        self
    }

    /// Ignores the bodies that a ray or shape overlaps or touches at its start. Default: they are hit at distance 0.
    ///
    /// Use it to cast a brick that lies on another one without hitting the brick below. An ignored body is not hit later on the path
    /// either.
    pub fn ignoring_start(mut self) -> Self {
        self.ignores_start = true;
        self
    }

    /// Whether a hit at `distance` (m) counts when the search ends at `max_distance` (m).
    pub(super) fn reaches(&self, distance: f32, max_distance: f32) -> bool {
        distance <= max_distance && (distance > 0.0 || !self.ignores_start)
    }

    /// Whether bodies at the start are ignored.
    pub(super) fn ignores_start(&self) -> bool {
        self.ignores_start
    }

    /// Whether a ray that starts inside a body hits it at once.
    pub(super) fn is_solid(&self) -> bool {
        self.solid || self.ignores_start
    }

    /// Whether a query may return a collider of a body that it may return.
    #[inline]
    pub(super) fn admits_part(&self, collider: Entity, layers: CollisionLayers) -> bool {
        self.layers.is_none_or(|asked| asked.collides_with(layers))
            && !self.excluded.contains(&collider)
    }

    /// Whether a query may return this body.
    #[inline]
    pub(super) fn admits(&self, body: &BodyState) -> bool {
        (!self.dynamic_only || body.is_dynamic())
            && self
                .layers
                .is_none_or(|l| l.collides_with(body.properties.layers))
            && !self.excluded.contains(&body.entity)
            && self.predicate.is_none_or(|holds| holds(body.entity))
    }
}
