//! Which parts of two bodies touch in a contact patch.

use super::{ContactImpulses, ContactPair, Manifold, ManifoldPatch};
use crate::body::{BodyTable, parts::BodyParts};
use crate::solver::Both;
use bevy_ecs::entity::Entity;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::{Reflect, std_traits::ReflectDefault};

/// The parts of the two bodies of a contact patch: for A and B, 0 or the number of a child collider.
///
/// It takes three bytes, which are free behind the other fields of a patch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect), reflect(Debug, Default))]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PatchParts([u8; 3]);

impl PatchParts {
    /// The largest number.
    const MAX: u16 = BodyParts::MAX;

    pub(crate) fn new([a, b]: [u16; 2]) -> Self {
        let packed = u32::from(a.min(Self::MAX)) << 12 | u32::from(b.min(Self::MAX));
        let [low, middle, high, _] = packed.to_le_bytes();
        Self([low, middle, high])
    }

    /// The number for A (0) or B (1).
    pub(crate) fn get(self, i: usize) -> u16 {
        let [low, middle, high] = self.0;
        let packed = u32::from_le_bytes([low, middle, high, 0]);
        (if i == 0 { packed >> 12 } else { packed & 0xFFF }) as u16
    }

    /// Whether both are the bodies' own colliders.
    #[inline]
    pub(crate) fn is_whole(self) -> bool {
        self == Self::default()
    }
}

impl ContactPair {
    /// The colliders of A and B with these numbers: on child entities, or the bodies themselves.
    pub(crate) fn colliders(&self, parts: PatchParts, table: &BodyTable) -> [Entity; 2] {
        [0, 1].both(|i| {
            let body = table.get(self.slots[i]).filter(|body| self.is_of(i, body));
            let collider = body.map(|body| body.collider_entity(parts.get(i)));
            collider.unwrap_or(self.bodies[i])
        })
    }
}

impl Manifold {
    /// The numbers of the colliders in the patch with the largest normal impulse, or without impulses in the patch whose surfaces are
    /// nearest.
    pub(crate) fn main_parts(&self, impulses: &ContactImpulses) -> PatchParts {
        let rank = |patch: &ManifoldPatch| {
            let range = self.range(patch);
            let impulses = impulses.points.get(range.clone()).unwrap_or_default();
            let impulse: f32 = impulses.iter().map(|point| point.normal).sum();
            let distances = self.points[range].iter().map(|point| point.distance);
            (impulse, -distances.fold(f32::INFINITY, f32::min))
        };
        let order = |one: &(f32, f32), other: &(f32, f32)| {
            one.0.total_cmp(&other.0).then(one.1.total_cmp(&other.1))
        };
        // Most manifolds have one patch, and parts are rare.
        if self.patches.iter().all(|patch| patch.parts.is_whole()) {
            return PatchParts::default();
        }
        let ranked = self.patches.iter().map(|patch| (rank(patch), patch.parts));
        let most = ranked.reduce(|best, next| match order(&next.0, &best.0).is_gt() {
            true => next,
            false => best,
        });
        most.map_or(PatchParts::default(), |(_, parts)| parts)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_parts_are_packed() {
        for both in [[0, 0], [1, 0], [0, 1], [4095, 17], [256, 4095]] {
            let packed = PatchParts::new(both);
            assert_eq!([packed.get(0), packed.get(1)], both);
            assert_eq!(packed.is_whole(), both == [0, 0]);
        }
    }
}
