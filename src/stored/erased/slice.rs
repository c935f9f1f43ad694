//! Borrowed values.

#[cfg(feature = "serde")]
use super::How;
use super::Kind;
use bevy_ecs::entity::EntityMapper;
use std::any::TypeId;
use std::fmt::Debug;
use std::marker::PhantomData;
use std::ops::Range;
use std::ptr::NonNull;

/// Values to be read.
#[derive(Clone, Copy)]
pub(crate) struct Slice<'a> {
    kind: Kind,
    first: NonNull<u8>,
    len: usize,
    lifetime: PhantomData<&'a ()>,
}

/// Values to be written.
pub(crate) struct SliceMut<'a> {
    kind: Kind,
    first: NonNull<u8>,
    len: usize,
    lifetime: PhantomData<&'a mut ()>,
}

// SAFETY: A component can be shared among threads.
unsafe impl Send for Slice<'_> {}
// SAFETY: As above.
unsafe impl Sync for Slice<'_> {}

impl<'a> Slice<'a> {
    /// # Safety
    /// For `'a`, `first` points to `len` values of the type of `kind` that nobody writes.
    pub(super) unsafe fn new(kind: Kind, first: NonNull<u8>, len: usize) -> Self {
        Self {
            kind,
            first,
            len,
            lifetime: PhantomData,
        }
    }

    pub fn kind(self) -> Kind {
        self.kind
    }

    pub fn len(self) -> usize {
        self.len
    }

    pub(super) fn as_ptr(self) -> *const u8 {
        self.first.as_ptr()
    }

    /// Some of the values.
    ///
    /// # Panics
    /// If there are not as many.
    pub fn part(self, range: Range<usize>) -> Self {
        assert!(range.start <= range.end && range.end <= self.len);
        Self {
            // SAFETY: *Type*. The place is within the values or at their end.
            first: unsafe {
                self.first
                    .add(range.start * self.kind.functions().layout.size())
            },
            len: range.len(),
            ..self
        }
    }

    /// One of the values.
    pub fn one(self, at: usize) -> Self {
        self.part(at..at + 1)
    }

    /// The index of the first value that differs from another one. `None` if none does, or if they cannot be compared.
    ///
    /// # Panics
    /// If these are not as many values of the same type.
    pub fn first_difference(self, other: Slice) -> Option<usize> {
        check([self.kind, other.kind], [self.len, other.len]);
        let function = self.kind.functions().first_difference?;
        // SAFETY: *Type*, which was checked.
        let first = unsafe { function(self.as_ptr(), other.as_ptr(), self.len) };
        (first < self.len).then_some(first)
    }

    /// The first value, to be written as text.
    pub fn debug(self) -> &'a dyn Debug {
        assert!(self.len > 0);
        // SAFETY: *Type*. The value is borrowed for as long.
        unsafe { &*(self.kind.functions().debug)(self.as_ptr()) }
    }

    /// Appends the first value to bytes. A component without a value has none.
    ///
    /// # Errors
    /// If it cannot be written.
    #[cfg(feature = "serde")]
    pub fn encode(self, out: &mut Vec<u8>) -> postcard::Result<()> {
        assert!(self.len > 0);
        if self.kind.how == How::Valueless {
            return Ok(());
        }
        let code = self.kind.functions().code;
        let code = code.ok_or(postcard::Error::WontImplement)?;
        let mut to = postcard::Serializer {
            output: super::Out(out),
        };
        // SAFETY: *Type*.
        unsafe { (code.encode)(self.as_ptr(), &mut to) }
    }

    /// The values, if they are of this type.
    #[cfg(any(feature = "serde", test))]
    pub fn typed<T: 'static>(self) -> Option<&'a [T]> {
        let is_known = self.kind.type_id() == TypeId::of::<T>();
        // SAFETY: *Type*, which was checked. They are borrowed for as long.
        is_known.then(|| unsafe { std::slice::from_raw_parts(self.as_ptr().cast(), self.len) })
    }
}

impl<'a> SliceMut<'a> {
    /// # Safety
    /// For `'a`, `first` points to `len` values of the type of `kind` that nobody else reads or writes.
    pub(super) unsafe fn new(kind: Kind, first: NonNull<u8>, len: usize) -> Self {
        Self {
            kind,
            first,
            len,
            lifetime: PhantomData,
        }
    }

    /// The values to be read.
    pub fn as_slice(&self) -> Slice<'_> {
        // SAFETY: They are borrowed for as long.
        unsafe { Slice::new(self.kind, self.first, self.len) }
    }

    /// Some of the values.
    ///
    /// # Panics
    /// If there are not as many.
    pub fn part(&mut self, range: Range<usize>) -> SliceMut<'_> {
        let Slice { first, len, .. } = self.as_slice().part(range);
        // SAFETY: They are borrowed for as long.
        unsafe { SliceMut::new(self.kind, first, len) }
    }

    /// Makes the values equal to others, in the memory that they have.
    ///
    /// # Panics
    /// If these are not as many values of the same type.
    pub fn clone_from(&mut self, from: Slice) {
        check([self.kind, from.kind], [self.len, from.len]);
        let function = self.kind.functions().clone_from;
        // SAFETY: *Type*, which was checked. The mutable borrow overlaps no other.
        unsafe { function(from.as_ptr(), self.first.as_ptr(), self.len) };
    }

    /// Exchanges the values for others.
    ///
    /// # Panics
    /// If these are not as many values of the same type.
    pub fn swap(&mut self, other: &mut SliceMut) {
        check([self.kind, other.kind], [self.len, other.len]);
        let bytes = self.len * self.kind.functions().layout.size();
        let [a, b] = [self.first.as_ptr(), other.first.as_ptr()];
        // SAFETY: *Type*, which was checked. The mutable borrow overlaps no other.
        unsafe { std::ptr::swap_nonoverlapping(a, b, bytes) };
    }

    /// Replaces the entities that the values refer to.
    pub fn map(&mut self, mapper: &mut dyn EntityMapper) {
        // SAFETY: *Type*.
        unsafe { (self.kind.functions().map)(self.first.as_ptr(), self.len, mapper) };
    }

    /// The values, if they are of this type.
    pub fn typed<T: 'static>(self) -> Option<&'a mut [T]> {
        let is_known = self.kind.type_id() == TypeId::of::<T>();
        let first: *mut T = self.first.as_ptr().cast();
        // SAFETY: *Type*, which was checked. They are borrowed for as long.
        is_known.then(|| unsafe { std::slice::from_raw_parts_mut(first, self.len) })
    }
}

fn check(kinds: [Kind; 2], lengths: [usize; 2]) {
    assert!(
        kinds[0].type_id() == kinds[1].type_id() && lengths[0] == lengths[1],
        "other values"
    );
}
