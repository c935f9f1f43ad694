//! Parallel iteration over several slices of equal length, row by row.

use crate::solver::join::join;
use std::ops::Range;

/// A tuple of slices of equal length.
pub trait Columns: Sized + Send {
    /// One element of each slice.
    type Row;

    /// The number of rows.
    fn rows(&self) -> usize;

    /// Splits all slices at a row.
    fn split_at(self, row: usize) -> [Self; 2];

    /// Does work on each row, in order.
    fn for_each(self, work: &impl Fn(Self::Row));

    /// Does work on each row on several threads, with at least `grain` rows for each.
    fn share(self, grain: usize, work: &(impl Fn(Self::Row) + Sync)) {
        let rows = self.rows();
        if rows / 2 < grain {
            return self.for_each(work);
        }
        let [one, other] = self.split_at(rows / 2);
        join(|| one.share(grain, work), || other.share(grain, work));
    }
}

/// One slice.
pub trait Column: Sized + Send + IntoIterator {
    /// The number of elements.
    fn rows(&self) -> usize;

    /// Splits the slice at a row.
    fn split_at_row(self, row: usize) -> (Self, Self);
}

impl<T: Sync> Column for &[T] {
    fn rows(&self) -> usize {
        self.len()
    }

    fn split_at_row(self, row: usize) -> (Self, Self) {
        self.split_at(row)
    }
}

impl<T: Send> Column for &mut [T] {
    fn rows(&self) -> usize {
        self.len()
    }

    fn split_at_row(self, row: usize) -> (Self, Self) {
        self.split_at_mut(row)
    }
}

/// The numbers of the rows.
impl Column for Range<usize> {
    fn rows(&self) -> usize {
        self.len()
    }

    fn split_at_row(self, row: usize) -> (Self, Self) {
        let middle = self.start + row;
        (self.start..middle, middle..self.end)
    }
}

macro_rules! columns {
    ($first:ident $($other:ident)*) => {
        #[expect(non_snake_case, reason = "a column is named as its type is")]
        impl<$first: Column, $($other: Column),*> Columns for ($first, $($other,)*) {
            type Row = ($first::Item, $($other::Item,)*);

            fn rows(&self) -> usize {
                self.0.rows()
            }

            fn split_at(self, row: usize) -> [Self; 2] {
                let ($first, $($other,)*) = self;
                let $first = $first.split_at_row(row);
                $(let $other = $other.split_at_row(row);)*
                [($first.0, $($other.0,)*), ($first.1, $($other.1,)*)]
            }

            #[inline]
            fn for_each(self, work: &impl Fn(Self::Row)) {
                let ($first, $($other,)*) = self;
                $(let mut $other = $other.into_iter();)*
                for $first in $first {
                    $(let Some($other) = $other.next() else { return };)*
                    work(($first, $($other,)*));
                }
            }
        }
    };
}

columns!(A);
columns!(A B);
columns!(A B C);
columns!(A B C D);
columns!(A B C D E);
columns!(A B C D E F);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_visited_once_however_they_are_shared() {
        let numbers: Vec<u32> = (0..1000).collect();
        for grain in [1, 7, 400, usize::MAX / 2] {
            let mut found = vec![0; 1000];
            (&*numbers, &mut *found).share(grain, &|(number, found)| *found += number + 1);
            assert!(
                found
                    .iter()
                    .zip(1..)
                    .all(|(&found, wanted)| found == wanted)
            );
        }
    }
}
