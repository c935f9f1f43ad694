//! The identity of a contact point from step to step: the features of the two solids that meet there.

#[cfg(feature = "bevy_reflect")]
use bevy_reflect::{Reflect, std_traits::ReflectDefault};
/// A corner of A on B, a corner of B on A, or an edge of each that cross. The number stays the same as long as the features do.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect), reflect(Debug, Default))]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct FeatureId(pub u32);

/// Number of bits for the index of a corner or an edge.
const INDEX_BITS: u32 = 15;

impl FeatureId {
    /// The feature is not known.
    pub const NONE: Self = Self(0);

    /// A corner of A.
    pub const fn corner_of_a(i: u16) -> Self {
        Self(1 << (2 * INDEX_BITS) | (i as u32) << INDEX_BITS)
    }

    /// A corner of B.
    pub const fn corner_of_b(i: u16) -> Self {
        Self(2 << (2 * INDEX_BITS) | i as u32)
    }

    /// An edge of A and one of B.
    pub const fn edges(of_a: u16, of_b: u16) -> Self {
        Self(3 << (2 * INDEX_BITS) | (of_a as u32) << INDEX_BITS | of_b as u32)
    }

    /// This feature of one part of each body, for bodies with several parts.
    pub(crate) const fn of_parts(self, part_a: u32, part_b: u32) -> Self {
        // Two different factors, so that the part numbers cancel neither each other nor the feature.
        Self(self.0 ^ part_a.wrapping_mul(0x9E37_79B1) ^ part_b.wrapping_mul(0x85EB_CA6B))
    }
}
