//! A slice that several threads share.

#![expect(
    unsafe_code,
    reason = "items go from thread to thread as sweeps pass them"
)]

use std::cell::Cell;
use std::marker::PhantomData;

/// A slice whose items threads pass to each other.
pub struct Handed<'a, T> {
    first: *mut T,
    count: usize,
    of: PhantomData<&'a mut [T]>,
}

// SAFETY: the owner has lent the slice, and threads access its items only in the way that `PipelinedSweeps` describes.
unsafe impl<T: Send> Sync for Handed<'_, T> {}
unsafe impl<T: Send> Send for Handed<'_, T> {}

impl<'a, T> Handed<'a, T> {
    pub fn new(items: &'a mut [T]) -> Self {
        Self {
            first: items.as_mut_ptr(),
            count: items.len(),
            of: PhantomData,
        }
    }

    /// # Safety
    /// Nothing else may access these items during the lifetime of the reference.
    #[inline(always)]
    #[expect(clippy::mut_from_ref, reason = "the caller answers for it")]
    pub unsafe fn range(&self, first: usize, end: usize) -> &mut [T] {
        assert!(first <= end && end <= self.count);
        // SAFETY: the range is in bounds, and the caller ensures exclusive access.
        unsafe { std::slice::from_raw_parts_mut(self.first.add(first), end - first) }
    }

    /// # Safety
    /// Nothing else may write to an item while it is read, or access it while it is written to.
    #[inline(always)]
    pub unsafe fn cells(&self) -> &[Cell<T>] {
        // SAFETY: a cell has the layout of its content; the caller ensures that accesses do not race.
        unsafe { std::slice::from_raw_parts(self.first.cast(), self.count) }
    }
}
