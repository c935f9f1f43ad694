//! What becomes of a manifold from step to step.

use super::Preset;
use bevy_ecs::prelude::*;

/// How contact manifolds are found, kept and matched.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
pub struct NarrowphaseSettings {
    /// A contact manifold is kept, with normal and arms frozen, until its bodies have moved against each other by this share of
    /// the smaller one's size (its bounding radius, or 2.5 times half its least thickness where that is less). 0: found anew in
    /// every step.
    pub recycle_share: f32,
    /// Keep four points of a patch that has more: the corners of the largest quadrangle.
    pub reduce_manifolds: bool,
    /// A point that is found anew goes on as the one of the last step that is nearest to it, and no further away than this, m; where
    /// their features don't tell.
    pub match_radius: f32,
}

impl Default for NarrowphaseSettings {
    fn default() -> Self {
        Preset::Default.narrowphase()
    }
}
