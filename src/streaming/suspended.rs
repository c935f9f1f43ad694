//! Contacts between two regions of which only one is in.

use super::region::Contact;
use crate::body::{BodyIndex, BodyState, BodyTable, Inactive, RigidBody};
use bevy_ecs::entity::{EntityMapper, MapEntities};
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::prelude::*;

/// Contacts of bodies that are in with bodies that are out, until those are back.
#[derive(Resource, Clone, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[component(map_entities)]
#[doc(hidden)]
pub struct Suspended(pub(super) Vec<(Contact, [BodyState; 2])>);

impl MapEntities for Suspended {
    fn map_entities<M: EntityMapper>(&mut self, mapper: &mut M) {
        for (contact, bodies) in &mut self.0 {
            contact.pair.bodies.map_entities(mapper);
            for body in bodies {
                body.map_entities(mapper);
            }
        }
    }
}

/// Where one of the bodies of a contact is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum End {
    /// In this slot, as it was when the contact was taken out.
    In(u32),
    /// Out, so that the contact waits.
    Out,
    /// It was despawned, moved or changed, so that the contact has ended. The slot, if it is in.
    Gone(Option<u32>),
}

impl End {
    /// Where a body is, and whether it is as it was. `own` is its slot if it is being put back.
    pub fn of(world: &World, table: &BodyTable, was: &BodyState, own: Option<u32>) -> Self {
        if own.is_none() && is_out(world, was.entity) {
            return Self::Out;
        }
        // A body that is being put back still has the marker with which it has no slot.
        let slot = own.or_else(|| table.slot_of(world, was.entity));
        let slot = slot.filter(|&slot| table.get(slot).is_some_and(|now| is_same(now, was)));
        match slot {
            Some(slot) if table.is_inactive(slot) => Self::In(slot),
            slot => Self::Gone(slot),
        }
    }

    /// The slot of a body that is in.
    pub fn slot(self) -> Option<u32> {
        match self {
            Self::In(slot) | Self::Gone(Some(slot)) => Some(slot),
            _ => None,
        }
    }
}

/// Returns true if a body was taken out, and is as it was left then.
pub(super) fn is_out(world: &World, body: Entity) -> bool {
    world.get_entity(body).is_ok_and(|of| {
        of.get() == Some(&BodyIndex::NONE)
            && of.contains::<Inactive>()
            && of.contains::<RigidBody>()
            && !of.contains::<Disabled>()
    })
}

/// Returns true if contacts with a body are as they were.
fn is_same(now: &BodyState, was: &BodyState) -> bool {
    now.spawn_order == was.spawn_order
        && now.pose == was.pose
        && now.kind == was.kind
        && now.mass == was.mass
        && now.properties == was.properties
        && match (&now.collider, &was.collider) {
            (Some(now), Some(was)) => now.is_same(was),
            (now, was) => now.is_none() && was.is_none(),
        }
}
