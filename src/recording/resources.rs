//! How recording and replay treat each resource on the list of the [state](crate::state).

use crate::body::{BodyTable, Noted};
use crate::joint_types::JointChanges;
use crate::snapshot::bytes::{decode, encode, read, write};
use crate::snapshot::{SnapshotError, renaming::Renaming};
use crate::state;
use crate::stored::Role;
use crate::stored::erased::{Kind, Values};
use bevy_ecs::entity::MapEntities;
use bevy_ecs::prelude::*;
use std::any::TypeId;

/// A resource that may be written between two steps.
pub(super) struct Resource {
    pub kind: Kind,
    part: Part,
}

/// The part of a resource that is recorded.
enum Part {
    All,
    /// Of the table of bodies, hooks write only some lists between two steps.
    Noted,
    /// The changes of joints that hooks have noted since the last step ended. Stages have noted so many before, and a replay has those
    /// already. They may name bonds of mortar that stages have spawned and despawned, and the recording does not know those entities.
    Later(ChangeCounts),
}

/// How many joints were written, and how many have lost their edge.
type ChangeCounts = (usize, usize);

/// The recorded part of a resource.
#[derive(Debug)]
pub(super) enum Value {
    All(Values),
    Noted(Noted),
    /// The changes that come after so many of stages.
    Later(ChangeCounts, JointChanges),
}

/// All resources on the list that may be written between two steps, in its order.
pub(super) fn all() -> Vec<Resource> {
    let resources = state::list().resources.iter().copied();
    let recorded = resources.filter(|kind| kind.has_code() && kind.role != Role::Events);
    let recorded = recorded.map(|kind| {
        let id = kind.type_id();
        let part = if id == TypeId::of::<BodyTable>() {
            Part::Noted
        } else if id == TypeId::of::<JointChanges>() {
            Part::Later(ChangeCounts::default())
        } else {
            Part::All
        };
        Resource { kind, part }
    });
    recorded.collect()
}

impl Resource {
    /// A step has ended, or the recording begins: what is noted from here on comes from outside.
    pub fn begin_outside(&mut self, world: &World) {
        if let Part::Later(of_stages) = &mut self.part {
            let changes = world.get_resource::<JointChanges>();
            let counts = changes.map(|changes| (changes.written.len(), changes.lost.len()));
            *of_stages = counts.unwrap_or_default();
        }
    }

    /// Appends the value to bytes.
    pub fn write(&self, world: &World, out: &mut Vec<u8>) -> Result<(), SnapshotError> {
        let name = self.kind.name();
        let missing = SnapshotError::MissingPlugin(name);
        match self.part {
            Part::All => {
                let value = self.kind.read(world).and_then(|known| known.resource());
                encode(value.ok_or(missing)?.values, out)
            }
            Part::Noted => write(&world.resource::<BodyTable>().noted(), name, out),
            Part::Later(of_stages) => {
                let changes = world.get_resource::<JointChanges>().ok_or(missing)?;
                let written = changes.written.get(of_stages.0..).unwrap_or_default();
                let lost = changes.lost.get(of_stages.1..).unwrap_or_default();
                write(&(of_stages, written, lost), name, out)
            }
        }
    }

    /// Takes a value from the front of bytes.
    pub fn read(&self, from: &mut &[u8]) -> Result<Value, SnapshotError> {
        match self.part {
            Part::All => {
                let mut values = Values::new(self.kind);
                decode(from, &mut values)?;
                Ok(Value::All(values))
            }
            Part::Noted => Ok(Value::Noted(read(from)?)),
            Part::Later(_) => {
                let (of_stages, written, lost) = read(from)?;
                Ok(Value::Later(of_stages, JointChanges { written, lost }))
            }
        }
    }
}

impl Value {
    /// Gives the resource of the world this value.
    pub fn put(&self, world: &mut World, to: &mut Renaming) {
        match self {
            Self::All(values) => {
                let mut value = values.clone();
                value.as_mut().map(to);
                value.insert_resource(world);
            }
            Self::Noted(noted) => {
                let mut noted = noted.clone();
                noted.map_entities(to);
                world.resource_mut::<BodyTable>().set_noted(noted);
            }
            Self::Later((written, lost), later) => {
                let mut later = later.clone();
                later.map_entities(to);
                let mut changes = world.resource_mut::<JointChanges>();
                changes.written.truncate(*written);
                changes.written.append(&mut later.written);
                changes.lost.truncate(*lost);
                changes.lost.append(&mut later.lost);
            }
        }
    }
}
