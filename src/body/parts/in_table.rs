//! The parts of a body in the [`BodyTable`](crate::body::BodyTable): which piece of its shape belongs to which collider.

use crate::body::BodyState;
use crate::body::collider::{Collider, CollisionLayers, Friction, Restitution, RollingFriction};
use bevy_ecs::entity::{Entity, EntityMapper};
use glam::{Quat, Vec3};
use parry3d::math::Pose as ParryPose;
use parry3d::shape::SharedShape;
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
    pub const MAX: u16 = (1 << 12) - 1;

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

    /// The pieces of the collider with this number, in the frame of the body.
    pub(crate) fn pieces_of(&self, number: u16) -> impl Iterator<Item = (ParryPose, &SharedShape)> {
        let shape = self.collider.as_ref().map(Collider::shape);
        let parts = self.parts.as_ref().filter(|parts| parts.has_pieces());
        let pieces = parts.zip(shape.and_then(|shape| shape.as_compound()));
        let whole = shape.filter(|_| pieces.is_none());
        let whole = whole.map(|shape| (ParryPose::IDENTITY, shape));
        let pieces = pieces.into_iter().flat_map(move |(parts, compound)| {
            let pieces = (0..).zip(compound.shapes());
            pieces.filter_map(move |(piece, (at, shape))| {
                (parts.owner(piece) == number).then_some((*at, shape))
            })
        });
        whole.into_iter().chain(pieces)
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
