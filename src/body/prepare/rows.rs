//! The search for rows that were written in the columns of a table of the ECS.

use crate::body::{BodyIndex, BodyState, BodyTable};
use bevy_ecs::change_detection::{ContiguousRef, MAX_CHANGE_AGE, Tick};
use bevy_ecs::entity::Entity;

/// The bodies of one table of the ECS.
#[derive(Clone, Copy)]
pub(in crate::body) struct Rows<'a> {
    pub table: &'a BodyTable,
    pub entities: &'a [Entity],
    pub slots: &'a [BodyIndex],
    pub since: Option<Tick>,
    /// Bodies that are not in the table are passed over.
    pub only_known: bool,
}

impl Rows<'_> {
    /// Finds the bodies whose row of a column was written with a value that differs from the table.
    pub(in crate::body) fn compare<T>(
        self,
        column: ContiguousRef<T>,
        known: impl Fn(&BodyState, &T) -> bool,
        found: &mut Vec<Entity>,
    ) {
        look(column, self.since, |row, value| {
            if self.passes_over(row) {
                return;
            }
            if !self.body(row).is_some_and(|body| known(body, value)) {
                found.push(self.entities[row]);
            }
        });
    }

    fn passes_over(&self, row: usize) -> bool {
        self.only_known && self.slots[row] == BodyIndex::NONE
    }

    /// The body of a row, if it is in the table.
    fn body(&self, row: usize) -> Option<&BodyState> {
        let body = self.table.get(self.slots[row].0);
        body.filter(|body| body.entity == self.entities[row])
    }
}

/// Returns a test of whether a tick is newer than the last run of a system. It agrees with [`Tick::is_newer_than`] and does half of the
/// work for each tick. In a world at rest these comparisons are most of a step, because the tick of every `Transform` is read.
#[inline]
pub(crate) fn newer_than(last: Tick, this: Tick) -> impl Fn(Tick) -> bool + Copy {
    let this = this.get();
    // Bevy clamps both ages to this maximum. After one is clamped, the other compares the same either way.
    let since = this.wrapping_sub(last.get()).min(MAX_CHANGE_AGE);
    move |tick| this.wrapping_sub(tick.get()) < since
}

/// The rows of a column whose tick is new.
#[inline]
pub(crate) fn new_rows<F: Fn(Tick) -> bool + Copy>(ticks: &[Tick], is_new: F) -> NewRows<'_, F> {
    NewRows {
        ticks,
        is_new,
        row: 0,
        end: 0,
    }
}

/// The iterator of [`new_rows`]. It is written by hand because there is one for each component of a body: a chain of adapters is compiled
/// anew with each closure that it is given.
pub(crate) struct NewRows<'a, F> {
    ticks: &'a [Tick],
    is_new: F,
    /// The next row.
    row: usize,
    /// The end of the chunk with new rows that `row` is in, if it is in one.
    end: usize,
}

impl<F: Fn(Tick) -> bool + Copy> Iterator for NewRows<'_, F> {
    type Item = usize;

    fn next(&mut self) -> Option<usize> {
        const ROWS_PER_CHUNK: usize = 64;
        loop {
            while self.row < self.end {
                let row = self.row;
                self.row += 1;
                if (self.is_new)(self.ticks[row]) {
                    return Some(row);
                }
            }
            // Ticks are compared in chunks without a branch, so that the compiler vectorizes the common case in which nothing was written.
            let rest = &self.ticks[self.row..];
            let chunk = &rest[..rest.len().min(ROWS_PER_CHUNK)];
            if chunk.is_empty() {
                return None;
            }
            let mut any = false;
            for &tick in chunk {
                any |= (self.is_new)(tick);
            }
            match any {
                true => self.end = self.row + chunk.len(),
                false => self.row += chunk.len(),
            }
        }
    }
}

/// The rows of a column that were written since the system ran last. It reads the tick of every row, since Bevy's summary tick of the
/// column misses some writes of observers.
pub(crate) fn written_rows<T>(column: &ContiguousRef<T>) -> impl Iterator<Item = usize> {
    let (last, this) = (column.last_run_tick(), column.this_run_tick());
    rows_since(column.changed_ticks_slice(), last, this)
}

/// The rows that were written since a system ran last. As a function of its own it names the same type for all components.
fn rows_since(ticks: &[Tick], last: Tick, this: Tick) -> impl Iterator<Item = usize> {
    new_rows(ticks, newer_than(last, this))
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
        for row in rows_since(rows, last, this) {
            written(row, &values[row]);
        }
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
