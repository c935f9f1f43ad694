//! Putting bodies back.

use super::region::{Body, Contact, Region};
use super::suspended::{End, Suspended, is_out};
use crate::body::{BodyIndex, BodyState, BodyTable, RigidBodyDisabled, Sleeping};
use crate::broadphase::Broadphase;
use crate::graph::{ConstraintGraph, Islands};
use crate::sensor::Sensors;
use crate::settings::ActiveSettings;
use bevy_ecs::entity::EntityHashMap;
use bevy_ecs::prelude::*;

/// Puts the bodies of a region back into the simulation, as they were when they were [taken out](super::take_out()). See the
/// [module](super) for what may have changed meanwhile. The world must be that from which they were taken.
///
/// Returns the bodies that were left out, because they were despawned, disabled by Bevy's `Disabled`, or enabled by you since.
pub fn put_back(world: &mut World, region: Region) -> Vec<Entity> {
    let Region {
        bodies,
        contacts,
        neighbours,
        settings,
    } = region;
    let entity = |body: &Body| body.state.entity;
    let (bodies, left_out): (Vec<Body>, Vec<Body>) =
        { bodies.into_iter() }.partition(|body| is_out(world, entity(body)));
    let left_out = left_out.iter().map(entity).collect();
    if bodies.is_empty() {
        return left_out;
    }
    let entities: Vec<Entity> = bodies.iter().map(entity).collect();
    let slots = join(world, bodies);
    connect(world, &slots, contacts, &neighbours);
    let has_changed = world.resource::<ActiveSettings>().changes() != settings;
    for &body in &entities {
        // Whoever heard of the one before may have despawned it.
        let Ok(mut body) = world.get_entity_mut(body) else {
            continue;
        };
        if has_changed && let Some(mut sleeping) = body.get_mut::<Sleeping>() {
            sleeping.wake();
        }
        // The hook of the marker has the body looked at in the next step: it may have been edited.
        body.remove::<RigidBodyDisabled>();
    }
    left_out
}

/// Adds the bodies to the table, the tree and the islands. Returns their slots.
fn join(world: &mut World, bodies: Vec<Body>) -> EntityHashMap<u32> {
    let mut slots = EntityHashMap::default();
    let mut entering = Vec::with_capacity(bodies.len());
    let mut boxes = Vec::with_capacity(bodies.len());
    let mut accounts = Vec::new();
    for body in bodies {
        let entity = body.state.entity;
        let slot = world.resource_mut::<BodyTable>().put_back(body.state);
        if let Some(mut index) = world.get_mut::<BodyIndex>(entity) {
            *index.bypass_change_detection() = BodyIndex(slot);
        }
        slots.insert(entity, slot);
        entering.push(slot);
        boxes.extend(body.aabb.map(|aabb| (slot, aabb)));
        accounts.extend(body.account.map(|account| (slot, account)));
    }
    if let Some(mut sensors) = world.get_resource_mut::<Sensors>() {
        sensors.note_arrived(entering.iter().copied());
    }
    world.resource_scope(|world, mut broadphase: Mut<Broadphase>| {
        broadphase.put_boxes(world.resource(), &boxes);
    });
    world.resource_scope(|world, mut graph: Mut<ConstraintGraph>| {
        world.resource_scope(|world, mut islands: Mut<Islands>| {
            islands.exchange(&mut graph, world.resource(), &entering, &[]);
            for (slot, account) in accounts {
                islands.open_account(slot, account);
            }
        });
    });
    slots
}

/// Spawns the pairs of the contacts that are as they were. Bodies of contacts that have ended wake; contacts with bodies that are out wait.
fn connect(
    world: &mut World,
    slots: &EntityHashMap<u32>,
    contacts: Vec<Contact>,
    neighbours: &[BodyState],
) {
    let mut suspended = std::mem::take(&mut world.resource_mut::<Suspended>().0);
    let mut bundles = Vec::with_capacity(contacts.len());
    let mut ended = Vec::new();
    let table = world.resource::<BodyTable>();
    let mut sort = |contact: Contact, ends: [End; 2]| {
        let [a, b] = ends;
        match (a, b) {
            (End::In(a), End::In(b)) => {
                let mut pair = contact.pair;
                pair.slots = [a, b];
                bundles.push((contact.links, (pair, contact.parts)));
                None
            }
            (End::Gone(_), _) | (_, End::Gone(_)) => {
                let ends = ends.into_iter().filter_map(End::slot);
                ended.extend(ends.filter(|_| contact.links));
                None
            }
            _ => Some(contact),
        }
    };
    let waiting = std::mem::take(&mut suspended).into_iter();
    suspended.extend(waiting.filter_map(|(contact, bodies)| {
        let end = |was: &BodyState| End::of(world, table, was, slots.get(&was.entity).copied());
        let ends = bodies.each_ref().map(end);
        Some((sort(contact, ends)?, bodies))
    }));
    let neighbour = |body: Entity| {
        let place = neighbours.binary_search_by_key(&body, |body| body.entity);
        place.ok().map(|place| &neighbours[place])
    };
    for contact in contacts {
        let bodies = contact.pair.bodies;
        let ends = bodies.map(|body| match (slots.get(&body), neighbour(body)) {
            (Some(&slot), _) => End::In(slot),
            (None, Some(was)) => End::of(world, table, was, None),
            (None, None) => End::Gone(None),
        });
        if let Some(contact) = sort(contact, ends) {
            let states = bodies.map(|body| {
                let own = slots.get(&body).and_then(|&slot| table.get(slot));
                let state = own.or_else(|| neighbour(body));
                state.expect("it is in, or was a neighbour").clone()
            });
            suspended.push((contact, states));
        }
    }
    world.resource_mut::<Suspended>().0 = suspended;
    let mut graph = world.resource_mut::<ConstraintGraph>();
    for slot in ended {
        graph.part(slot);
    }
    bundles.retain_mut(|(_, (pair, ..))| {
        let is_new = !graph.has_contact(pair.slots);
        if is_new {
            pair.edge = graph.insert_inactive(pair.slots);
        }
        is_new
    });
    let (links, bundles): (Vec<bool>, Vec<_>) = bundles.into_iter().unzip();
    let edges: Vec<u32> = bundles.iter().map(|(pair, ..)| pair.edge).collect();
    // Observers of pairs may use the graph.
    let pairs: Vec<Entity> = world.spawn_batch(bundles).collect();
    world.resource_scope(|world, mut graph: Mut<ConstraintGraph>| {
        for ((pair, edge), links) in pairs.into_iter().zip(edges).zip(links) {
            graph.name(edge, pair);
            graph.set_links(edge, links);
        }
        world.resource_scope(|world, mut islands: Mut<Islands>| {
            islands.exchange(&mut graph, world.resource(), &[], &[]);
        });
    });
}
