//! The values of an earlier snapshot, entity by entity.

use super::super::column::Column;
use super::super::layout::Layout;
use super::super::target::{NOWHERE, RowsByIndex};
use crate::stored::erased::Slice;

/// A column of an earlier snapshot.
#[derive(Clone, Copy)]
pub(super) struct Earlier<'a> {
    pub column: &'a Column,
    layout: &'a Layout,
    /// Its row by the row of the later snapshot, or [`NOWHERE`].
    rows: &'a [u32],
}

impl<'a> Earlier<'a> {
    pub fn new(column: &'a Column, layout: &'a Layout, rows: &'a [u32]) -> Self {
        Self {
            column,
            layout,
            rows,
        }
    }

    /// The earlier value of an entity.
    pub fn value(&self, row: usize) -> Option<Slice<'a>> {
        match self.rows[row] {
            NOWHERE => None,
            row => {
                let run = self.layout.run_of_row(row as usize);
                self.column.value_of(self.layout, run, row as usize)
            }
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
