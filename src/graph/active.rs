//! The active pairs: those that the stages visit.
//!
//! An inactive pair stays in its table of the ECS, between pairs that are active. Tables never shrink, so a pair that moved to another
//! table when it became inactive would take its memory twice: a wall that had been awake once took 2.8 kB a brick more. Moving it also took
//! longer than solving it once. So the [graph](ConstraintGraph) remembers which edges are active, and the stages visit the *runs* of active
//! rows of each table. While nothing is inactive, a table is one run.
//!
//! The rows are derived from the list of active edges and from the places of their entities. Systems between two stages may despawn pairs
//! or move them into other tables. So the entities of the rows are compared before the rows are used, and rows that have changed are found
//! anew.

use super::ConstraintGraph;
use crate::stored::clone_fields;
use bevy_ecs::entity::{Entities, Entity};
use bevy_ecs::prelude::*;
use bevy_ecs::storage::TableId;
use fixedbitset::FixedBitSet;
use std::ops::{Deref, Range};

/// The active rows of the tables of pairs, while some pair is inactive.
#[derive(Debug, Default)]
pub(super) struct ActiveRows(Vec<TableRows>);

impl Clone for ActiveRows {
    fn clone(&self) -> Self {
        Self(self.0.clone())
    }

    fn clone_from(&mut self, from: &Self) {
        self.0.clone_from(&from.0);
    }
}

/// The active rows of one table.
#[derive(Debug)]
struct TableRows {
    table: TableId,
    runs: Vec<Range<u32>>,
    /// The entities of the active rows, in their order.
    entities: Vec<Entity>,
    /// The number of rows, and the entity of the last one. A pair that moves into the table changes these, unless it takes the place of an
    /// inactive one that leaves the table at the same time: that is not noticed.
    end: (usize, Option<Entity>),
    /// Scratch.
    rows: FixedBitSet,
}

clone_fields!(TableRows {
    table,
    runs,
    entities,
    end,
    rows,
});

fn end_of(entities: &[Entity]) -> (usize, Option<Entity>) {
    (entities.len(), entities.last().copied())
}

impl TableRows {
    /// Returns true if the rows still hold the same entities.
    fn match_entities(&self, entities: &[Entity]) -> bool {
        let mut known = &*self.entities;
        let is_same = self.end == end_of(entities);
        is_same
            && self.runs.iter().all(|run| {
                let (these, others) = known.split_at(run.len());
                known = others;
                entities.get(run.start as usize..run.end as usize) == Some(these)
            })
    }
}

/// Runs of the rows of a table.
pub(crate) enum Runs<'a> {
    /// All rows.
    All([Range<u32>; 1]),
    Known(&'a [Range<u32>]),
    Found(Vec<Range<u32>>),
}

impl Deref for Runs<'_> {
    type Target = [Range<u32>];

    fn deref(&self) -> &Self::Target {
        match self {
            Self::All(all) => all,
            Self::Known(runs) => runs,
            Self::Found(runs) => runs,
        }
    }
}

impl ConstraintGraph {
    /// The runs of active rows in a table of pairs, of which these are the entities. It has at least one row.
    pub(crate) fn active_rows(&self, entities: &[Entity], places: &Entities) -> Runs<'_> {
        if self.inactive_count() == 0 {
            let all = 0..entities.len() as u32;
            return Runs::All([all]);
        }
        let table = entities.first().and_then(|&first| table_of(places, first));
        let Some((table, _)) = table else {
            return Runs::Found(Vec::new());
        };
        let known = match self.active_rows_changed {
            true => None,
            false => self.active_rows.of(table),
        };
        match known {
            Some(known) if known.match_entities(entities) => Runs::Known(&known.runs),
            _ => {
                let rows = self.active_pairs();
                let rows = rows.filter_map(|pair| table_of(places, pair));
                let mut rows = rows.filter(|&(of, _)| of == table).peekable();
                if rows.peek().is_none() {
                    // Nothing is allocated for a table in which all pairs are inactive.
                    return Runs::Found(Vec::new());
                }
                let mut active = FixedBitSet::with_capacity(entities.len());
                rows.for_each(|(_, row)| active.insert(row));
                Runs::Found(runs_of(&active).collect())
            }
        }
    }
}

impl ActiveRows {
    fn of(&self, table: TableId) -> Option<&TableRows> {
        self.0.iter().find(|known| known.table == table)
    }

    /// Returns true if no pair has come into one of the tables since the rows were found.
    fn match_ends(&self, world: &World) -> bool {
        let tables = &world.storages().tables;
        self.0.iter().all(|known| {
            let table = tables.get(known.table);
            table.is_some_and(|table| end_of(table.entities()) == known.end)
        })
    }

    /// Finds the rows of pairs.
    fn find(&mut self, pairs: impl Iterator<Item = Entity>, world: &World) {
        for known in &mut self.0 {
            known.rows.clear();
        }
        for entity in pairs {
            let Some((table, row)) = table_of(world.entities(), entity) else {
                continue;
            };
            let known = self.0.iter().position(|known| known.table == table);
            let known = known.unwrap_or_else(|| {
                self.0.push(TableRows {
                    table,
                    runs: Vec::new(),
                    entities: Vec::new(),
                    end: end_of(&[]),
                    rows: FixedBitSet::new(),
                });
                self.0.len() - 1
            });
            self.0[known].rows.grow_and_insert(row);
        }
        self.0.retain(|known| !known.rows.is_clear());
        let tables = &world.storages().tables;
        for known in &mut self.0 {
            known.runs.clear();
            known.runs.extend(runs_of(&known.rows));
            let table = tables.get(known.table);
            let entities = table.map_or(&[][..], |table| table.entities());
            known.end = end_of(entities);
            let runs = known.runs.iter();
            let entities = runs.flat_map(|run| &entities[run.start as usize..run.end as usize]);
            known.entities.clear();
            known.entities.extend(entities);
        }
    }
}

/// The table and the row of an entity.
fn table_of(places: &Entities, entity: Entity) -> Option<(TableId, usize)> {
    let place = places.get(entity).ok().flatten()?;
    Some((place.table_id, place.table_row.index()))
}

/// The runs of ones.
fn runs_of(rows: &FixedBitSet) -> impl Iterator<Item = Range<u32>> {
    let mut ones = rows.ones().map(|row| row as u32).peekable();
    std::iter::from_fn(move || {
        let start = ones.next()?;
        let mut end = start + 1;
        while ones.next_if_eq(&end).is_some() {
            end += 1;
        }
        Some(start..end)
    })
}

/// Brings the runs of active rows up to date after pairs have come, gone, or become active or inactive.
pub(super) fn find_active_rows(world: &mut World) {
    let graph = world.resource::<ConstraintGraph>();
    if !graph.active_rows_changed && graph.active_rows.match_ends(world) {
        return;
    }
    world.resource_scope(|world, mut graph: Mut<ConstraintGraph>| {
        let graph = &mut *graph;
        if graph.inactive_count() > 0 {
            graph.active_rows_changed = false;
            let mut rows = std::mem::take(&mut graph.active_rows);
            rows.find(graph.active_pairs(), world);
            graph.active_rows = rows;
        }
    });
}
