//! Regions: the data that is kept of bodies that are taken out of the world.

use crate::body::BodyState;
use crate::pair::{ContactPair, PairParts, Wrench};
use bevy_ecs::entity::Entity;
use parry3d::bounding_volume::Aabb;

/// Bodies that were [taken out](super::take_out) of the simulation, with their contacts. It belongs to the world that they were taken out
/// of.
#[derive(Debug, Default)]
#[must_use = "without it the bodies cannot be put back as they stood"]
pub struct Region {
    /// In order of spawning.
    pub(super) bodies: Vec<Body>,
    /// Contacts with at least one of the bodies.
    pub(super) contacts: Vec<Contact>,
    /// The other bodies of those contacts as they were, sorted by entity.
    pub(super) neighbours: Vec<BodyState>,
    /// How often the settings had been changed.
    pub(super) settings: u64,
}

impl Region {
    /// The bodies, in order of spawning.
    pub fn bodies(&self) -> impl ExactSizeIterator<Item = Entity> {
        self.bodies.iter().map(|body| body.state.entity)
    }

    /// Number of bodies.
    pub fn len(&self) -> usize {
        self.bodies.len()
    }

    /// Returns true if there are no bodies.
    pub fn is_empty(&self) -> bool {
        self.bodies.is_empty()
    }
}

/// A body that is out.
#[derive(Debug)]
pub(super) struct Body {
    /// Its entry in the body table.
    pub state: BodyState,
    /// Its box in the tree.
    pub aabb: Option<Aabb>,
    /// The forces with which it fell asleep, if an awake body has touched it since.
    pub account: Option<Wrench>,
}

/// A pair of two bodies near each other, without its entity: a body is out, or has just arrived.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Contact {
    pub pair: ContactPair,
    /// Whether the edge links its bodies, because there are contact points.
    pub links: bool,
    pub parts: PairParts,
}
