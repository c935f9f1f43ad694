//! Rest and activity: what sleeps or stands still gets the marker [`Inactive`], island by island, and with it leaves what the stages go through;
//! what something is done to is active again.
//!
//! A body goes to rest in the step after it has fallen asleep. A pair goes to rest in the step after both of its bodies have, once what they
//! last did has been told. A body that is disturbed becomes active with all of its pairs, so a pair rests only where both of its bodies do.

use super::ConstraintGraph;
use crate::body::{BodyTable, Inactive};
use bevy_ecs::prelude::*;

/// What is to go to rest.
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

/// Lays down what is to rest.
pub(super) fn deactivate(world: &mut World, Deactivation { bodies, pairs }: Deactivation) {
    let mut table = world.resource_mut::<BodyTable>();
    for &(slot, _) in &bodies {
        table.set_inactive(slot, true);
    }
    // Some of their bodies may just have become active.
    let rest = |slots: [u32; 2]| slots.into_iter().all(|slot| table.is_inactive(slot));
    let pairs = pairs.into_iter().filter(|&(_, slots)| rest(slots));
    let all = bodies.iter().map(|&(_, body)| body);
    let all: Vec<Entity> = all.chain(pairs.map(|(pair, _)| pair)).collect();
    // Who is gone by now is missed by *prepare*.
    let _ = world.try_insert_batch(all.into_iter().map(|entity| (entity, Inactive::new())));
    world.resource_scope(|world, mut graph: Mut<ConstraintGraph>| {
        let table = world.resource::<BodyTable>();
        for (slot, _) in bodies {
            graph.settle(slot, |other| table.is_inactive(other));
        }
    });
}

/// Part of the stages *prepare*, *broadphase* and *islands*: bodies that something was done to while they rested do so no more, nor do
/// their pairs.
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
        // Nobody has looked at what was edited while it rested.
        graph.report_all_of(slot);
    }
    for entity in marked {
        if let Ok(mut entity) = world.get_entity_mut(entity) {
            entity.remove::<Inactive>();
        }
    }
}
