//! Users edit the components of pairs without a [`Revision`](crate::revision::Revision). This file finds their edits by change ticks and
//! gives each edited pair a new revision. Stages bypass change detection when they write, so ticks show only the edits of users.

/// True if a column, or one row of it, was written since this system ran last, by code that did not bypass change detection. Components of
/// new pairs do not count.
macro_rules! is_edited {
    ($column:expr, $row:expr) => {{
        let (last, this) = ($column.last_run_tick(), $column.this_run_tick());
        let (added, changed) = ($column.added_ticks_slice(), $column.changed_ticks_slice());
        changed[$row].is_newer_than(last, this) && changed[$row] != added[$row]
    }};
    ($column:expr) => {{
        let (last, this) = ($column.last_run_tick(), $column.this_run_tick());
        let ticks = $column.changed_ticks_slice().iter();
        let mut ticks = ticks.zip($column.added_ticks_slice());
        ticks.any(|(changed, added)| changed.is_newer_than(last, this) && changed != added)
    }};
}
pub(crate) use is_edited;

/// Gives the pairs in a table new revisions whose rows in one of the columns were edited since this system ran last. Returns true if there
/// are any. Every stage that skips unchanged pairs calls it before it looks at them.
macro_rules! revise_edited {
    ($pairs:expr, $($column:expr),+) => {{
        let mut any = false;
        $(if $crate::pair::is_edited!($column) {
            any = true;
            let revision = $crate::revision::Revision::next();
            for row in 0..$pairs.len() {
                if $crate::pair::is_edited!($column, row) {
                    $pairs.bypass_change_detection()[row].revise(revision);
                }
            }
        })+
        any
    }};
}
pub(crate) use revise_edited;
