//! The values of one component in a snapshot.
//!
//! Values lie in the order of the entities, without gaps, so that most of them are copied a table at a time.

#[cfg(feature = "serde")]
use super::bytes::Bytes;
use super::layout::{Layout, table_of};
#[cfg(not(feature = "serde"))]
use super::no_bytes::Bytes;
use super::renaming::Renaming;
use super::target::{NOWHERE, Rows, Target};
use crate::body::{new_rows, newer_than};
use crate::state;
use bevy_ecs::change_detection::{ContiguousMut, ContiguousRef, MAX_CHANGE_AGE, Tick};
use bevy_ecs::component::{ComponentId, Components, Mutable, StorageType};
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::prelude::*;
use std::any::Any;
use std::fmt::Debug;
use std::marker::PhantomData;
use std::ops::Range;

/// The run does not have the component.
const NONE: usize = usize::MAX;

/// A component that users may read: it is marked as changed if it differs.
#[derive(Clone, Copy, Debug)]
pub(super) struct Marked;

/// A component that stages write and users read: it is marked as changed if it differs, but stages do not take it for one that a user has
/// added.
#[derive(Clone, Copy, Debug)]
pub(super) struct Output;

/// A component that stages write without change detection: they take its ticks for edits by users.
#[derive(Clone, Copy, Debug)]
pub(super) struct Silent;

/// A component that can only be replaced.
#[derive(Clone, Copy, Debug)]
pub(super) struct Replaced;

/// A component without a value.
#[derive(Clone, Copy, Debug)]
pub(super) struct Valueless;

/// A value that was written since the last step, whose change tick says so to the next one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Edit {
    pub row: usize,
    /// Whether the component was added.
    added: bool,
}

/// The values of a component. The last type says how they are written.
#[derive(Clone, Debug)]
pub(super) struct Column<T, How> {
    values: Vec<T>,
    /// By run: the index of its first value.
    starts: Vec<usize>,
    pub edits: Vec<Edit>,
    /// Those of a component that is not kept in tables. Only markers are.
    pub sparse: Vec<(Entity, T)>,
    how: PhantomData<How>,
}

impl<T, How> Default for Column<T, How> {
    fn default() -> Self {
        Self {
            values: Vec::new(),
            starts: Vec::new(),
            edits: Vec::new(),
            sparse: Vec::new(),
            how: PhantomData,
        }
    }
}

/// The values of some component.
pub(super) trait AnyColumn: Any + Bytes + Debug + Send + Sync {
    fn name(&self) -> &'static str;

    /// Whether it is a component of Bevy, which other entities have as well.
    fn is_shared(&self) -> bool;

    /// The component, if the world knows it and keeps it in tables.
    fn id(&self, components: &Components) -> Option<ComponentId>;

    /// Takes the values of a world. `since` is the tick of the last step, if there was one.
    /// `kind` is the number of the component on the list.
    fn take(&mut self, kind: usize, world: &World, layout: &Layout, since: Option<Tick>);

    /// Inserts the component into entities that do not have it, by row.
    fn insert(&self, world: &mut World, rows: &[usize], on: On, to: &mut Renaming);

    /// Removes the component from an entity.
    fn remove(&self, entity: &mut EntityWorldMut);

    /// Replaces values that cannot be written in place. Returns true if there were any.
    fn replace(&self, world: &mut World, on: On, to: &mut Renaming) -> bool;

    /// Writes the values into a world whose entities have the components. `kind` is the number of the component on the list.
    fn write(&self, kind: usize, world: &mut World, target: &Target, to: &mut Renaming);

    /// The value of an entity, in its row, as `Debug` writes it.
    fn text(
        &self,
        layout: &Layout,
        row: usize,
        entity: Entity,
        to: &mut Renaming,
    ) -> Option<String>;

    fn boxed(&self) -> Box<dyn AnyColumn>;
}

/// The entities of a snapshot, and those of the world by row.
#[derive(Clone, Copy, Debug)]
pub(super) struct On<'a> {
    pub layout: &'a Layout,
    pub entities: &'a [Entity],
}

impl<T, How> Column<T, How> {
    /// The indices of the values of a run.
    fn of_run(&self, layout: &Layout, run: usize) -> Option<Range<usize>> {
        let start = *self.starts.get(run)?;
        (start != NONE).then(|| start..start + layout.runs[run].len)
    }

    /// The value of a row of a run.
    fn of_row(&self, layout: &Layout, run: usize, row: usize) -> Option<&T> {
        let index = self.index_of(layout, run, row)?;
        Some(&self.values[index])
    }

    /// The place of the value of a row of a run.
    fn index_of(&self, layout: &Layout, run: usize, row: usize) -> Option<usize> {
        let start = *self.starts.get(run)?;
        (start != NONE).then(|| start + row - layout.runs[run].start)
    }
}

#[cfg(feature = "serde")]
impl<T: Clone, How> Column<T, How> {
    /// The values in the order of the runs that have them, each with its row.
    pub fn in_order(&self, layout: &Layout) -> impl Iterator<Item = (usize, &T)> {
        let runs = layout.runs.iter().enumerate();
        let ranges = runs.filter_map(|(number, run)| {
            let range = self.of_run(layout, number)?;
            Some(run.rows().zip(&self.values[range]))
        });
        ranges.flatten()
    }

    /// The value of a row.
    pub fn value_of(&self, layout: &Layout, row: usize) -> Option<&T> {
        self.of_row(layout, layout.run_of_row(row), row)
    }

    /// The value of a row, to be changed.
    pub fn value_of_mut(&mut self, layout: &Layout, row: usize) -> Option<&mut T> {
        let index = self.index_of(layout, layout.run_of_row(row), row)?;
        Some(&mut self.values[index])
    }

    /// Sets the values in the order of the runs that have them, each by its row.
    pub fn fill<E>(
        &mut self,
        kind: usize,
        layout: &Layout,
        mut next: impl FnMut(usize) -> Result<T, E>,
    ) -> Result<(), E> {
        *self = Self::default();
        for run in &layout.runs {
            let has = run.kinds.contains(kind);
            self.starts.push(if has { self.values.len() } else { NONE });
            if has {
                for row in run.rows() {
                    self.values.push(next(row)?);
                }
            }
        }
        Ok(())
    }
}

impl<T: Component + Clone, How> Column<T, How> {
    const SPARSE: bool = matches!(T::STORAGE_TYPE, StorageType::SparseSet);

    fn take_sparse(&mut self, world: &World) {
        self.sparse.clear();
        if let Some(mut query) = world.try_query::<(Entity, &T, Has<Disabled>)>() {
            let values = query.iter(world);
            let values = values.map(|(entity, value, _)| (entity, value.clone()));
            self.sparse.extend(values);
        }
    }

    /// Adds the values of a run after the first `len`. The memory of old values is used again.
    fn overwrite(&mut self, len: usize, with: &[T]) {
        let old = self.values.len().saturating_sub(len).min(with.len());
        self.values[len..len + old].clone_from_slice(&with[..old]);
        self.values.extend_from_slice(&with[old..]);
    }

    /// Notes which values of a run were written since the last step.
    fn note_edits(
        &mut self,
        [added, changed]: [&[Tick]; 2],
        first: usize,
        is_new: impl Fn(Tick) -> bool,
    ) {
        let new = new_rows(changed, &is_new);
        self.edits.extend(new.map(|row| Edit {
            row: first + row,
            added: is_new(added[row]),
        }));
    }
}

impl<T: Component + Clone + Debug, How: Debug + Send + Sync + 'static> AnyColumn for Column<T, How>
where
    Self: Write + Bytes,
{
    fn name(&self) -> &'static str {
        std::any::type_name::<T>()
    }

    fn is_shared(&self) -> bool {
        state::is_of_bevy::<T>()
    }

    fn id(&self, components: &Components) -> Option<ComponentId> {
        components.component_id::<T>().filter(|_| !Self::SPARSE)
    }

    fn take(&mut self, kind: usize, world: &World, layout: &Layout, since: Option<Tick>) {
        if Self::SPARSE {
            return self.take_sparse(world);
        }
        self.starts.clear();
        self.edits.clear();
        let now = world.read_change_tick();
        let is_newer = newer_than(since.unwrap_or(now), now);
        let is_new = |tick: Tick| since.is_none() | is_newer(tick);
        let mut len = 0;
        // A query costs a microsecond to make, and most scenes lack most of the components.
        let is_there = layout.has(kind);
        let query = is_there.then(|| world.try_query::<(Entity, Ref<T>, Has<Disabled>)>());
        if let Some(mut query) = query.flatten() {
            self.starts.resize(layout.runs.len(), NONE);
            let tables = query.contiguous_iter(world);
            for (entities, column, _) in tables.expect("it is kept in tables") {
                let table = entities.first().and_then(|&first| table_of(world, first));
                let Some(run) = table.and_then(|table| layout.run_of(table)) else {
                    continue;
                };
                self.starts[run] = len;
                let ticks = [column.added_ticks_slice(), column.changed_ticks_slice()];
                self.note_edits(ticks, layout.runs[run].start, is_new);
                let (values, _) = ContiguousRef::split(column);
                self.overwrite(len, values);
                len += values.len();
            }
            if self.is_shared() {
                for (run, entity) in layout.ancestors() {
                    if let Ok((_, value, _)) = query.get(world, entity) {
                        self.starts[run] = len;
                        let ticks = [[value.added()], [value.last_changed()]];
                        let ticks = [&ticks[0][..], &ticks[1][..]];
                        self.note_edits(ticks, layout.runs[run].start, is_new);
                        self.overwrite(len, std::slice::from_ref(&*value));
                        len += 1;
                    }
                }
            }
        }
        self.values.truncate(len);
    }

    fn insert(&self, world: &mut World, rows: &[usize], on: On, to: &mut Renaming) {
        let values = rows.iter().filter_map(|&row| {
            let value = self.of_row(on.layout, on.layout.run_of_row(row), row)?;
            Some((on.entities[row], value))
        });
        to.insert_missing(world, values);
    }

    fn remove(&self, entity: &mut EntityWorldMut) {
        entity.remove::<T>();
    }

    fn replace(&self, world: &mut World, on: On, to: &mut Renaming) -> bool {
        Write::replace(self, world, on, to)
    }

    fn write(&self, kind: usize, world: &mut World, target: &Target, to: &mut Renaming) {
        if !Self::SPARSE {
            // No entity of drystone's has a component that none had in the snapshot.
            if target.layout.has(kind) {
                Write::write(self, world, target, to);
            }
            return;
        }
        let mut holders = world.query::<(Entity, &T, Has<Disabled>)>();
        let holders: Vec<Entity> = holders.iter(world).map(|(entity, ..)| entity).collect();
        for entity in holders {
            world.entity_mut(entity).remove::<T>();
        }
        for (entity, value) in &self.sparse {
            let mut value = value.clone();
            to.apply(&mut value);
            if let Ok(mut entity) = world.get_entity_mut(to.get_mapped(*entity)) {
                entity.insert(value);
            }
        }
    }

    fn text(
        &self,
        layout: &Layout,
        row: usize,
        entity: Entity,
        to: &mut Renaming,
    ) -> Option<String> {
        let sparse = self.sparse.iter().find(|(holder, _)| *holder == entity);
        let value = match sparse {
            Some((_, value)) => Some(value),
            None => self.of_row(layout, layout.run_of_row(row), row),
        };
        let mut value = value?.clone();
        to.apply(&mut value);
        Some(format!("{value:#?}"))
    }

    fn boxed(&self) -> Box<dyn AnyColumn> {
        Box::new(Self {
            values: self.values.clone(),
            starts: self.starts.clone(),
            edits: self.edits.clone(),
            sparse: self.sparse.clone(),
            how: PhantomData,
        })
    }
}

/// How values are written where entities have the component already.
pub(super) trait Write {
    fn replace(&self, _world: &mut World, _on: On, _to: &mut Renaming) -> bool {
        false
    }

    fn write(&self, world: &mut World, target: &Target, to: &mut Renaming);
}

impl<T: Component<Mutability = Mutable> + Clone + PartialEq> Write for Column<T, Marked> {
    fn write(&self, world: &mut World, target: &Target, to: &mut Renaming) {
        let keep = |_: &mut ContiguousMut<T>, _| ();
        self.write_in_place::<true>(world, target, to, |before, after| before != after, keep);
    }
}

impl<T: Component<Mutability = Mutable> + Clone + PartialEq> Write for Column<T, Output> {
    fn write(&self, world: &mut World, target: &Target, to: &mut Renaming) {
        let age = |column: &mut ContiguousMut<T>, old| column.added_ticks_slice_mut().fill(old);
        self.write_in_place::<true>(world, target, to, |before, after| before != after, age);
    }
}

impl<T: Component<Mutability = Mutable> + Clone> Write for Column<T, Silent> {
    fn write(&self, world: &mut World, target: &Target, to: &mut Renaming) {
        let age = |column: &mut ContiguousMut<T>, old| {
            column.added_ticks_slice_mut().fill(old);
            column.changed_ticks_slice_mut().fill(old);
        };
        self.write_in_place::<false>(world, target, to, |_, _| false, age);
    }
}

impl<T: Component<Mutability = Mutable> + Clone> Write for Column<T, Valueless> {
    fn write(&self, world: &mut World, target: &Target, to: &mut Renaming) {
        let keep = |_: &mut ContiguousMut<T>, _| ();
        self.write_in_place::<false>(world, target, to, |_, _| false, keep);
    }
}

impl<T: Component + Clone + PartialEq> Write for Column<T, Replaced> {
    fn replace(&self, world: &mut World, on: On, to: &mut Renaming) -> bool {
        let mut any = false;
        for (number, run) in on.layout.runs.iter().enumerate() {
            let Some(range) = self.of_run(on.layout, number) else {
                continue;
            };
            for (value, row) in self.values[range].iter().zip(run.rows()) {
                let mut value = value.clone();
                to.apply(&mut value);
                if let Ok(mut entity) = world.get_entity_mut(on.entities[row])
                    && entity.get::<T>() != Some(&value)
                {
                    entity.insert(value);
                    any = true;
                }
            }
        }
        any
    }

    // `replace` has done it.
    fn write(&self, _: &mut World, _: &Target, _: &mut Renaming) {}
}

impl<T: Component<Mutability = Mutable> + Clone, How> Column<T, How> {
    /// Writes the values. Those that `differ` are marked as changed, if they are to be `COMPARED`. `age` may set the ticks of a table to one that is
    /// older than the last run of any system.
    fn write_in_place<const COMPARED: bool>(
        &self,
        world: &mut World,
        target: &Target,
        to: &mut Renaming,
        differ: impl Fn(&T, &T) -> bool,
        age: impl Fn(&mut ContiguousMut<T>, Tick),
    ) {
        let layout = target.layout;
        let old = Tick::new(world.change_tick().get().wrapping_sub(MAX_CHANGE_AGE));
        let is_nothing = to.is_nothing();
        let mut set = |value: &mut T, from: &T| {
            if is_nothing {
                let differs = COMPARED && differ(value, from);
                value.clone_from(from);
                return differs;
            }
            if !COMPARED {
                // In the memory that it has.
                value.clone_from(from);
                to.apply(value);
                return false;
            }
            let mut from = from.clone();
            to.apply(&mut from);
            let differs = differ(value, &from);
            *value = from;
            differs
        };
        let is_plain = is_nothing && !COMPARED;
        let mut query = world.query::<(Entity, &mut T, Has<Disabled>)>();
        // One of each table in which some are marked: it has Bevy mark the whole column (its summary tick).
        let mut marked: Vec<Entity> = Vec::new();
        let mut changed: Vec<usize> = Vec::new();
        let tables = query.contiguous_iter_mut(world);
        for (entities, mut column, _) in tables.expect("it is kept in tables") {
            age(&mut column, old);
            let values = column.bypass_change_detection();
            changed.clear();
            match target.rows_of(entities) {
                Some(&Rows::Run(run)) => {
                    let Some(range) = self.of_run(layout, run) else {
                        continue;
                    };
                    let from = &self.values[range];
                    if is_plain {
                        values.clone_from_slice(from);
                        continue;
                    }
                    for (at, (value, from)) in values.iter_mut().zip(from).enumerate() {
                        if set(value, from) {
                            changed.push(at);
                        }
                    }
                }
                Some(Rows::Each(rows)) => {
                    for (at, (value, &row)) in values.iter_mut().zip(rows).enumerate() {
                        if row != NOWHERE
                            && let run = target.run_of(row)
                            && let Some(from) = self.of_row(layout, run, row as usize)
                            && set(value, from)
                        {
                            changed.push(at);
                        }
                    }
                }
                None => (),
            }
            if let Some(&first) = changed.first() {
                marked.push(entities[first]);
                let now = column.this_run_tick();
                let ticks = column.changed_ticks_slice_mut();
                for &at in &changed {
                    ticks[at] = now;
                }
            }
        }
        for (run, _) in layout.ancestors() {
            let row = layout.runs[run].start;
            let entity = target.entities[row];
            if let Some(from) = self.of_row(layout, run, row)
                && let Ok((_, mut value, _)) = query.get_mut(world, entity)
                && set(value.bypass_change_detection(), from)
            {
                marked.push(entity);
            }
        }
        for entity in marked {
            if let Ok((_, mut value, _)) = query.get_mut(world, entity) {
                value.set_changed();
            }
        }
        for edit in &self.edits {
            if let Ok((_, mut value, _)) = query.get_mut(world, target.entities[edit.row]) {
                match edit.added {
                    true => value.set_added(),
                    false => value.set_changed(),
                }
            }
        }
    }
}
