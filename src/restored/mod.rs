//! Data of a loaded scene that waits until the stages take it: contacts, contents of sensors, and accounts of sleeping bodies.
//!
//! The module [`saving`](crate::saving) fills it. Contacts wait until the stage *broadphase* has made their pairs.

mod contact;
mod saved;

pub use contact::SavedContact;
pub use saved::Saved;

use crate::body::SensorOverlap;
use crate::pair::{ContactPair, Wrench};
use crate::settings::StepTime;
use bevy_ecs::entity::{EntityHashMap, EntityMapper, MapEntities};
use bevy_ecs::prelude::*;
use bevy_platform::collections::HashMap;

/// Contacts, sensor contents and accounts of a scene that was loaded since the last step.
#[derive(Resource, Clone, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[component(map_entities)]
#[doc(hidden)]
pub struct Restored {
    /// By A and B, with the length of the step before they were saved, s.
    #[cfg_attr(
        feature = "serde",
        serde(serialize_with = "crate::stored::written::sorted")
    )]
    pub(crate) contacts: HashMap<[Entity; 2], (f32, SavedContact)>,
    #[cfg_attr(
        feature = "serde",
        serde(serialize_with = "crate::stored::written::sorted")
    )]
    pub(crate) inside: EntityHashMap<Vec<SensorOverlap>>,
    /// The bodies, colliders and joints of the scene, with the accounts of sleeping bodies.
    #[cfg_attr(
        feature = "serde",
        serde(serialize_with = "crate::stored::written::sorted")
    )]
    pub(crate) accounts: EntityHashMap<Option<Wrench>>,
}

impl MapEntities for Restored {
    fn map_entities<M: EntityMapper>(&mut self, mapper: &mut M) {
        let contacts = self.contacts.drain().map(|(mut bodies, mut contact)| {
            bodies.map_entities(mapper);
            contact.1.other = bodies[0];
            (bodies, contact)
        });
        self.contacts = contacts.collect();
        let inside = self.inside.drain().map(|(mut sensor, mut inside)| {
            sensor.map_entities(mapper);
            for overlap in &mut inside {
                overlap.body.map_entities(mapper);
                overlap.collider.map_entities(mapper);
            }
            (sensor, inside)
        });
        self.inside = inside.collect();
        let accounts = self.accounts.drain().map(|(mut body, account)| {
            body.map_entities(mapper);
            (body, account)
        });
        self.accounts = accounts.collect();
    }
}

impl Restored {
    /// Takes the contacts, for the pairs that are made in this step.
    pub(crate) fn take_contacts(&mut self) -> RestoredContacts {
        RestoredContacts(std::mem::take(&mut self.contacts))
    }

    /// Takes the contents of sensors.
    pub(crate) fn take_inside(&mut self) -> EntityHashMap<Vec<SensorOverlap>> {
        std::mem::take(&mut self.inside)
    }

    /// Takes the entities of the scene, with the forces with which sleeping bodies fell asleep where their accounts are open.
    pub(crate) fn take_accounts(&mut self) -> EntityHashMap<Option<Wrench>> {
        std::mem::take(&mut self.accounts)
    }

    /// Whether a scene was loaded since the accounts were taken.
    pub(crate) fn has_accounts(&self) -> bool {
        !self.accounts.is_empty()
    }

    /// Whether a sensor has contents to be taken.
    pub(crate) fn has_inside(&self) -> bool {
        !self.inside.is_empty()
    }
}

/// Contacts of a scene, for the pairs that are made.
#[derive(Debug)]
pub(crate) struct RestoredContacts(HashMap<[Entity; 2], (f32, SavedContact)>);

impl RestoredContacts {
    /// Marks a new pair that was saved.
    pub fn mark(&self, pair: &mut ContactPair) {
        if let Some((_, saved)) = self.0.get(&pair.bodies) {
            pair.restore(saved.announced);
        }
    }

    /// Gives the new pairs that were saved their contacts.
    pub fn fill(mut self, world: &mut World, pairs: &[Entity]) {
        if self.0.is_empty() {
            return;
        }
        let now = world.resource::<StepTime>().whole();
        let found = pairs.iter().filter_map(|&pair| {
            let bodies = world.get::<ContactPair>(pair)?.bodies;
            let (step, mut saved) = self.0.remove(&bodies)?;
            saved.change_step(step, now);
            Some((pair, saved.into_parts()))
        });
        let found: Vec<_> = found.collect();
        _ = world.try_insert_batch(found);
    }
}
