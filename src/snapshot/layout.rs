//! Which entities a snapshot holds, and which components each of them has.
//!
//! An entity belongs to a snapshot if it has a component of drystone that is on the list of the [state](crate::state). So do the entities
//! above it in the hierarchy, because their `Transform` decides where it is.

use super::column::Column;
use bevy_ecs::component::ComponentId;
use bevy_ecs::entity::{Entity, EntityHashSet};
use bevy_ecs::hierarchy::ChildOf;
use bevy_ecs::storage::{Table, TableId};
use bevy_ecs::world::{EntityRef, World};

/// Components on the list, one bit each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Kinds(u128);

impl Kinds {
    #[cfg(feature = "serde")]
    pub fn bits(self) -> u128 {
        self.0
    }

    #[cfg(feature = "serde")]
    pub fn from_bits(bits: u128) -> Self {
        Self(bits)
    }

    pub fn contains(self, kind: usize) -> bool {
        self.0 & (1 << kind) != 0
    }

    pub fn insert(&mut self, kind: usize) {
        self.0 |= 1 << kind;
    }

    /// Adds those of another.
    #[cfg(feature = "serde")]
    pub fn extend(&mut self, other: Self) {
        self.0 |= other.0;
    }

    /// Returns true if the two have a component in common.
    pub fn meets(self, other: Self) -> bool {
        self.0 & other.0 != 0
    }
}

/// The components on the list, as a world knows them.
#[derive(Debug, Default)]
pub(super) struct KnownKinds {
    /// By kind. `None` if the world does not know the component, or keeps it outside of tables.
    pub ids: Vec<Option<ComponentId>>,
    /// Those of drystone.
    pub own: Kinds,
}

impl KnownKinds {
    pub fn of_world(world: &World, columns: &[Column]) -> Self {
        let mut own = Kinds::default();
        for (kind, column) in columns.iter().enumerate() {
            if !column.is_shared() {
                own.insert(kind);
            }
        }
        let ids = columns.iter().map(|column| column.id(world.components()));
        Self {
            ids: ids.collect(),
            own,
        }
    }

    /// The components of the entities in a table.
    pub fn of_table(&self, table: &Table) -> Kinds {
        self.of(|id| table.has_column(id))
    }

    /// The components of an entity.
    pub fn of_entity(&self, entity: EntityRef) -> Kinds {
        self.of(|id| entity.contains_id(id))
    }

    fn of(&self, has: impl Fn(ComponentId) -> bool) -> Kinds {
        let mut kinds = Kinds::default();
        for (kind, id) in self.ids.iter().enumerate() {
            if id.is_some_and(&has) {
                kinds.insert(kind);
            }
        }
        kinds
    }
}

/// Entities with the same components, which follow each other.
#[derive(Clone, Debug)]
pub(super) struct Run {
    /// Index of the first entity.
    pub start: usize,
    /// Number of entities.
    pub len: usize,
    pub kinds: Kinds,
}

impl Run {
    pub fn rows(&self) -> std::ops::Range<usize> {
        self.start..self.start + self.len
    }
}

/// There is no run.
const NONE: u32 = u32::MAX;

/// The entities of a snapshot, table by table.
#[derive(Clone, Debug, Default)]
pub(super) struct Layout {
    pub entities: Vec<Entity>,
    /// First the tables; then the entities above others, a run each.
    pub runs: Vec<Run>,
    /// Number of runs that are tables.
    pub tables: usize,
    /// The run of each table of the world that the snapshot was taken of.
    by_table: Vec<u32>,
}

impl Layout {
    /// The entities of no world.
    #[cfg(feature = "serde")]
    pub fn new(entities: Vec<Entity>, runs: Vec<Run>, tables: usize) -> Self {
        Self {
            entities,
            runs,
            tables,
            by_table: Vec::new(),
        }
    }

    /// Finds the entities of a world.
    pub fn find(&mut self, world: &World, known: &KnownKinds) {
        self.entities.clear();
        self.runs.clear();
        self.by_table.clear();
        let mut has_parents = false;
        let parent = world.components().component_id::<ChildOf>();
        for (id, table, kinds) in own_tables(world, known) {
            self.by_table.resize(id.as_usize() + 1, NONE);
            self.by_table[id.as_usize()] = self.runs.len() as u32;
            has_parents |= parent.is_some_and(|parent| table.has_column(parent));
            self.push(table.entities(), kinds);
        }
        self.tables = self.runs.len();
        if has_parents {
            self.find_ancestors(world, known);
        }
    }

    /// Adds entities that belong to the snapshot only because something refers to them.
    pub fn add(&mut self, world: &World, known: &KnownKinds, others: &[Entity]) {
        if others.is_empty() {
            return;
        }
        let mut seen: EntityHashSet = self.entities.iter().copied().collect();
        for &other in others {
            if seen.insert(other)
                && let Ok(entity) = world.get_entity(other)
            {
                self.push(&[other], known.of_entity(entity));
            }
        }
    }

    fn push(&mut self, entities: &[Entity], kinds: Kinds) {
        self.runs.push(Run {
            start: self.entities.len(),
            len: entities.len(),
            kinds,
        });
        self.entities.extend_from_slice(entities);
    }

    fn find_ancestors(&mut self, world: &World, known: &KnownKinds) {
        let mut seen: EntityHashSet = self.entities.iter().copied().collect();
        for row in 0..self.entities.len() {
            let parent = |entity| world.get::<ChildOf>(entity).map(ChildOf::parent);
            let mut next = parent(self.entities[row]);
            while let Some(at) = next.filter(|&at| seen.insert(at)) {
                if let Ok(entity) = world.get_entity(at) {
                    self.push(&[at], known.of_entity(entity));
                }
                next = parent(at);
            }
        }
    }

    /// The tables of the world that the snapshot was taken of, with their runs.
    pub fn tables(&self) -> impl Iterator<Item = (TableId, usize)> {
        let runs = self.by_table.iter().enumerate();
        let runs = runs.filter(|&(_, &run)| run != NONE);
        runs.map(|(table, &run)| (TableId::from_usize(table), run as usize))
    }

    /// Returns true if some of the entities have the component with this number on the list.
    pub fn has(&self, kind: usize) -> bool {
        self.runs.iter().any(|run| run.kinds.contains(kind))
    }

    /// The run of a row.
    pub fn run_of_row(&self, row: usize) -> usize {
        self.runs.partition_point(|run| run.start + run.len <= row)
    }

    /// The runs of entities above others, with their numbers.
    pub fn ancestors(&self) -> impl Iterator<Item = (usize, Entity)> {
        let runs = self.runs.iter().enumerate().skip(self.tables);
        runs.map(|(number, run)| (number, self.entities[run.start]))
    }
}

/// The tables of entities with components of drystone, and the components on the list that they have.
pub(super) fn own_tables<'w>(
    world: &'w World,
    known: &KnownKinds,
) -> impl Iterator<Item = (TableId, &'w Table, Kinds)> {
    let tables = world.storages().tables.iter().enumerate();
    let tables = tables.filter(|(_, table)| !table.entities().is_empty());
    tables.filter_map(|(id, table)| {
        let kinds = known.of_table(table);
        let is_own = kinds.meets(known.own);
        is_own.then_some((TableId::from_usize(id), table, kinds))
    })
}
