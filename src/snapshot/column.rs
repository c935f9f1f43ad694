//! The values of one component in a snapshot.
//!
//! Values lie in the order of the entities, without gaps, so that most of them are copied a table at a time.

use super::layout::Layout;
use super::renaming::Renaming;
use super::target::{NOWHERE, Rows, Target};
use crate::body::{new_rows, newer_than};
use crate::stored::Role;
use crate::stored::erased::{Cells, How, Kind, Slice, Values};
use bevy_ecs::change_detection::{MAX_CHANGE_AGE, Tick};
use bevy_ecs::component::{ComponentId, Components};
use bevy_ecs::entity::{Entity, EntityMapper};
use bevy_ecs::storage::TableId;
use bevy_ecs::world::World;
use std::ops::Range;

/// The run does not have the component.
const NONE: usize = usize::MAX;

/// A value that was written since the last step, whose change tick says so to the next one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Edit {
    pub row: usize,
    /// Whether the component was added.
    added: bool,
}

/// The values of a component.
#[derive(Clone, Debug)]
pub(super) struct Column {
    pub kind: Kind,
    pub values: Values,
    /// By run: the index of its first value.
    starts: Vec<usize>,
    pub edits: Vec<Edit>,
    /// The entities of the values of a component that is not kept in tables.
    pub holders: Vec<Entity>,
}

/// The entities of a snapshot, and those of the world by row.
#[derive(Clone, Copy, Debug)]
pub(super) struct On<'a> {
    pub layout: &'a Layout,
    pub entities: &'a [Entity],
}

impl Column {
    pub fn new(kind: Kind) -> Self {
        Self {
            kind,
            values: Values::new(kind),
            starts: Vec::new(),
            edits: Vec::new(),
            holders: Vec::new(),
        }
    }

    /// Whether it is a component of Bevy, which other entities have as well.
    pub fn is_shared(&self) -> bool {
        self.kind.role == Role::Bevy
    }

    /// The component, if the world knows it and keeps it in tables.
    pub fn id(&self, components: &Components) -> Option<ComponentId> {
        self.kind.id(components).filter(|_| !self.kind.is_sparse())
    }

    /// The indices of the values of a run.
    fn of_run(&self, layout: &Layout, run: usize) -> Option<Range<usize>> {
        let start = *self.starts.get(run)?;
        (start != NONE).then(|| start..start + layout.runs[run].len)
    }

    /// The place of the value of a row of a run.
    fn index_of(&self, layout: &Layout, run: usize, row: usize) -> Option<usize> {
        let start = *self.starts.get(run)?;
        (start != NONE).then(|| start + row - layout.runs[run].start)
    }

    /// The index of the value of a row.
    #[cfg(feature = "serde")]
    pub fn index_of_row(&self, layout: &Layout, row: usize) -> Option<usize> {
        self.index_of(layout, layout.run_of_row(row), row)
    }

    /// The value of a row of a run.
    pub fn value_of(&self, layout: &Layout, run: usize, row: usize) -> Option<Slice<'_>> {
        Some(self.values.one(self.index_of(layout, run, row)?))
    }

    /// Takes the values of a world. `since` is the tick of the last step, if there was one. `kind` is the number of the component on the
    /// list.
    pub fn take(&mut self, kind: usize, world: &World, layout: &Layout, since: Option<Tick>) {
        self.starts.clear();
        self.edits.clear();
        self.holders.clear();
        let known = self.kind.read(world);
        let Some(known) = known.filter(|_| self.kind.is_sparse() || layout.has(kind)) else {
            self.values.clear();
            return;
        };
        let mut len = 0;
        if self.kind.is_sparse() {
            self.holders = known.holders();
            for &holder in &self.holders {
                if let Some(cells) = known.entity(holder) {
                    self.values.overwrite(len, cells.values);
                    len += 1;
                }
            }
        } else {
            let ticks = (since, world.read_change_tick());
            self.starts.resize(layout.runs.len(), NONE);
            for (table, run) in layout.tables() {
                if layout.runs[run].kinds.contains(kind)
                    && let Some(cells) = known.table(table)
                {
                    self.starts[run] = len;
                    len = self.take_run(layout.runs[run].start, len, cells, ticks);
                }
            }
            if self.is_shared() {
                for (run, entity) in layout.ancestors() {
                    if let Some(cells) = known.entity(entity) {
                        self.starts[run] = len;
                        len = self.take_run(layout.runs[run].start, len, cells, ticks);
                    }
                }
            }
        }
        self.values.truncate(len);
    }

    /// Adds the values of a run after the first `len`, and notes those that were written since the last step. The memory of old values is
    /// used again. Returns the number of values.
    fn take_run(
        &mut self,
        first_row: usize,
        len: usize,
        cells: Cells,
        (since, now): (Option<Tick>, Tick),
    ) -> usize {
        let is_newer = newer_than(since.unwrap_or(now), now);
        let is_new = |tick: Tick| since.is_none() | is_newer(tick);
        for row in new_rows(cells.changed, is_new) {
            self.edits.push(Edit {
                row: first_row + row,
                added: is_new(cells.added[row]),
            });
        }
        self.values.overwrite(len, cells.values);
        len + cells.values.len()
    }

    /// Replaces values that cannot be written in place. Returns true if there were any.
    pub fn replace(&self, world: &mut World, on: On, to: &mut Renaming) -> bool {
        if self.kind.how != How::Replaced {
            return false;
        }
        let mut any = false;
        let mut value = Values::new(self.kind);
        for (number, run) in on.layout.runs.iter().enumerate() {
            let Some(range) = self.of_run(on.layout, number) else {
                continue;
            };
            for (index, row) in range.zip(run.rows()) {
                value.overwrite(0, self.values.one(index));
                to.apply(&mut value.as_mut());
                if replace_if_other(world, on.entities[row], &mut value) {
                    any = true;
                }
            }
        }
        any
    }

    /// Writes the values into a world whose entities have the components. `kind` is the number of the component on the list.
    pub fn write(&self, kind: usize, world: &mut World, target: &Target, to: &mut Renaming) {
        if self.kind.is_sparse() {
            self.write_sparse(world, to);
        } else if target.layout.has(kind) && self.kind.how != How::Replaced {
            // No entity of drystone's has a component that none had in the snapshot. Those that can only be replaced were.
            self.write_in_place(world, target, to);
        }
    }

    fn write_sparse(&self, world: &mut World, to: &mut Renaming) {
        let holders = self.kind.read(world).map(|known| known.holders());
        if let Some(holders) = holders {
            let id = self.kind.register(world);
            for holder in holders {
                if let Ok(mut holder) = world.get_entity_mut(holder) {
                    holder.remove_by_id(id);
                }
            }
        }
        for (index, &holder) in self.holders.iter().enumerate() {
            let mut value = Values::of(self.values.one(index));
            to.apply(&mut value.as_mut());
            if let Ok(mut entity) = world.get_entity_mut(to.get_mapped(holder)) {
                value.insert_into(&mut entity);
            }
        }
    }

    /// Writes the values. Those that differ are marked as changed, if they are compared. Ticks of others are set to one that is older than
    /// the last run of any system, as the kind says.
    fn write_in_place(&self, world: &mut World, target: &Target, to: &mut Renaming) {
        let layout = target.layout;
        let now = world.change_tick();
        let old = Tick::new(now.get().wrapping_sub(MAX_CHANGE_AGE));
        let how = self.kind.how;
        let mut places: Vec<Place> = Vec::new();
        let mut renamed = Values::new(self.kind);
        let Some(mut known) = self.kind.write(world) else {
            return;
        };
        for table in 0..known.tables() {
            let Some(mut cells) = known.table(TableId::from_usize(table)) else {
                continue;
            };
            if matches!(how, How::Output | How::Silent) {
                cells.added.fill(old);
            }
            if how == How::Silent {
                cells.changed.fill(old);
            }
            places.clear();
            match target.rows_of(cells.entities) {
                Some(&Rows::Run(run)) => {
                    if let Some(range) = self.of_run(layout, run) {
                        places.push(Place {
                            at: 0,
                            from: range.start,
                            len: range.len(),
                        });
                    }
                }
                Some(Rows::Each(rows)) => {
                    for (at, &row) in rows.iter().enumerate() {
                        if row != NOWHERE
                            && let Some(from) =
                                self.index_of(layout, target.run_of(row), row as usize)
                        {
                            push(&mut places, at, from);
                        }
                    }
                }
                None => (),
            }
            for place in &places {
                let from = self.values.part(place.from..place.from + place.len);
                to.write(&mut cells, place.at, from, &mut renamed, now);
            }
        }
        for (run, _) in layout.ancestors() {
            let row = layout.runs[run].start;
            if let Some(from) = self.index_of(layout, run, row)
                && let Some(mut cells) = known.entity(target.entities[row])
            {
                to.write(&mut cells, 0, self.values.one(from), &mut renamed, now);
            }
        }
        for edit in &self.edits {
            if let Some(mut cells) = known.entity(target.entities[edit.row]) {
                match edit.added {
                    true => cells.set_added(0, now),
                    false => cells.set_changed(0, now),
                }
            }
        }
    }

    /// The value of an entity, in its row, as `Debug` writes it.
    pub fn text(
        &self,
        layout: &Layout,
        row: usize,
        entity: Entity,
        to: &mut Renaming,
    ) -> Option<String> {
        let sparse = self.holders.iter().position(|&holder| holder == entity);
        let value = match sparse {
            Some(index) => self.values.one(index),
            None => self.value_of(layout, layout.run_of_row(row), row)?,
        };
        let mut value = Values::of(value);
        to.apply(&mut value.as_mut());
        Some(format!("{:#?}", value.as_slice().debug()))
    }

    /// Sets the values in the order of the runs that have them, each by its row. `next` appends one.
    #[cfg(feature = "serde")]
    pub fn fill<E>(
        &mut self,
        kind: usize,
        layout: &Layout,
        next: &mut dyn FnMut(usize, &mut Values) -> Result<(), E>,
    ) -> Result<(), E> {
        *self = Self::new(self.kind);
        if self.kind.is_sparse() {
            return Ok(());
        }
        for run in &layout.runs {
            let has = run.kinds.contains(kind);
            self.starts.push(if has { self.values.len() } else { NONE });
            if has {
                for row in run.rows() {
                    next(row, &mut self.values)?;
                }
            }
        }
        Ok(())
    }

    /// The rows of the values, in their order.
    #[cfg(feature = "serde")]
    pub fn rows(&self, layout: &Layout) -> Vec<usize> {
        let mut rows = Vec::with_capacity(self.values.len());
        for (number, run) in layout.runs.iter().enumerate() {
            if self.of_run(layout, number).is_some() {
                rows.extend(run.rows());
            }
        }
        rows
    }
}

/// Replaces the value of an entity, if that is another one or missing. Returns true if it was.
pub(crate) fn replace_if_other(world: &mut World, entity: Entity, value: &mut Values) -> bool {
    let kind = value.kind();
    let known = kind.read(world).and_then(|known| known.entity(entity));
    let is_same = known.is_some_and(|cells| {
        let difference = value.as_slice().first_difference(cells.values);
        difference.is_none()
    });
    match world.get_entity_mut(entity) {
        Ok(mut entity) if !is_same => value.insert_into(&mut entity),
        _ => return false,
    }
    true
}

/// Values of a table that follow each other, as those of a column do.
struct Place {
    /// The row in the table of the first one.
    at: usize,
    /// Its index in the column.
    from: usize,
    len: usize,
}

/// Adds a value.
fn push(places: &mut Vec<Place>, at: usize, from: usize) {
    match places.last_mut() {
        Some(last) if last.at + last.len == at && last.from + last.len == from => last.len += 1,
        _ => places.push(Place { at, from, len: 1 }),
    }
}
