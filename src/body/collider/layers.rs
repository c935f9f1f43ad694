//! Collision layers: which bodies collide with which.

use crate::body::KeptProperty;
use bevy_ecs::prelude::*;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::{Reflect, std_traits::ReflectDefault};

/// The layers of a body, and the layers that it collides with. Two bodies collide if each is in a layer that the other's filter contains.
/// Default: all layers and all filters.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "bevy_reflect",
    derive(Reflect),
    reflect(Component, Debug, Default)
)]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[component(on_remove = crate::body::lost_description, summary_tick)]
pub struct CollisionLayers {
    /// Bit mask of the layers that the body is in.
    pub memberships: u32,
    /// Bit mask of the layers that the body collides with.
    pub filters: u32,
}

impl Default for CollisionLayers {
    fn default() -> Self {
        Self {
            memberships: u32::MAX,
            filters: u32::MAX,
        }
    }
}

impl KeptProperty for CollisionLayers {}

impl CollisionLayers {
    /// Returns true if bodies with these layers collide with each other.
    pub fn collides_with(self, other: Self) -> bool {
        self.memberships & other.filters != 0 && other.memberships & self.filters != 0
    }
}
