//! Inactive bodies: sleeping bodies, and static and kinematic bodies that stand still. A pair of two inactive bodies is inactive too. The
//! queries of the stages skip them (`Without<Inactive>`), so their only cost is the search for components that the user wrote.
//!
//! Change ticks tell what a user wrote to an inactive body: first those of whole columns (Bevy's summary ticks), then, in columns that have
//! changed, those of rows. A hook reports inactive bodies that were despawned. Bodies that left in another way, such as disabled ones, are
//! found by comparing the number of inactive bodies with the number that has been marked.

use super::placement::{Placed, user_pose};
use super::{BodyIndex, BodyProperty, BodyTable, Pose, Quarantined, Written};
use bevy_ecs::change_detection::{ContiguousRef, Tick};
use bevy_ecs::hierarchy::ChildOf;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;

/// Marks a body or a pair that the stages skip because nothing about it changes. A pair is inactive only if both of its bodies are.
#[derive(Component, Clone, Copy, Debug)]
#[component(clone_behavior = Ignore)]
pub struct Inactive(());

impl Inactive {
    pub(crate) fn new() -> Self {
        Self(())
    }
}

/// Filter for inactive bodies.
pub(super) type IsInactive = (With<Inactive>, Without<Quarantined>);

/// The inactive bodies, with the components that users may write.
pub(super) type InactiveBodies<'w, 's> = Query<'w, 's, Written, IsInactive>;

/// The inactive bodies whose `Transform` is in the frame of a parent.
pub(super) type InactiveChildren<'w, 's> =
    Query<'w, 's, (Entity, &'static Pose, &'static Transform, &'static ChildOf), IsInactive>;

/// Finds inactive bodies that were written since the system ran last, and after `since` if that is later; once for each component. Values that
/// equal the table do not count.
pub(super) fn find_written(
    table: &BodyTable,
    bodies: InactiveBodies,
    since: Option<Tick>,
) -> Vec<Entity> {
    let mut found = Vec::new();
    let columns = bodies.contiguous_iter();
    for columns in columns.expect("all of it is stored in tables") {
        let rows = Rows {
            table,
            entities: columns.entity,
            slots: columns.slot,
            since,
        };
        // `find_carried` handles bodies in the frame of a parent.
        if columns.parent.is_none() {
            look_moved(
                columns.entity,
                columns.at,
                columns.transform.clone(),
                &mut found,
            );
        }
        columns.find(rows, &mut found);
    }
    found
}

/// The bodies of one table of the ECS.
#[derive(Clone, Copy)]
pub(super) struct Rows<'a> {
    table: &'a BodyTable,
    entities: &'a [Entity],
    slots: &'a [BodyIndex],
    since: Option<Tick>,
}

impl Rows<'_> {
    /// Finds the bodies whose row of a column was written with a value that differs from the table.
    pub(super) fn compare<T: BodyProperty>(
        self,
        column: ContiguousRef<T>,
        found: &mut Vec<Entity>,
    ) {
        let Self {
            table,
            entities,
            slots,
            since,
        } = self;
        look(column, since, |row, value| {
            let body = table.get(slots[row].0);
            let known = body.filter(|body| body.entity == entities[row]);
            if !known.is_some_and(|body| value.is_known(body)) {
                found.push(entities[row]);
            }
        });
    }
}

/// Calls `written` with the index and the value of each row of a column that has been written.
fn look<T>(column: ContiguousRef<T>, since: Option<Tick>, mut written: impl FnMut(usize, &T)) {
    /// Ticks are compared in chunks without a branch, so that the compiler vectorizes the common case in which nothing was written.
    const CHUNK: usize = 64;
    let (last, this) = (column.last_run_tick(), column.this_run_tick());
    let last = since
        .filter(|since| since.is_newer_than(last, this))
        .unwrap_or(last);
    let rows = column.changed_ticks_slice();
    let (values, ticks) = ContiguousRef::split(column);
    if ticks.summary_tick_is_changed() == Some(false) {
        return;
    }
    let is_new = |tick: &Tick| tick.is_newer_than(last, this);
    for (chunk, rows) in rows.chunks(CHUNK).enumerate() {
        if rows.iter().fold(false, |any, row| any | is_new(row)) {
            let new = rows
                .iter()
                .zip(CHUNK * chunk..)
                .filter(|(row, _)| is_new(row));
            new.for_each(|(_, row)| written(row, &values[row]));
        }
    }
}

/// Finds bodies whose `Transform` was written and differs from their pose. Interpolation writes the transforms of all bodies in every frame,
/// but those of inactive bodies keep their value.
fn look_moved(
    entities: &[Entity],
    poses: &[Pose],
    column: ContiguousRef<Transform>,
    found: &mut Vec<Entity>,
) {
    let (drawn, ticks) = ContiguousRef::split(column);
    if ticks.summary_tick_is_changed() == Some(false) {
        return;
    }
    let rows = entities.iter().zip(poses);
    let rows = rows.zip(drawn.iter().zip(ticks.is_changed_iter()));
    let moved = rows.filter(|((_, pose), (drawn, is_written))| {
        *is_written && (pose.position, pose.rotation) != (drawn.translation, drawn.rotation)
    });
    found.extend(moved.map(|((&entity, _), _)| entity));
}

/// Finds inactive bodies whose parent was moved or replaced.
pub(super) fn find_carried(children: InactiveChildren, placed: Placed) -> Vec<Entity> {
    let moved = children.iter().filter(|(_, pose, transform, parent)| {
        user_pose((transform, Some(parent)), **pose, false, placed).is_some()
    });
    moved.map(|(entity, ..)| entity).collect()
}
