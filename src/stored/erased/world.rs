//! The values of a kind in a world.

use super::{Kind, Slice, SliceMut};
use crate::components::holders_of;
use bevy_ecs::change_detection::{AtomicTick, Tick};
use bevy_ecs::component::ComponentId;
use bevy_ecs::entity::Entity;
use bevy_ecs::storage::TableId;
use bevy_ecs::world::World;
use bevy_ecs::world::unsafe_world_cell::UnsafeWorldCell;
use std::cell::UnsafeCell;
use std::marker::PhantomData;
use std::ptr::NonNull;
use std::slice;

/// A kind in a world that is read.
#[derive(Clone, Copy)]
pub(crate) struct In<'w> {
    kind: Kind,
    id: ComponentId,
    world: &'w World,
}

/// A kind in a world that is written.
pub(crate) struct InMut<'w> {
    kind: Kind,
    id: ComponentId,
    /// It gives access to the whole world for `'w`, of which nobody else has any.
    world: UnsafeWorldCell<'w>,
    lifetime: PhantomData<&'w mut World>,
}

/// Values of a world, and their ticks.
#[derive(Clone, Copy)]
pub(crate) struct Cells<'a> {
    /// The entities that have them.
    #[cfg_attr(
        not(any(feature = "serde", test)),
        expect(dead_code, reason = "recordings read it")
    )]
    pub entities: &'a [Entity],
    pub values: Slice<'a>,
    pub added: &'a [Tick],
    pub changed: &'a [Tick],
}

/// Values of a world, and their ticks, to be written.
pub(crate) struct CellsMut<'a> {
    /// The entities that have them.
    pub entities: &'a [Entity],
    pub values: SliceMut<'a>,
    pub added: &'a mut [Tick],
    pub changed: &'a mut [Tick],
    /// That of the table, if there is one.
    summary: Option<&'a AtomicTick>,
}

impl CellsMut<'_> {
    /// Marks the values after the first `at` as changed that differ from others.
    ///
    /// # Panics
    /// If the others have another type, or are more.
    pub fn mark_differences(&mut self, at: usize, others: Slice, now: Tick) {
        let mut next = at;
        let end = at + others.len();
        while next < end {
            let values = self.values.as_slice().part(next..end);
            let Some(first) = values.first_difference(others.part(next - at..end - at)) else {
                return;
            };
            self.set_changed(next + first, now);
            next += first + 1;
        }
    }

    /// Marks a value as changed, and so Bevy's summary of the column.
    pub fn set_changed(&mut self, at: usize, now: Tick) {
        self.changed[at] = now;
        if let Some(summary) = self.summary {
            summary.set(now);
        }
    }

    /// Marks a value as added.
    pub fn set_added(&mut self, at: usize, now: Tick) {
        self.added[at] = now;
        self.set_changed(at, now);
    }
}

impl Kind {
    /// The values of a world, if it knows the component.
    pub fn read(self, world: &World) -> Option<In<'_>> {
        Some(In {
            kind: self,
            id: self.id(world.components())?,
            world,
        })
    }

    /// The values of a world, to be written, if it knows the component.
    pub fn write(self, world: &mut World) -> Option<InMut<'_>> {
        Some(InMut {
            kind: self,
            id: self.id(world.components())?,
            world: world.as_unsafe_world_cell(),
            lifetime: PhantomData,
        })
    }
}

impl<'w> In<'w> {
    /// The values of the entities of a table, in their order, if they have any.
    pub fn table(self, table: TableId) -> Option<Cells<'w>> {
        self.cells(Place::Table(table))
    }

    /// The value of an entity, if it has one.
    pub fn entity(self, entity: Entity) -> Option<Cells<'w>> {
        self.cells(Place::Entity(entity))
    }

    /// The value of the resource, if the world has it.
    pub fn resource(self) -> Option<Cells<'w>> {
        self.entity(self.world.resource_entities().get(self.id)?)
    }

    fn cells(self, place: Place) -> Option<Cells<'w>> {
        let cell = self.world.as_unsafe_world_cell_readonly();
        // SAFETY: *World*. The world is borrowed for `'w`.
        let found = unsafe { Found::find(cell, self.kind, self.id, place) }?;
        // SAFETY: *Borrow*.
        unsafe {
            Some(Cells {
                entities: found.entities,
                values: Slice::new(self.kind, found.first, found.changed.len()),
                added: slice::from_raw_parts(found.added.as_ptr().cast(), found.added.len()),
                changed: slice::from_raw_parts(found.changed.as_ptr().cast(), found.changed.len()),
            })
        }
    }

    /// The entities with the component.
    pub fn holders(self) -> Vec<Entity> {
        holders_of(self.world.archetypes(), &[self.id])
    }

    /// The values of all entities, some at a time.
    #[cfg(feature = "serde")]
    pub fn all(self) -> Vec<Cells<'w>> {
        if self.kind.is_sparse() {
            let holders = self.holders().into_iter();
            return holders.filter_map(|holder| self.entity(holder)).collect();
        }
        let tables = (0..self.world.storages().tables.len()).map(TableId::from_usize);
        tables.filter_map(|table| self.table(table)).collect()
    }
}

impl InMut<'_> {
    /// Number of tables of the world.
    pub fn tables(&self) -> usize {
        // SAFETY: Nobody else has access to the world.
        unsafe { self.world.storages() }.tables.len()
    }

    /// The values of the entities of a table, in their order, if they have any.
    pub fn table(&mut self, table: TableId) -> Option<CellsMut<'_>> {
        self.cells(Place::Table(table))
    }

    /// The value of an entity, if it has one.
    pub fn entity(&mut self, entity: Entity) -> Option<CellsMut<'_>> {
        self.cells(Place::Entity(entity))
    }

    /// The value of the resource, if the world has it.
    pub fn resource(&mut self) -> Option<CellsMut<'_>> {
        // SAFETY: Nobody else has access to the world.
        let entity = unsafe { self.world.resource_entities() }.get(self.id)?;
        self.entity(entity)
    }

    fn cells(&mut self, place: Place) -> Option<CellsMut<'_>> {
        // SAFETY: *World*. The cell has access to the whole world for longer.
        let found = unsafe { Found::find(self.world, self.kind, self.id, place) }?;
        // SAFETY: *Borrow*. `self` is borrowed mutably for as long, so there are no other cells. Ticks are in `UnsafeCell`s.
        unsafe {
            Some(CellsMut {
                entities: found.entities,
                values: SliceMut::new(self.kind, found.first, found.changed.len()),
                added: ticks(found.added),
                changed: ticks(found.changed),
                summary: found.summary,
            })
        }
    }
}

/// # Safety
/// Nobody else reads or writes them.
#[expect(clippy::mut_from_ref, reason = "they are in cells")]
unsafe fn ticks(cells: &[UnsafeCell<Tick>]) -> &mut [Tick] {
    let first = UnsafeCell::raw_get(cells.as_ptr());
    // SAFETY: By the caller. A cell has the form of its contents.
    unsafe { slice::from_raw_parts_mut(first, cells.len()) }
}

#[derive(Clone, Copy)]
enum Place {
    Table(TableId),
    Entity(Entity),
}

/// Where values and their ticks lie.
struct Found<'w> {
    entities: &'w [Entity],
    /// That of as many values as there are ticks.
    first: NonNull<u8>,
    added: &'w [UnsafeCell<Tick>],
    changed: &'w [UnsafeCell<Tick>],
    summary: Option<&'w AtomicTick>,
}

impl<'w> Found<'w> {
    /// # Safety
    /// `id` is that of the kind in the world. The cell gives read access to the whole world, and whoever reads or writes what is found has
    /// the same access.
    unsafe fn find(
        world: UnsafeWorldCell<'w>,
        kind: Kind,
        id: ComponentId,
        place: Place,
    ) -> Option<Self> {
        // SAFETY: By the caller.
        let storages = unsafe { world.storages() };
        let (entity, is_all) = match place {
            Place::Entity(entity) => (entity, false),
            // The first of the table.
            Place::Table(table) => {
                let entities = storages.tables.get(table)?.entities();
                (*entities.first()?, true)
            }
        };
        let at = world.entities().get_spawned(entity).ok()?;
        let table = storages.tables.get(at.table_id)?;
        let row = at.table_row.index();
        let rows = match is_all {
            // The first entity of a table has row 0.
            true => row..table.entities().len(),
            false => row..row + 1,
        };
        let entities = table.entities().get(rows.clone())?;
        if kind.is_sparse() {
            if is_all {
                return None;
            }
            let (value, ticks) = storages.sparse_sets.get(id)?.get_with_ticks(entity)?;
            return Some(Self {
                entities,
                first: NonNull::new(value.as_ptr().cast_mut())?,
                added: slice::from_ref(ticks.added),
                changed: slice::from_ref(ticks.changed),
                summary: ticks.summary_tick,
            });
        }
        // SAFETY: The entity is in this row.
        let value = unsafe { table.get_component(id, at.table_row) }?;
        Some(Self {
            entities,
            first: NonNull::new(value.as_ptr().cast_mut())?,
            added: table.get_added_ticks_slice_for(id)?.get(rows.clone())?,
            changed: table.get_changed_ticks_slice_for(id)?.get(rows)?,
            summary: table.get_summary_tick(id),
        })
    }
}
