//! The values of an earlier snapshot, entity by entity.

use super::super::column::AnyColumn;
use super::super::layout::Layout;
use super::super::target::{NOWHERE, RowsByIndex};
use std::any::Any;

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
        let column: &dyn Any = self.column;
        column
            .downcast_ref()
            .expect("all snapshots have the same columns")
    }

    /// The earlier row of an entity.
    pub fn row(&self, row: usize) -> Option<(&'a Layout, usize)> {
        let row = self.rows[row];
        (row != NOWHERE).then_some((self.layout, row as usize))
    }
}

/// The rows of the entities of a snapshot in an earlier one.
pub(super) fn rows(of: &Layout, earlier: &Layout) -> Vec<u32> {
    let by_index = RowsByIndex::new(&earlier.entities);
    let rows = of.entities.iter();
    rows.map(|&entity| by_index.of(entity, &earlier.entities))
        .collect()
}
