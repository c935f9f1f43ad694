//! What rests: bodies that stand still or sleep, and pairs of two such. The stages of a step go through all but those
//! (`Without<Resting>`), so what rests costs nothing but a look at whether somebody wrote to it.
//!
//! What a user writes to a resting body is found by change ticks: by those of whole columns, and row by row only in columns that have
//! changed (Bevy's summary ticks). That one was despawned is told by a hook; that one has left by whatever other way, disabled for
//! instance, is found by a census: as many must be there as have been marked.

use super::placement::{Placed, user_pose};
use super::{BodyIndex, BodyProperty, BodyTable, Pose, Quarantined, Written};
use bevy_ecs::change_detection::{ContiguousRef, Tick};
use bevy_ecs::hierarchy::ChildOf;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;

/// See the module's text. A pair rests only where both of its bodies do.
#[derive(Component, Clone, Copy, Debug)]
#[component(clone_behavior = Ignore)]
pub struct Resting(());

impl Resting {
    pub(crate) fn new() -> Self {
        Self(())
    }
}

/// A body that rests.
pub(super) type Rests = (With<Resting>, Without<Quarantined>);

/// Those that rest, and what may have become of them.
pub(super) type RestingBodies<'w, 's> = Query<'w, 's, Written, Rests>;

/// Those whose `Transform` means something in the frame of another.
pub(super) type RestingChildren<'w, 's> =
    Query<'w, 's, (Entity, &'static Pose, &'static Transform, &'static ChildOf), Rests>;

/// Those that somebody has written to since the system at hand ran last, and after `since` where that is later, and not only what the
/// table knows of them; once for each component.
pub(super) fn find_written(
    table: &BodyTable,
    bodies: RestingBodies,
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
        // Of a child's frame `find_carried` knows.
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

/// The bodies of a table of Bevy's.
#[derive(Clone, Copy)]
pub(super) struct Rows<'a> {
    table: &'a BodyTable,
    entities: &'a [Entity],
    slots: &'a [BodyIndex],
    since: Option<Tick>,
}

impl Rows<'_> {
    /// Finds the bodies whose row of a column was written with a value that the table does not know.
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

/// Calls `written` with each row of a column that has been written, and what is there now.
fn look<T>(column: ContiguousRef<T>, since: Option<Tick>, mut written: impl FnMut(usize, &T)) {
    /// Compared at once, by vector instructions where nothing was written.
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

/// Whose `Transform` has been written and is not where the body is. What interpolates writes all of them in every frame, and puts those that lie
/// where they lie.
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

/// Those that a parent has moved, or that have another.
pub(super) fn find_carried(children: RestingChildren, placed: Placed) -> Vec<Entity> {
    let moved = children.iter().filter(|(_, pose, transform, parent)| {
        user_pose((transform, Some(parent)), **pose, false, placed).is_some()
    });
    moved.map(|(entity, ..)| entity).collect()
}
