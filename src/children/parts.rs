//! The parts of a body in the [`BodyTable`](crate::body::BodyTable): which piece of its shape belongs to which collider.

use crate::body::{BodyState, BodyTable};
use crate::collider::{Collider, CollisionLayers, Friction, Restitution, RollingFriction};
use crate::contact::{ContactImpulses, ContactPair, Manifold, ManifoldPatch};
use crate::solver::Both;
use bevy_ecs::entity::{Entity, EntityMapper};
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::{Reflect, std_traits::ReflectDefault};
use glam::{Quat, Vec3};
use parry3d::math::Pose as ParryPose;
use std::sync::Arc;

/// The solid parts and the sensors of a body.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct BodyParts {
    /// By piece of the compound: 0 for the body's own collider, otherwise the number of the part, from 1 on.
    #[cfg_attr(feature = "serde", serde(with = "crate::stored::written::shared_list"))]
    owners: Arc<[u16]>,
    /// The layers of the body's own collider.
    own_layers: CollisionLayers,
    parts: Vec<BodyPart>,
    zones: Vec<Zone>,
    /// Whether some parts have other layers than others.
    is_filtered: bool,
}

/// A part, with the properties of the body where it has none of its own.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct BodyPart {
    pub entity: Entity,
    pub friction: Friction,
    pub restitution: Restitution,
    pub rolling: RollingFriction,
    pub layers: CollisionLayers,
}

/// A sensor in the frame of its body.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Zone {
    /// The entity with the `Sensor`.
    pub entity: Entity,
    #[cfg_attr(feature = "serde", serde(with = "crate::stored::written::parry_pose"))]
    pub at: ParryPose,
    pub shape: Collider,
    layers: Option<CollisionLayers>,
}

/// The pose of several pieces that are one shape: the identity; of a single piece its own.
fn joined(mut pieces: Vec<(ParryPose, Collider)>) -> (ParryPose, Collider) {
    match pieces.len() {
        1 => pieces.remove(0),
        _ => (
            ParryPose::from_parts(Vec3::ZERO, Quat::IDENTITY),
            Collider::of_pieces(pieces),
        ),
    }
}

impl Zone {
    pub fn new(
        entity: Entity,
        layers: Option<CollisionLayers>,
        pieces: Vec<(ParryPose, Collider)>,
    ) -> Self {
        let (at, shape) = joined(pieces);
        Self {
            entity,
            at,
            shape,
            layers,
        }
    }

    pub fn layers(&self) -> CollisionLayers {
        self.layers.unwrap_or_default()
    }

    pub fn resolved(&self, own: CollisionLayers) -> Self {
        Self {
            layers: self.layers.or(Some(own)),
            ..self.clone()
        }
    }

    pub fn mapped(&self, mapper: &mut impl EntityMapper) -> Self {
        Self {
            entity: mapper.get_mapped(self.entity),
            ..self.clone()
        }
    }
}

impl PartialEq for Zone {
    fn eq(&self, other: &Self) -> bool {
        (self.entity, self.at, self.layers) == (other.entity, other.at, other.layers)
            && self.shape.is_same(&other.shape)
    }
}

impl PartialEq for BodyParts {
    fn eq(&self, other: &Self) -> bool {
        self.owners == other.owners
            && self.own_layers == other.own_layers
            && self.parts == other.parts
            && self.zones == other.zones
    }
}

impl BodyParts {
    /// Maximum number of solid parts of a body, besides its own collider.
    pub const MAX: usize = PatchParts::MAX as usize;

    pub fn new(
        owners: Arc<[u16]>,
        own_layers: CollisionLayers,
        parts: Vec<BodyPart>,
        zones: Vec<Zone>,
    ) -> Self {
        let is_filtered = parts.iter().any(|part| part.layers != own_layers);
        Self {
            owners,
            own_layers,
            parts,
            zones,
            is_filtered,
        }
    }

    pub fn zones(&self) -> &[Zone] {
        &self.zones
    }

    pub fn mapped(&self, mapper: &mut impl EntityMapper) -> Self {
        let mut mapped = self.clone();
        for part in &mut mapped.parts {
            part.entity = mapper.get_mapped(part.entity);
        }
        for zone in &mut mapped.zones {
            *zone = zone.mapped(mapper);
        }
        mapped
    }

    /// The number of the part that a piece belongs to; 0 for the body's own collider.
    pub fn owner(&self, piece: u32) -> u16 {
        self.owners.get(piece as usize).copied().unwrap_or(0)
    }

    /// Whether the shape has pieces of child colliders.
    pub fn has_pieces(&self) -> bool {
        !self.owners.is_empty()
    }

    /// The part with a number. `None` for the body's own collider.
    pub fn part(&self, number: u16) -> Option<&BodyPart> {
        self.parts.get(usize::from(number).checked_sub(1)?)
    }

    pub fn layers(&self, piece: u32) -> CollisionLayers {
        let part = self.part(self.owner(piece));
        part.map_or(self.own_layers, |part| part.layers)
    }
}

impl BodyState {
    /// The number of the part that a piece of the shape belongs to; 0 for the body's own collider.
    pub(crate) fn part_of(&self, piece: u32) -> u16 {
        self.parts.as_ref().map_or(0, |parts| parts.owner(piece))
    }

    /// The entity of the collider with this number: that of a part, or the body.
    pub(crate) fn collider_entity(&self, number: u16) -> Entity {
        let part = self.parts.as_ref().and_then(|parts| parts.part(number));
        part.map_or(self.entity, |part| part.entity)
    }

    /// Returns true if the parts of two bodies that these pieces belong to may collide. The bodies as a whole may.
    pub(crate) fn pieces_collide([a, b]: [&Self; 2], pieces: [u32; 2]) -> bool {
        let is_filtered = |body: &Self| body.parts.as_ref().is_some_and(|parts| parts.is_filtered);
        if !is_filtered(a) && !is_filtered(b) {
            return true;
        }
        let layers = |body: &Self, piece| match &body.parts {
            Some(parts) => parts.layers(piece),
            None => body.properties.layers,
        };
        layers(a, pieces[0]).collides_with(layers(b, pieces[1]))
    }
}

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
    pub(crate) const MAX: u16 = (1 << 12) - 1;

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
