//! The search for rows that were written in the columns of a table of the ECS.

use super::{BodyIndex, BodyState, BodyTable};
use bevy_ecs::change_detection::{ContiguousRef, MAX_CHANGE_AGE, Tick};
use bevy_ecs::entity::Entity;

/// The bodies of one table of the ECS.
#[derive(Clone, Copy)]
pub(super) struct Rows<'a> {
    pub table: &'a BodyTable,
    pub entities: &'a [Entity],
    pub slots: &'a [BodyIndex],
    pub since: Option<Tick>,
    /// Bodies that are not in the table are passed over.
    pub only_known: bool,
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
            only_known,
        } = self;
        look(column, since, |row, value| {
            if only_known && slots[row] == BodyIndex::NONE {
                return;
            }
            let body = table.get(slots[row].0);
            let body = body.filter(|body| body.entity == entities[row]);
            if !body.is_some_and(|body| known(body, value)) {
                found.push(entities[row]);
            }
        });
    }
}

/// Returns a test of whether a tick is newer than the last run of a system. It agrees with [`Tick::is_newer_than`] and does half of the work for each tick. In a
/// world at rest these comparisons are most of a step, because the tick of every `Transform` is read.
#[inline]
pub(crate) fn newer_than(last: Tick, this: Tick) -> impl Fn(Tick) -> bool + Copy {
    let this = this.get();
    // Bevy clamps both ages to this maximum. After one is clamped, the other compares the same either way.
    let since = this.wrapping_sub(last.get()).min(MAX_CHANGE_AGE);
    move |tick| this.wrapping_sub(tick.get()) < since
}

/// The rows of a column whose tick is new. Ticks are compared in chunks without a branch, so that the compiler vectorizes the common case in which
/// nothing was written.
#[inline]
pub(crate) fn new_rows(
    ticks: &[Tick],
    is_new: impl Fn(Tick) -> bool + Copy,
) -> impl Iterator<Item = usize> {
    const CHUNK: usize = 64;
    let chunks = ticks.chunks(CHUNK).enumerate();
    let chunks =
        chunks.filter(move |(_, ticks)| ticks.iter().fold(false, |any, &tick| any | is_new(tick)));
    chunks.flat_map(move |(chunk, ticks)| {
        let rows = ticks.iter().zip(CHUNK * chunk..);
        let rows = rows.filter(move |(tick, _)| is_new(**tick));
        rows.map(|(_, row)| row)
    })
}

/// The rows of a column that were written since the system ran last. It reads the tick of every row, since Bevy's summary tick of the column misses some
/// writes of observers.
pub(crate) fn written_rows<T>(column: &ContiguousRef<T>) -> impl Iterator<Item = usize> {
    let (last, this) = (column.last_run_tick(), column.this_run_tick());
    new_rows(column.changed_ticks_slice(), newer_than(last, this))
}

/// Calls `written` with the index and the value of each row of a column that has been written.
pub(crate) fn look<T>(
    column: ContiguousRef<T>,
    since: Option<Tick>,
    mut written: impl FnMut(usize, &T),
) {
    let (last, this) = (column.last_run_tick(), column.this_run_tick());
    let last = since
        .filter(|since| since.is_newer_than(last, this))
        .unwrap_or(last);
    let rows = column.changed_ticks_slice();
    let (values, ticks) = ContiguousRef::split(column);
    if ticks.summary_tick_is_changed() != Some(false) {
        new_rows(rows, newer_than(last, this)).for_each(|row| written(row, &values[row]));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tick_is_newer_where_bevy_says_so() {
        let steps = [
            0,
            1,
            2,
            1_000,
            MAX_CHANGE_AGE - 1,
            MAX_CHANGE_AGE,
            MAX_CHANGE_AGE + 1,
        ];
        let steps = steps.into_iter().flat_map(|step| [step, u32::MAX - step]);
        let ticks: Vec<Tick> = steps.map(Tick::new).collect();
        let mut newer = 0;
        for &this in &ticks {
            for &last in &ticks {
                let is_new = newer_than(last, this);
                for &tick in &ticks {
                    assert_eq!(is_new(tick), tick.is_newer_than(last, this));
                    newer += usize::from(is_new(tick));
                }
            }
        }
        assert!(newer > 100, "{newer}");
    }

    #[test]
    fn new_rows_are_found_in_every_chunk() {
        let new = [3, 63, 64, 190, 199];
        let ticks: Vec<Tick> = (0..200)
            .map(|row| Tick::new(u32::from(new.contains(&row))))
            .collect();
        let found: Vec<usize> = new_rows(&ticks, newer_than(Tick::new(0), Tick::new(2))).collect();
        assert_eq!(found, new);
    }
}
