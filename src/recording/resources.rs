//! What recording and replay do with each resource on the list of the [state](crate::state).

use crate::body::{BodyTable, Noted};
use crate::broadphase::Broadphase;
use crate::children::Unassembled;
use crate::contact::{LostPairs, Untriggered};
use crate::graph::{ConstraintGraph, Islands};
use crate::joint::{BrokenJoints, JointChanges};
use crate::mortar::BrokenMortar;
use crate::sensor::UntriggeredSensorEvents;
use crate::snapshot::SnapshotError;
use crate::snapshot::bytes::{decode, encode, read, write};
use crate::snapshot::renaming::Renaming;
use crate::state;
use crate::stored::erased::{Kind, Values};
use crate::streaming::Suspended;
use bevy_ecs::component::ComponentId;
use bevy_ecs::entity::MapEntities;
use bevy_ecs::prelude::*;
use std::any::TypeId;
use std::fmt::Debug;

/// Some resource on the list.
pub(super) trait AnyResource: Send + Sync {
    /// Makes the world know the resource.
    fn register(&self, world: &mut World) -> ComponentId;

    /// Whether only stages write it. If it is written between two steps, the state was replaced, a part of it was taken out or put back, or
    /// a pair was despawned.
    fn is_of_stages(&self) -> bool;

    /// Whether hooks note in it what users have changed. It is recorded with every change, because the hooks of a replay may have noted
    /// something else.
    fn is_of_hooks(&self) -> bool;

    /// A step has ended, or the recording begins: what is noted from here on comes from outside.
    fn begin_outside(&mut self, _: &World) {}

    /// Appends the value to bytes.
    fn write(&self, world: &World, out: &mut Vec<u8>) -> Result<(), SnapshotError>;

    /// Takes a value from the front of bytes.
    fn read(&self, from: &mut &[u8]) -> Result<Box<dyn Value>, SnapshotError>;
}

/// The value of a resource that was read.
pub(super) trait Value: Debug + Send + Sync {
    /// Gives the resource of the world this value.
    fn put(&self, world: &mut World, to: &mut Renaming);
}

/// A resource that is recorded as a whole.
struct Kept(Kind);

impl AnyResource for Kept {
    fn register(&self, world: &mut World) -> ComponentId {
        self.0.register(world)
    }

    fn is_of_stages(&self) -> bool {
        let of_stages = [
            TypeId::of::<Broadphase>(),
            TypeId::of::<ConstraintGraph>(),
            TypeId::of::<Islands>(),
            TypeId::of::<LostPairs>(),
            TypeId::of::<Suspended>(),
        ];
        of_stages.contains(&self.0.type_id())
    }

    fn is_of_hooks(&self) -> bool {
        self.0.type_id() == TypeId::of::<Unassembled>()
    }

    fn write(&self, world: &World, out: &mut Vec<u8>) -> Result<(), SnapshotError> {
        let value = self.0.read(world).and_then(|known| known.resource());
        let value = value.ok_or(SnapshotError::MissingPlugin(self.0.name()))?;
        encode(value.values, out)
    }

    fn read(&self, from: &mut &[u8]) -> Result<Box<dyn Value>, SnapshotError> {
        let mut values = Values::new(self.0);
        decode(from, &mut values)?;
        Ok(Box::new(values))
    }
}

impl Value for Values {
    fn put(&self, world: &mut World, to: &mut Renaming) {
        let mut value = self.clone();
        value.as_mut().map(to);
        value.insert_resource(world);
    }
}

/// Of the table of bodies, hooks write only these lists between two steps.
struct Table;

impl AnyResource for Table {
    fn register(&self, world: &mut World) -> ComponentId {
        world.register_component::<BodyTable>()
    }

    fn is_of_stages(&self) -> bool {
        false
    }

    fn is_of_hooks(&self) -> bool {
        true
    }

    fn write(&self, world: &World, out: &mut Vec<u8>) -> Result<(), SnapshotError> {
        write(&world.resource::<BodyTable>().noted(), "BodyTable", out)
    }

    fn read(&self, from: &mut &[u8]) -> Result<Box<dyn Value>, SnapshotError> {
        Ok(Box::new(read::<Noted>(from)?))
    }
}

impl Value for Noted {
    fn put(&self, world: &mut World, to: &mut Renaming) {
        let mut noted = self.clone();
        noted.map_entities(to);
        world.resource_mut::<BodyTable>().set_noted(noted);
    }
}

/// The changes of joints that hooks have noted since the last step ended. Earlier ones were noted by stages, so a replay has them already.
/// They may name bonds of mortar that stages have spawned and despawned, and the recording does not know those entities.
#[derive(Default)]
struct Changes {
    of_stages: ChangeCounts,
}

/// How many joints were written, and how many have lost their edge.
type ChangeCounts = (usize, usize);

/// The number of changes that stages have noted, and those that came after them.
#[derive(Debug)]
struct LaterChanges(ChangeCounts, JointChanges);

impl AnyResource for Changes {
    fn register(&self, world: &mut World) -> ComponentId {
        world.register_component::<JointChanges>()
    }

    fn is_of_stages(&self) -> bool {
        false
    }

    fn is_of_hooks(&self) -> bool {
        true
    }

    fn begin_outside(&mut self, world: &World) {
        let changes = world.get_resource::<JointChanges>();
        let counts = changes.map(|changes| (changes.written.len(), changes.lost.len()));
        self.of_stages = counts.unwrap_or_default();
    }

    fn write(&self, world: &World, out: &mut Vec<u8>) -> Result<(), SnapshotError> {
        let changes = world.get_resource::<JointChanges>();
        let name = std::any::type_name::<JointChanges>();
        let changes = changes.ok_or(SnapshotError::MissingPlugin(name))?;
        let (written, lost) = self.of_stages;
        let written = changes.written.get(written..).unwrap_or_default();
        let lost = changes.lost.get(lost..).unwrap_or_default();
        write(&(self.of_stages, written, lost), name, out)
    }

    fn read(&self, from: &mut &[u8]) -> Result<Box<dyn Value>, SnapshotError> {
        let (of_stages, written, lost) = read(from)?;
        Ok(Box::new(LaterChanges(
            of_stages,
            JointChanges { written, lost },
        )))
    }
}

impl Value for LaterChanges {
    fn put(&self, world: &mut World, to: &mut Renaming) {
        let Self((written, lost), later) = self;
        let mut later = later.clone();
        later.map_entities(to);
        let mut changes = world.resource_mut::<JointChanges>();
        changes.written.truncate(*written);
        changes.written.append(&mut later.written);
        changes.lost.truncate(*lost);
        changes.lost.append(&mut later.lost);
    }
}

/// All resources on the list that may be written between two steps, in its order.
pub(super) fn all() -> Vec<Box<dyn AnyResource>> {
    // They are emptied when their events are triggered, after the stages; in a replay too.
    let of_events = [
        TypeId::of::<Untriggered>(),
        TypeId::of::<UntriggeredSensorEvents>(),
        TypeId::of::<BrokenJoints>(),
        TypeId::of::<BrokenMortar>(),
    ];
    let mut all: Vec<Box<dyn AnyResource>> = Vec::new();
    for &kind in &state::list().resources {
        let id = kind.type_id();
        if id == TypeId::of::<BodyTable>() {
            all.push(Box::new(Table));
        } else if id == TypeId::of::<JointChanges>() {
            all.push(Box::<Changes>::default());
        } else if kind.has_code() && !of_events.contains(&id) {
            all.push(Box::new(Kept(kind)));
        }
    }
    all
}
