//! Deactivation and activation: island by island, sleeping and still bodies get the marker [`Inactive`], which removes them from the queries
//! of the stages. Bodies that are disturbed become active again.
//!
//! A body becomes inactive in the step after it fell asleep. A pair becomes inactive in the step after both of its bodies did, once its last
//! events were sent. A body that is disturbed becomes active with all of its pairs, so a pair is inactive only if both of its bodies are.

use super::ConstraintGraph;
use crate::body::{BodyTable, Inactive};
use bevy_ecs::prelude::*;

/// Bodies and pairs that are about to become inactive.
#[derive(Clone, Debug, Default)]
pub(super) struct Deactivation {
    pub bodies: Vec<(u32, Entity)>,
    pub pairs: Vec<(Entity, [u32; 2])>,
}

impl Deactivation {
    pub fn is_empty(&self) -> bool {
        self.bodies.is_empty() && self.pairs.is_empty()
    }
}

/// Makes bodies and pairs inactive.
pub(super) fn deactivate(world: &mut World, Deactivation { bodies, pairs }: Deactivation) {
    let mut table = world.resource_mut::<BodyTable>();
    for &(slot, _) in &bodies {
        table.set_inactive(slot, true);
    }
    // Some bodies may have become active in the meantime.
    let rest = |slots: [u32; 2]| slots.into_iter().all(|slot| table.is_inactive(slot));
    let pairs = pairs.into_iter().filter(|&(_, slots)| rest(slots));
    let all = bodies.iter().map(|&(_, body)| body);
    let all: Vec<Entity> = all.chain(pairs.map(|(pair, _)| pair)).collect();
    // The stage *prepare* notices entities that do not exist any more.
    let _ = world.try_insert_batch(all.into_iter().map(|entity| (entity, Inactive::new())));
    world.resource_scope(|world, mut graph: Mut<ConstraintGraph>| {
        let table = world.resource::<BodyTable>();
        for (slot, _) in bodies {
            graph.settle(slot, |other| table.is_inactive(other));
        }
    });
}

/// Whether bodies were marked as dirty.
#[doc(hidden)]
pub fn any_disturbed(table: Res<BodyTable>) -> bool {
    !table.dirty.is_empty()
}

/// Makes bodies that were marked as dirty active, together with their pairs. Part of the stages *prepare*, *broadphase* and *islands*.
pub fn activate(world: &mut World) {
    let mut table = world.resource_mut::<BodyTable>();
    if table.dirty.is_empty() {
        return;
    }
    let dirty = std::mem::take(&mut table.dirty);
    let mut risen = Vec::new();
    for slot in dirty {
        let Some(entity) = table.get(slot).map(|body| body.entity) else {
            continue;
        };
        if table.set_inactive(slot, false) {
            risen.push((slot, entity));
        }
    }
    let mut graph = world.resource_mut::<ConstraintGraph>();
    let mut marked: Vec<Entity> = Vec::new();
    for &(slot, body) in &risen {
        marked.push(body);
        marked.extend(graph.edges_of(slot));
        // Edits of an inactive pair have not been checked yet.
        graph.report_all_of(slot);
    }
    for entity in marked {
        if let Ok(mut entity) = world.get_entity_mut(entity) {
            entity.remove::<Inactive>();
        }
    }
}
