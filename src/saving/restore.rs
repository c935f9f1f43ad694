//! Loading: part of the stage *prepare*. The contacts of a scene wait in [`Restored`] until the stage *broadphase* has made their pairs.

use super::{Saved, SavedContact};
use crate::body::{BodyTable, SpawnOrder};
use crate::children;
use crate::contact::ContactPair;
use crate::graph::Wrench;
use crate::joint::JointForces;
use crate::sensor::SensorOverlap;
use crate::settings::StepTime;
use crate::solver::sort;
use bevy_ecs::entity::{EntityHashMap, EntityMapper, MapEntities};
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::prelude::*;
use bevy_ecs::world::DeferredWorld;
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
    contacts: HashMap<[Entity; 2], (f32, SavedContact)>,
    #[cfg_attr(
        feature = "serde",
        serde(serialize_with = "crate::stored::written::sorted")
    )]
    inside: EntityHashMap<Vec<SensorOverlap>>,
    /// The bodies, colliders and joints of the scene, with the accounts of sleeping bodies.
    #[cfg_attr(
        feature = "serde",
        serde(serialize_with = "crate::stored::written::sorted")
    )]
    accounts: EntityHashMap<Option<Wrench>>,
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

/// Run condition: a scene was loaded or saved since the last step.
pub fn any_saved(saved: Query<(), (With<Saved>, Allow<Disabled>)>) -> bool {
    !saved.is_empty()
}

/// Takes up the [`Saved`] of all entities.
pub fn restore(world: &mut World, saved: &mut QueryState<(Entity, &Saved), Allow<Disabled>>) {
    let mut loaded: Vec<(u64, Entity)> = saved
        .iter(world)
        .map(|(entity, saved)| (saved.spawn_order, entity))
        .collect();
    sort::by_key(&mut loaded, |&(order, entity)| (order, entity.index_u32()));
    restore_order(world, &loaded);
    let mut restored = world.remove_resource::<Restored>().unwrap_or_default();
    for (_, entity) in loaded {
        // Whoever heard of the one before may have despawned it.
        let saved = world.get_entity_mut(entity);
        let Some(saved) = saved.ok().and_then(|mut entity| entity.take::<Saved>()) else {
            continue;
        };
        restored.accounts.insert(entity, saved.account);
        for contact in saved.contacts {
            let bodies = [contact.other, entity];
            restored.contacts.insert(bodies, (saved.step, contact));
        }
        if !saved.inside.is_empty() {
            restored.inside.insert(entity, saved.inside);
        }
        if let Some(saved) = saved.joint
            && let Some(mut forces) = world.get_mut::<JointForces>(entity)
        {
            forces.set_if_neq(saved);
        }
    }
    world.insert_resource(restored);
}

/// Exchanges the numbers of loaded entities, so that these are in the order in which they were saved. The numbers stay unique.
fn restore_order(world: &mut World, loaded: &[(u64, Entity)]) {
    let orders = loaded.iter().filter_map(|&(_, entity)| {
        let order = world.get::<SpawnOrder>(entity)?;
        Some((entity, *order))
    });
    let (entities, mut orders): (Vec<Entity>, Vec<SpawnOrder>) = orders.unzip();
    // They were loaded before the plugins were added.
    for order in &mut orders {
        if *order == SpawnOrder::NONE {
            *order = world.resource_mut::<BodyTable>().next_spawn_order();
        }
    }
    orders.sort_unstable();
    for (entity, order) in entities.into_iter().zip(orders) {
        if world
            .get::<SpawnOrder>(entity)
            .is_some_and(|known| *known != order)
        {
            world.entity_mut(entity).insert(order);
            if world.get_entity(entity).is_ok() {
                children::mark_if_part(&mut DeferredWorld::from(&mut *world), entity);
            }
        }
    }
}
