//! Deactivation and activation: island by island, sleeping and still bodies get the marker [`Inactive`], which removes them from the
//! queries of the stages, and their pairs leave the list of [active pairs](super::active). Bodies that are disturbed become active again.
//!
//! A body becomes inactive in the step after it fell asleep. A pair becomes inactive in the step after both of its bodies did, once its
//! last events were sent. A body that is disturbed becomes active with all of its pairs, so a pair is inactive only if both of its bodies
//! are.

use super::ConstraintGraph;
use super::active::find_active_rows;
use crate::body::{BodyTable, Inactive, Sleeping};
use crate::components::remove;
use bevy_ecs::component::Components;
use bevy_ecs::prelude::*;

/// Bodies and pairs that are about to become inactive.
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Deactivation {
    pub bodies: Vec<(u32, Entity)>,
    /// The numbers of their edges, and the slots of their bodies.
    pub pairs: Vec<(u32, [u32; 2])>,
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
        // A static body may have been disturbed in this step, which wakes nothing.
        if let Some(body) = table.get_mut(slot) {
            body.disturbed = false;
        }
    }
    let marked = bodies.iter().map(|&(_, body)| (body, Inactive::new()));
    let marked: Vec<_> = marked.collect();
    // The stage *prepare* notices entities that do not exist any more.
    let _ = world.try_insert_batch(marked);
    world.resource_scope(|world, mut graph: Mut<ConstraintGraph>| {
        let table = world.resource::<BodyTable>();
        // Some bodies may have become active in the meantime.
        let rest = |slots: [u32; 2]| slots.into_iter().all(|slot| table.is_inactive(slot));
        for (edge, _) in pairs.into_iter().filter(|&(_, slots)| rest(slots)) {
            graph.set_active(edge, false);
        }
        for (slot, _) in bodies {
            graph.settle(slot, |other| table.is_inactive(other));
        }
    });
    find_active_rows(world);
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
        let body = table.get(slot);
        let Some((entity, is_dynamic)) = body.map(|body| (body.entity, body.is_dynamic())) else {
            continue;
        };
        if table.set_inactive(slot, false) {
            risen.push((slot, entity, is_dynamic));
        }
    }
    let mut graph = world.resource_mut::<ConstraintGraph>();
    for &(slot, ..) in &risen {
        graph.activate_contacts_of(slot);
        // Edits of an inactive pair have not been checked yet.
        graph.report_all_of(slot);
    }
    for (_, body, is_dynamic) in risen {
        remove(world, body, &[Components::component_id::<Inactive>]);
        // Whoever heard of it may have despawned it.
        let mut sleeping = world.get_mut::<Sleeping>(body);
        if let Some(sleeping) = sleeping.as_mut().filter(|_| is_dynamic) {
            // It was woken while it was inactive, without a mark.
            sleeping.set_changed();
        }
    }
    find_active_rows(world);
}
