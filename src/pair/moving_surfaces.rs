//! The pairs whose surfaces move although their bodies do not.

use bevy_ecs::prelude::*;
use bevy_platform::collections::HashMap;
use glam::Vec3;

/// Velocities that friction demands of A against B, by the number of the pair's edge, m/s, world axes. Written anew in every step, in the
/// stage *narrowphase*.
#[derive(Resource, Clone, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[doc(hidden)]
#[component(clone_behavior = Ignore)]
pub struct MovingSurfaces(
    #[cfg_attr(
        feature = "serde",
        serde(serialize_with = "crate::stored::written::sorted")
    )]
    HashMap<u32, Vec3>,
);

impl MovingSurfaces {
    #[inline]
    pub(crate) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The velocity of a pair, if its surfaces move.
    #[inline]
    pub(crate) fn get(&self, edge: u32) -> Option<Vec3> {
        match self.0.is_empty() {
            true => None,
            false => self.0.get(&edge).copied(),
        }
    }

    pub(crate) fn insert(&mut self, edge: u32, velocity: Vec3) {
        self.0.insert(edge, velocity);
    }

    /// Empties the list, and returns what it was.
    pub(crate) fn take(&mut self) -> Self {
        std::mem::take(self)
    }
}
