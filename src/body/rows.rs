//! The search for rows that were written in the columns of a table of the ECS.

use super::{BodyIndex, BodyState, BodyTable};
use bevy_ecs::change_detection::{ContiguousRef, Tick};
use bevy_ecs::entity::Entity;

/// The bodies of one table of the ECS.
#[derive(Clone, Copy)]
pub(super) struct Rows<'a> {
    pub table: &'a BodyTable,
    pub entities: &'a [Entity],
    pub slots: &'a [BodyIndex],
    pub since: Option<Tick>,
}

impl Rows<'_> {
    /// Finds the bodies whose row of a column was written with a value that differs from the table.
    pub(super) fn compare<T>(
        self,
        column: ContiguousRef<T>,
        known: impl Fn(&BodyState, &T) -> bool,
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
            let body = body.filter(|body| body.entity == entities[row]);
            if !body.is_some_and(|body| known(body, value)) {
                found.push(entities[row]);
            }
        });
    }
}

/// Calls `written` with the index and the value of each row of a column that has been written.
pub(crate) fn look<T>(
    column: ContiguousRef<T>,
    since: Option<Tick>,
    mut written: impl FnMut(usize, &T),
) {
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
