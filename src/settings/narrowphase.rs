//! Settings of the narrowphase.

use super::Preset;
use bevy_ecs::prelude::*;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::{Reflect, std_traits::ReflectDefault};

/// How contact manifolds are computed, kept from step to step, and matched with those of the last step.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "bevy_reflect",
    derive(Reflect),
    reflect(Resource, Debug, Default)
)]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[component(clone_behavior = Ignore)]
pub struct NarrowphaseSettings {
    /// How far two bodies may move relative to each other before their manifold is computed anew, as a share of the size of the smaller
    /// body. Until then the manifold is recycled: its normal and lever arms stay as they are. The size of a body is its bounding radius,
    /// or 2.5 times half its smallest thickness if that is less. 0 computes every manifold in every step. Default: 0.016.
    pub recycle_share: f32,
    /// Whether patches with more than four points are reduced to four: the corners of the largest quadrangle. Default: true.
    pub reduce_manifolds: bool,
    /// A new contact point inherits the impulse of the nearest old point within this distance, m, if their features do not already match
    /// them. Default: 0.02.
    pub match_radius: f32,
}

impl Default for NarrowphaseSettings {
    fn default() -> Self {
        Preset::Default.narrowphase()
    }
}
