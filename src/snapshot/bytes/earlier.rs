//! The values of an earlier snapshot, entity by entity.

use super::super::column::{AnyColumn, Column};
use super::super::layout::Layout;
use super::super::target::{NOWHERE, RowsByIndex};
use super::same_type;

/// A column of an earlier snapshot.
#[derive(Clone, Copy)]
pub(in super::super) struct Earlier<'a> {
    column: &'a dyn AnyColumn,
    layout: &'a Layout,
    /// Its row by the row of the later snapshot, or [`NOWHERE`].
    rows: &'a [u32],
}

impl<'a> Earlier<'a> {
    pub fn new(column: &'a dyn AnyColumn, layout: &'a Layout, rows: &'a [u32]) -> Self {
        Self {
            column,
            layout,
            rows,
        }
    }

    /// The column, whose type is that of the later one.
    pub fn column<C: 'static>(&self) -> &'a C {
        same_type(self.column)
    }

    /// The earlier value of an entity, given the column.
    pub fn value<T: Clone, How>(&self, column: &'a Column<T, How>, row: usize) -> Option<&'a T> {
        match self.rows[row] {
            NOWHERE => None,
            row => column.value_of(self.layout, row as usize),
        }
    }
}

/// The rows of the entities of a snapshot in an earlier one.
pub(super) fn rows(of: &Layout, earlier: &Layout) -> Vec<u32> {
    let by_index = RowsByIndex::new(&earlier.entities);
    let rows = of.entities.iter();
    rows.map(|&entity| by_index.of(entity, &earlier.entities))
        .collect()
}
