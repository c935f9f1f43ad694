//! Taking bodies out.

use super::StreamingError;
use super::region::{Body, Contact, Region};
use crate::body::{
    BodyIndex, BodyState, BodyTable, Grab, HeldBy, Inactive, Pending, RigidBodyDisabled,
};
use crate::broadphase::Broadphase;
use crate::graph::{ConstraintGraph, EdgeKind, Islands};
use crate::pair::{LostPairs, clone_pair};
use crate::settings::{ActiveSettings, StepTime};
use crate::solver::sort;
use bevy_ecs::entity::EntityHashSet;
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::prelude::*;
use fixedbitset::FixedBitSet;

/// A body of the region: its slot and its entity.
type Found = (u32, Entity);

/// Takes bodies at rest out of the simulation. See the [module](super) for what becomes of them and of their neighbours.
///
/// Bodies that are named several times are taken out once. The cost is proportional to the number of the bodies and their contacts.
///
/// # Errors
/// If one of the bodies cannot be taken out. Nothing has changed then.
pub fn take_out(
    world: &mut World,
    bodies: impl IntoIterator<Item = Entity>,
) -> Result<Region, StreamingError> {
    if !world.contains_resource::<StepTime>() {
        return Err(StreamingError::MissingPlugin("StepPlugin"));
    }
    let found = find(world, bodies)?;
    let region = copy(world, &found)?;
    remove(world, &found);
    Ok(region)
}

/// Finds the slots of the bodies, in order of spawning, and checks the bodies themselves.
fn find(
    world: &World,
    bodies: impl IntoIterator<Item = Entity>,
) -> Result<Vec<Found>, StreamingError> {
    let (table, graph) = (
        world.resource::<BodyTable>(),
        world.resource::<ConstraintGraph>(),
    );
    let mut found = Vec::new();
    for body in bodies {
        let of = world.get_entity(body);
        let of = of.map_err(|_| StreamingError::NotABody(body))?;
        let slot = table.slot_of(world, body);
        let slot = slot.ok_or(StreamingError::NotABody(body))?;
        let state = table.get(slot).expect("it has this slot");
        if of.contains::<HeldBy>() || of.contains::<Grab>() {
            return Err(StreamingError::Held(body));
        }
        if let Some(joint) = graph.edges_of_kind(slot, EdgeKind::Joint).next() {
            return Err(StreamingError::Joined { body, joint });
        }
        if state.collider.is_some() && !state.radius.is_finite() {
            return Err(StreamingError::Unbounded(body));
        }
        if !table.is_inactive(slot) || !of.contains::<Inactive>() {
            return Err(StreamingError::NotAtRest(body));
        }
        found.push((state.spawn_order, slot, body));
    }
    sort::by_key(&mut found, |&(order, slot, body)| {
        (order, slot, body.to_bits())
    });
    found.dedup();
    Ok(found
        .into_iter()
        .map(|(_, slot, body)| (slot, body))
        .collect())
}

/// Copies what the simulation knows about the bodies, and checks their contacts.
fn copy(world: &World, found: &[Found]) -> Result<Region, StreamingError> {
    let (table, graph) = (
        world.resource::<BodyTable>(),
        world.resource::<ConstraintGraph>(),
    );
    let (broadphase, islands) = (world.resource::<Broadphase>(), world.resource::<Islands>());
    let mut is_out = FixedBitSet::with_capacity(table.slots());
    is_out.extend(found.iter().map(|&(slot, _)| slot as usize));
    let mut region = Region {
        settings: world.resource::<ActiveSettings>().changes(),
        ..Region::default()
    };
    region.bodies.reserve_exact(found.len());
    region.contacts.reserve(3 * found.len());
    for &(slot, body) in found {
        for (edge, links) in graph.edges_at(slot) {
            let other = edge.other(slot);
            let stays = !is_out.contains(other as usize);
            // A contact between two bodies of the region is taken with the later one.
            if !stays && edge.slots[0] == slot {
                continue;
            }
            let beside = table.get(other).expect("an edge has two bodies");
            if stays && links && beside.is_awake() {
                return Err(StreamingError::BesideAwake {
                    body,
                    other: beside.entity,
                });
            }
            let pair = world.get_entity(edge.pair).ok();
            let pair = pair.filter(|pair| !pair.contains::<Disabled>());
            let Some((pair, parts)) = pair.and_then(clone_pair) else {
                // The user has taken it apart, and the next step makes it anew.
                return Err(StreamingError::NotAtRest(body));
            };
            let rests = !graph.is_active(edge.edge);
            let settles = table.is_inactive(other) && !rests;
            if settles || pair.touching && !rests {
                return Err(StreamingError::NotAtRest(body));
            }
            if !rests {
                // Only the boxes overlap. The broadphase finds that again.
                continue;
            }
            if stays {
                region.neighbours.push(beside.clone());
            }
            region.contacts.push(Contact { pair, links, parts });
        }
        region.bodies.push(Body {
            state: table.get(slot).expect("it was just found").clone(),
            aabb: broadphase.box_of(slot),
            account: islands.account(slot),
        });
    }
    let entity = |body: &BodyState| body.entity;
    sort::by_key(&mut region.neighbours, |body| entity(body).to_bits());
    region.neighbours.dedup_by_key(|body| entity(body));
    Ok(region)
}

/// Removes the bodies and their pairs from the simulation.
fn remove(world: &mut World, found: &[Found]) {
    let graph = world.resource::<ConstraintGraph>();
    let edges = found.iter().flat_map(|&(slot, _)| graph.edges_at(slot));
    let edges: Vec<(u32, Entity)> = edges.map(|(edge, _)| (edge.edge, edge.pair)).collect();
    for &(_, pair) in &edges {
        world.try_despawn(pair).ok();
    }
    // These contacts have not ended, so nobody hears of them.
    let mut pairs: EntityHashSet = edges.iter().map(|&(_, pair)| pair).collect();
    let mut lost = world.resource_mut::<LostPairs>();
    lost.0.retain(|(pair, _)| !pairs.remove(pair));
    world.resource_scope(|world, mut graph: Mut<ConstraintGraph>| {
        for (edge, pair) in edges {
            graph.remove(edge, pair);
        }
        let slots: Vec<u32> = found.iter().map(|&(slot, _)| slot).collect();
        world.resource_mut::<Broadphase>().take_boxes(&slots);
        let mut table = world.resource_mut::<BodyTable>();
        for &(slot, body) in found {
            table.take_out(body, BodyIndex(slot));
        }
        world.resource_scope(|world, mut islands: Mut<Islands>| {
            islands.exchange(&mut graph, world.resource(), &[], &slots);
        });
    });
    for &(_, body) in found {
        world.resource_mut::<Pending>().remove(body);
        if let Some(mut index) = world.get_mut::<BodyIndex>(body) {
            *index.bypass_change_detection() = BodyIndex::NONE;
        }
    }
    let marked = found.iter().map(|&(_, body)| (body, RigidBodyDisabled));
    // Whoever heard of the pairs or of the one before may have despawned some.
    _ = world.try_insert_batch(marked.collect::<Vec<_>>());
}
