//! Data of a body, a collider or a joint in a scene, besides its own components.

use super::SavedContact;
use crate::body::SensorOverlap;
use crate::joint_types::JointForces;
use crate::pair::Wrench;
use bevy_ecs::entity::{EntityMapper, MapEntities};
use bevy_ecs::prelude::*;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::{Reflect, std_traits::ReflectDefault};

/// The data of an entity that is saved besides its components: its place in the order of spawning, its contacts, the forces of a joint, the
/// contents of a sensor, and the forces with which a body beside awake ones fell asleep. [`prepare`](crate::saving::prepare) inserts it,
/// and the next step takes it up and removes it, in the world that was saved as in that of the scene.
#[derive(Component, Clone, Debug, Default)]
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
#[component(map_entities)]
pub struct Saved {
    /// Its number in the order of spawning. Loaded entities get new numbers, in the same order.
    pub(crate) spawn_order: u64,
    /// The contacts in which the entity is B.
    pub(crate) contacts: Vec<SavedContact>,
    /// Length of the last step, s: the impulses of contacts are those of this time.
    pub(crate) step: f32,
    pub(crate) joint: Option<JointForces>,
    /// The colliders inside a sensor.
    pub(crate) inside: Vec<SensorOverlap>,
    /// The forces with which a sleeping body fell asleep, if its account is open.
    #[cfg_attr(feature = "serde", serde(default))]
    pub(crate) account: Option<Wrench>,
}

impl MapEntities for Saved {
    fn map_entities<M: EntityMapper>(&mut self, mapper: &mut M) {
        for contact in &mut self.contacts {
            contact.other.map_entities(mapper);
        }
        for overlap in &mut self.inside {
            overlap.body.map_entities(mapper);
            overlap.collider.map_entities(mapper);
        }
    }
}
