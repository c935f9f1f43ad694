//! Where the entities of a snapshot are in the world that it is restored into.

use super::layout::{KnownKinds, Layout, own_tables};
use bevy_ecs::entity::{Entity, EntityHashMap};
use bevy_ecs::world::World;

/// No entity of the snapshot.
pub(super) const NOWHERE: u32 = u32::MAX;

/// The rows of a snapshot that the rows of a table are.
#[derive(Debug)]
pub(super) enum Rows {
    /// Those of a run, in its order.
    Run(usize),
    /// One by one; [`NOWHERE`] for other entities.
    Each(Vec<u32>),
}

/// The rows of a snapshot by the index of their entity.
#[derive(Debug)]
pub(super) enum RowsByIndex {
    List(Vec<u32>),
    /// Few entities with large indices: those of damaged bytes may have any.
    Map(EntityHashMap<u32>),
}

/// A list has at most so many entries for each entity, and so many more.
const MAX_LENGTH: [usize; 2] = [64, 1 << 16];

impl RowsByIndex {
    pub fn new(entities: &[Entity]) -> Self {
        let last = entities.iter().map(|entity| entity.index_u32()).max();
        let len = last.map_or(0, |last| last as usize + 1);
        if len > MAX_LENGTH[0] * entities.len() + MAX_LENGTH[1] {
            return Self::Map(entities.iter().copied().zip(0..).collect());
        }
        let mut rows = vec![NOWHERE; len];
        for (row, entity) in entities.iter().enumerate() {
            rows[entity.index_u32() as usize] = row as u32;
        }
        Self::List(rows)
    }

    /// The row of an entity, or [`NOWHERE`].
    pub fn of(&self, entity: Entity, entities: &[Entity]) -> u32 {
        let row = match self {
            Self::List(rows) => rows.get(entity.index_u32() as usize),
            Self::Map(rows) => rows.get(&entity),
        };
        let row = row.copied().unwrap_or(NOWHERE);
        match entities.get(row as usize) {
            Some(&known) if known == entity => row,
            _ => NOWHERE,
        }
    }
}

/// Where the entities of a snapshot are.
#[derive(Debug)]
pub(super) struct Target<'a> {
    pub layout: &'a Layout,
    /// The entities in the world, by row.
    pub entities: &'a [Entity],
    /// The first entity of each table, and its rows.
    tables: Vec<(Entity, Rows)>,
    /// The run of each row, if some table has other rows than a run.
    runs: Vec<u32>,
}

impl<'a> Target<'a> {
    pub fn find(
        layout: &'a Layout,
        entities: &'a [Entity],
        world: &World,
        known: &KnownKinds,
    ) -> Self {
        let mut by_index = None;
        let tables = own_tables(world, known).map(|(_, table, _)| {
            let here = table.entities();
            let rows = match run_with(layout, entities, here) {
                Some(run) => Rows::Run(run),
                None => {
                    let by_index = by_index.get_or_insert_with(|| RowsByIndex::new(entities));
                    let rows = here.iter().map(|&entity| by_index.of(entity, entities));
                    Rows::Each(rows.collect())
                }
            };
            (here[0], rows)
        });
        let tables: Vec<_> = tables.collect();
        let mut runs = Vec::new();
        if by_index.is_some() {
            let numbers = (0..).zip(&layout.runs);
            runs.extend(numbers.flat_map(|(number, run)| std::iter::repeat_n(number, run.len)));
        }
        Self {
            layout,
            entities,
            tables,
            runs,
        }
    }

    /// The rows of the entities of a table.
    pub fn rows_of(&self, entities: &[Entity]) -> Option<&Rows> {
        let first = entities.first()?;
        let mut tables = self.tables.iter();
        Some(&tables.find(|(known, _)| known == first)?.1)
    }

    /// The run of a row that is not in a table of a run.
    pub fn run_of(&self, row: u32) -> usize {
        self.runs[row as usize] as usize
    }
}

/// The run whose entities are these, in this order.
pub(super) fn run_with(layout: &Layout, entities: &[Entity], here: &[Entity]) -> Option<usize> {
    let tables = &layout.runs[..layout.tables];
    tables
        .iter()
        .position(|run| entities[run.start] == here[0] && entities[run.rows()] == *here)
}
