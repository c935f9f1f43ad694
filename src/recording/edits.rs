//! Edits: the changes from outside between two steps, as they are written and replayed.
//!
//! Values are recorded, not actions: what every entity that was touched has become, and what hooks have noted for the next step. So a
//! replay need not repeat the order of the actions, and a value that was written twice is recorded once.

use super::kinds;
use super::resources::{Resource, Value};
use crate::body::SpawnOrder;
use crate::snapshot::bytes::{read, write};
use crate::snapshot::{SnapshotError, layout::Kinds, renaming::Renaming};
use crate::state;
use crate::stored::erased::Values;
use bevy_ecs::component::ComponentId;
use bevy_ecs::entity::{EntityHashMap, SceneEntityMapper};
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::prelude::*;

/// The entities that were changed.
#[derive(Clone, Debug, Default)]
pub(super) struct Touched {
    /// Those that were despawned.
    pub gone: Vec<Entity>,
    /// Entities that a stage has spawned, bonds of mortar for example, with their [`SpawnOrder`]: a replay has spawned them too.
    pub found: Vec<(Entity, u64)>,
    pub rows: Vec<Row>,
}

/// An entity that was spawned or written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Row {
    pub entity: Entity,
    /// The components on the list that it has, and no others; `None` if none was removed.
    pub has: Option<Kinds>,
    /// The components that were inserted or written; all of them if the entity is new.
    pub written: Kinds,
}

impl Row {
    /// The components whose values are recorded. If some were removed, those are all that it has: when a replay removes them, hooks may
    /// remove others, too.
    pub fn recorded(&self) -> Kinds {
        self.has.unwrap_or(self.written)
    }
}

/// Rows that follow each other and have the same components, as they are written.
type Group = (Option<u128>, u128, Vec<Entity>);

impl Touched {
    pub fn is_empty(&self) -> bool {
        self.gone.is_empty() && self.found.is_empty() && self.rows.is_empty()
    }

    fn groups(&self) -> Vec<Group> {
        let same = |a: &Row, b: &Row| a.has == b.has && a.written == b.written;
        let groups = self.rows.chunk_by(same).map(|rows| {
            let entities = rows.iter().map(|row| row.entity).collect();
            let Row { has, written, .. } = rows[0];
            (has.map(Kinds::bits), written.bits(), entities)
        });
        groups.collect()
    }

    /// Appends what was changed to bytes, without the values of components. `resources` are the numbers of those that were written.
    pub fn write(&self, resources: &[usize], out: &mut Vec<u8>) -> Result<(), SnapshotError> {
        let Self { gone, found, .. } = self;
        write(&(gone, found, self.groups(), resources), "edits", out)
    }

    fn read(from: &mut &[u8]) -> Result<(Self, Vec<usize>), SnapshotError> {
        type Read = (Vec<Entity>, Vec<(Entity, u64)>, Vec<Group>, Vec<usize>);
        let (gone, found, groups, resources): Read = read(from)?;
        let rows = groups.into_iter().flat_map(|(has, written, entities)| {
            let [has, written] = [has, Some(written)].map(|bits| bits.map(Kinds::from_bits));
            let rows = entities.into_iter().map(move |entity| Row {
                entity,
                has,
                written: written.unwrap_or_default(),
            });
            rows.collect::<Vec<_>>()
        });
        let rows = rows.collect();
        Ok((Self { gone, found, rows }, resources))
    }
}

/// The values of one component.
#[derive(Debug)]
struct Column {
    kind: usize,
    /// The rows that have it.
    rows: Vec<usize>,
    values: Values,
}

/// The edits between two steps, read from bytes.
#[derive(Debug)]
pub(super) struct Edits {
    touched: Touched,
    columns: Vec<Column>,
    resources: Vec<Value>,
}

impl Edits {
    /// Reads edits.
    pub fn read(from: &mut &[u8], known: &[Resource]) -> Result<Self, SnapshotError> {
        let (touched, numbers) = Touched::read(from)?;
        let mut columns = Vec::new();
        for (kind, &of) in state::list().components.iter().enumerate() {
            let rows = touched.rows.iter().enumerate();
            let rows = rows.filter(|(_, row)| row.recorded().contains(kind));
            let rows: Vec<usize> = rows.map(|(number, _)| number).collect();
            if !rows.is_empty() {
                let values = kinds::read(of, rows.len(), from)?;
                columns.push(Column { kind, rows, values });
            }
        }
        let resources = numbers.into_iter().map(|number| {
            let resource = known.get(number).ok_or(SnapshotError::Damaged)?;
            resource.read(from)
        });
        Ok(Self {
            resources: resources.collect::<Result<_, _>>()?,
            touched,
            columns,
        })
    }

    /// Makes the changes in a world. `map` has the entities of the world by those of the recording.
    pub fn make(&self, world: &mut World, ids: &[ComponentId], map: &mut EntityHashMap<Entity>) {
        self.find(world, map);
        let entities: Vec<Entity> = self
            .touched
            .rows
            .iter()
            .map(|row| {
                let known = map.get(&row.entity).copied();
                let known = known.filter(|&known| world.get_entity(known).is_ok());
                match known {
                    Some(known) => known,
                    None if row.has.is_some() => {
                        let new = world.spawn_empty().id();
                        map.insert(row.entity, new);
                        new
                    }
                    // The replay has lost it: its bodies differ from those that were recorded.
                    None => Entity::PLACEHOLDER,
                }
            })
            .collect();
        let gone = self.touched.gone.iter();
        let gone: Vec<Entity> = gone.filter_map(|entity| map.get(entity).copied()).collect();
        SceneEntityMapper::world_scope(map, world, |world, mapper| {
            let to = &mut Renaming::All(mapper);
            self.write(world, ids, &entities, to);
            if !gone.is_empty() {
                // Those that were their children have another parent by now, and stay.
                for &entity in &gone {
                    world.try_despawn(entity).ok();
                }
                // Hooks of those that are gone may have written others.
                self.write(world, ids, &entities, to);
            }
            for value in &self.resources {
                value.put(world, to);
            }
        });
        for entity in &self.touched.gone {
            map.remove(entity);
        }
    }

    /// Finds the entities that stages have spawned in this world, too.
    fn find(&self, world: &mut World, map: &mut EntityHashMap<Entity>) {
        if self.touched.found.is_empty() {
            return;
        }
        let mut numbered = world.query::<(Entity, &SpawnOrder, Has<Disabled>)>();
        let numbered = numbered.iter(world);
        let numbered: std::collections::HashMap<u64, Entity> = numbered
            .map(|(entity, order, _)| (order.0, entity))
            .collect();
        for (entity, order) in &self.touched.found {
            if let Some(&here) = numbered.get(order) {
                map.insert(*entity, here);
            }
        }
    }

    /// Gives the entities their components and values.
    fn write(
        &self,
        world: &mut World,
        ids: &[ComponentId],
        entities: &[Entity],
        to: &mut Renaming,
    ) {
        let columns = self.columns.iter().map(|column| {
            let entities = column.rows.iter().map(|&row| {
                let written = self.touched.rows[row].written;
                (entities[row], written.contains(column.kind))
            });
            (column, entities.collect())
        });
        let columns: Vec<(&Column, Vec<(Entity, bool)>)> = columns.collect();
        self.strip(world, ids, entities);
        for (column, entities) in &columns {
            kinds::insert(&column.values, world, entities, to);
            world.flush();
        }
        // Hooks may have inserted components that users have removed since.
        self.strip(world, ids, entities);
        for (column, entities) in &columns {
            kinds::put(&column.values, world, entities, to);
        }
        world.flush();
    }

    /// Removes the components that entities no longer have.
    fn strip(&self, world: &mut World, ids: &[ComponentId], entities: &[Entity]) {
        for (row, &entity) in self.touched.rows.iter().zip(entities) {
            let Some(has) = row.has else {
                continue;
            };
            for (number, &id) in ids.iter().enumerate() {
                if !has.contains(number)
                    && let Ok(mut entity) = world.get_entity_mut(entity)
                    && entity.contains_id(id)
                {
                    entity.remove_by_id(id);
                }
            }
        }
    }
}
