//! Ranges of the rows of a table of pairs: stages visit only the active ones.

use bevy_ecs::change_detection::{ContiguousMut, ContiguousRef};
use std::ops::Range;

/// Columns of a table, of which a range of rows can be borrowed.
pub(crate) trait Part {
    /// The same columns with fewer rows.
    type Of<'a>
    where
        Self: 'a;

    /// Borrows a range of rows.
    fn part(&mut self, rows: &Range<u32>) -> Self::Of<'_>;
}

impl<T> Part for &[T] {
    type Of<'a>
        = &'a [T]
    where
        Self: 'a;

    fn part(&mut self, rows: &Range<u32>) -> Self::Of<'_> {
        &self[rows.start as usize..rows.end as usize]
    }
}

impl<T: Clone> Part for ContiguousRef<'_, T> {
    type Of<'a>
        = ContiguousRef<'a, T>
    where
        Self: 'a;

    fn part(&mut self, rows: &Range<u32>) -> Self::Of<'_> {
        self.clone().slice(rows.clone())
    }
}

impl<T> Part for ContiguousMut<'_, T> {
    type Of<'a>
        = ContiguousMut<'a, T>
    where
        Self: 'a;

    fn part(&mut self, rows: &Range<u32>) -> Self::Of<'_> {
        self.reborrow().slice(rows.clone())
    }
}

macro_rules! parts {
    ($($column:ident)*) => {
        #[expect(non_snake_case, reason = "a column is named as its type is")]
        impl<$($column: Part),*> Part for ($($column,)*) {
            type Of<'a>
                = ($($column::Of<'a>,)*)
            where
                Self: 'a;

            #[inline]
            fn part(&mut self, rows: &Range<u32>) -> Self::Of<'_> {
                let ($($column,)*) = self;
                ($($column.part(rows),)*)
            }
        }
    };
}

parts!(A B);
parts!(A B C);
parts!(A B C D);
parts!(A B C D E F);
