//! How recording and replay treat each component on the list of the [state](crate::state).

use crate::body::{new_rows, newer_than};
use crate::snapshot::bytes::{decode, encode};
use crate::snapshot::{SnapshotError, renaming::Renaming, replace_if_other};
use crate::stored::Role;
use crate::stored::erased::{How, In, Kind, Values};
use bevy_ecs::change_detection::Tick;
use bevy_ecs::entity::EntityMapper;
use bevy_ecs::prelude::*;

/// Finds the entities for which a component was inserted or written after `since`. Tables in which no entity is drystone's are left out by
/// `is_own`.
pub(super) fn find_written(
    kind: Kind,
    world: &World,
    since: Tick,
    is_own: &dyn Fn(Entity) -> bool,
    found: &mut Vec<Entity>,
) {
    let is_new = newer_than(since, world.read_change_tick());
    for cells in kind.read(world).map_or_else(Vec::new, In::all) {
        if kind.role != Role::Bevy || is_own(cells.entities[0]) {
            let written = new_rows(cells.changed, is_new);
            found.extend(written.map(|row| cells.entities[row]));
        }
    }
}

/// Appends the value of an entity to bytes, and the entities that it refers to.
pub(super) fn write(
    kind: Kind,
    world: &World,
    entity: Entity,
    referred: &mut Vec<Entity>,
    out: &mut Vec<u8>,
) -> Result<(), SnapshotError> {
    // It was found a moment ago.
    let Some(cells) = kind.read(world).and_then(|known| known.entity(entity)) else {
        return Err(SnapshotError::NotWritable(kind.name()));
    };
    Values::of(cells.values)
        .as_mut()
        .map(&mut Referred(referred));
    encode(cells.values, out)
}

/// Adds the entities that the values of all entities refer to.
pub(super) fn find_referred(kind: Kind, world: &World, referred: &mut Vec<Entity>) {
    // Bevy's own components refer to entities above others, which every snapshot has.
    if matches!(kind.role, Role::Bevy | Role::Pair) {
        return;
    }
    let mut values = Values::new(kind);
    for cells in kind.read(world).map_or_else(Vec::new, In::all) {
        values.clear();
        values.push(cells.values);
        values.as_mut().map(&mut Referred(referred));
    }
}

/// Takes as many values from the front of bytes.
pub(super) fn read(kind: Kind, count: usize, from: &mut &[u8]) -> Result<Values, SnapshotError> {
    let mut values = Values::new(kind);
    for _ in 0..count {
        decode(from, &mut values)?;
    }
    Ok(values)
}

/// Collects the entities that a value refers to.
struct Referred<'a>(&'a mut Vec<Entity>);

impl EntityMapper for Referred<'_> {
    fn get_mapped(&mut self, source: Entity) -> Entity {
        self.0.push(source);
        source
    }

    fn set_mapped(&mut self, _: Entity, _: Entity) {}
}

/// Inserts a component into those of the entities that lack it.
pub(super) fn insert(
    values: &Values,
    world: &mut World,
    entities: &[(Entity, bool)],
    to: &mut Renaming,
) {
    let id = values.kind().register(world);
    // Hooks may insert the component, but what is inserted here counts.
    let lacks = |&(_, &(entity, _)): &(usize, &(Entity, bool))| {
        let entity = world.get_entity(entity);
        entity.is_ok_and(|entity| !entity.contains_id(id))
    };
    let missing: Vec<_> = entities.iter().enumerate().filter(lacks).collect();
    for (at, &(entity, _)) in missing {
        if let Ok(mut entity) = world.get_entity_mut(entity) {
            let mut value = Values::of(values.one(at));
            to.apply(&mut value.as_mut());
            value.insert_into(&mut entity);
        }
    }
}

/// Gives entities their values. With each entity comes whether its value was written, or only kept.
pub(super) fn put(
    values: &Values,
    world: &mut World,
    entities: &[(Entity, bool)],
    to: &mut Renaming,
) {
    let mut value = Values::new(values.kind());
    for (at, &(entity, is_written)) in entities.iter().enumerate() {
        value.overwrite(0, values.one(at));
        to.apply(&mut value.as_mut());
        put_one(&mut value, world, entity, is_written);
    }
}

/// Gives an entity a value, which was written or only kept. It is marked as changed only if it differs.
fn put_one(value: &mut Values, world: &mut World, entity: Entity, is_written: bool) {
    let kind = value.kind();
    if kind.how == How::Replaced {
        replace_if_other(world, entity, value);
        return;
    }
    let now = world.change_tick();
    if let Some(mut known) = kind.write(world)
        && let Some(mut cells) = known.entity(entity)
    {
        let (new, old) = (value.as_slice(), cells.values.as_slice());
        // Equal values that were written may have other bits: 0 and -0. A value that was not written is not replaced by an equal one,
        // because stages compare compound shapes by identity: an equal shape would count as a new one.
        if is_written || !kind.is_compared() || old.first_difference(new).is_some() {
            Renaming::Nothing.write(&mut cells, 0, new, &mut Values::new(kind), now);
        }
    } else if let Ok(mut entity) = world.get_entity_mut(entity) {
        value.insert_into(&mut entity);
    }
}
