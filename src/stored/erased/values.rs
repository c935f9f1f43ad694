//! A list of values.

use super::{Kind, Slice, SliceMut};
use bevy_ecs::change_detection::MaybeLocation;
use bevy_ecs::component::ComponentId;
use bevy_ecs::ptr::OwningPtr;
use bevy_ecs::world::EntityWorldMut;
use bevy_ecs::world::World;
use std::alloc::{Layout, alloc, dealloc, handle_alloc_error, realloc};
use std::any::TypeId;
use std::fmt;
use std::ops::Range;
use std::ptr::NonNull;

/// A list of values of one kind.
pub(crate) struct Values {
    kind: Kind,
    /// Memory for `capacity` values, of which the first `len` are there.
    first: NonNull<u8>,
    len: usize,
    capacity: usize,
}

// SAFETY: Components can be sent to other threads.
unsafe impl Send for Values {}
// SAFETY: Components can be shared among threads.
unsafe impl Sync for Values {}

impl fmt::Debug for Values {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let all = (0..self.len).map(|at| self.as_slice().one(at).debug());
        f.debug_list().entries(all).finish()
    }
}

impl Clone for Values {
    fn clone(&self) -> Self {
        let mut values = Self::new(self.kind);
        values.push(self.as_slice());
        values
    }
}

impl Drop for Values {
    fn drop(&mut self) {
        self.clear();
        if let Some(memory) = self.memory() {
            // SAFETY: It is the memory that was allocated.
            unsafe { dealloc(self.first.as_ptr(), memory) };
        }
    }
}

impl Values {
    /// An empty list.
    pub fn new(kind: Kind) -> Self {
        let align = kind.functions().layout.align();
        Self {
            kind,
            // Aligned, for values without a size and slices without values.
            first: NonNull::without_provenance(align.try_into().expect("it is not zero")),
            len: 0,
            capacity: 0,
        }
    }

    /// The list of a value of this type.
    ///
    /// # Panics
    /// If the kind has another type.
    pub fn with<T: 'static>(kind: Kind, value: T) -> Self {
        let mut values = Self::new(kind);
        assert!(kind.type_id() == TypeId::of::<T>(), "other values");
        values.reserve(1);
        // SAFETY: *Type*, which was checked. There is room.
        unsafe { values.first.cast::<T>().write(value) };
        values.len = 1;
        values
    }

    /// The list of a value.
    pub fn of(value: Slice) -> Self {
        let mut values = Self::new(value.kind());
        values.push(value);
        values
    }

    pub fn kind(&self) -> Kind {
        self.kind
    }

    #[cfg(any(feature = "serde", test))]
    pub fn len(&self) -> usize {
        self.len
    }

    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// The memory that was allocated.
    fn memory(&self) -> Option<Layout> {
        let layout = self.kind.functions().layout;
        (self.capacity > 0 && layout.size() > 0).then(|| array(layout, self.capacity))
    }

    fn place(&self, at: usize) -> *mut u8 {
        debug_assert!(at <= self.len.max(self.capacity));
        let size = self.kind.functions().layout.size();
        self.first.as_ptr().wrapping_add(at * size)
    }

    /// Makes room for more values. As by `Vec`, the memory doubles at least.
    fn reserve(&mut self, more: usize) {
        let needed = self.len.checked_add(more).expect("so many fit");
        if needed <= self.capacity {
            return;
        }
        let layout = self.kind.functions().layout;
        let capacity = match self.len {
            // All at once is the rule.
            0 => needed,
            _ => needed.max(2 * self.capacity),
        };
        if layout.size() > 0 {
            let new = array(layout, capacity);
            // SAFETY: The size is not zero; the old memory is that which was allocated.
            let first = unsafe {
                match self.memory() {
                    Some(old) => realloc(self.first.as_ptr(), old, new.size()),
                    None => alloc(new),
                }
            };
            self.first = NonNull::new(first).unwrap_or_else(|| handle_alloc_error(new));
        }
        self.capacity = capacity;
    }

    /// Removes the values after the first `len`.
    pub fn truncate(&mut self, len: usize) {
        let Some(more) = self.len.checked_sub(len) else {
            return;
        };
        // First, so that none is dropped twice if one panics.
        self.len = len;
        if let Some(drop) = self.kind.functions().drop {
            // SAFETY: *Type*. They are no longer in the list.
            unsafe { drop(self.place(len), more) };
        }
    }

    pub fn clear(&mut self) {
        self.truncate(0);
    }

    /// Appends clones of values.
    ///
    /// # Panics
    /// If they have another type.
    pub fn push(&mut self, from: Slice) {
        self.overwrite(self.len, from);
    }

    /// Writes clones of values after the first `at`: over the values that are there, in their memory, and then after the last one.
    ///
    /// # Panics
    /// If they have another type, or there are fewer than `at` values.
    pub fn overwrite(&mut self, at: usize, from: Slice) {
        assert!(self.kind.type_id() == from.kind().type_id(), "other values");
        let old = (self.len - at).min(from.len());
        self.part_mut(at..at + old).clone_from(from.part(0..old));
        let new = from.part(old..from.len());
        if new.len() == 0 {
            return;
        }
        self.reserve(new.len());
        let clone = self.kind.functions().clone;
        // SAFETY: *Type*, which was checked. There is room, and nobody else has its address.
        unsafe { clone(new.as_ptr(), self.place(self.len), new.len()) };
        self.len += new.len();
    }

    /// Takes a value from the front of bytes, and appends it. That of a component without a value is its default.
    ///
    /// # Errors
    /// If the bytes are none of a value.
    #[cfg(feature = "serde")]
    pub fn push_decoded(&mut self, from: &mut &[u8]) -> postcard::Result<()> {
        self.reserve(1);
        if let Some(default) = self.kind.functions().default {
            // SAFETY: There is room.
            unsafe { default(self.place(self.len)) };
            self.len += 1;
            return Ok(());
        }
        let code = self.kind.functions().code;
        let code = code.ok_or(postcard::Error::WontImplement)?;
        let mut decoder = postcard::Deserializer::from_bytes(from);
        // SAFETY: There is room.
        unsafe { (code.decode)(&mut decoder, self.place(self.len)) }?;
        self.len += 1;
        *from = decoder.finalize()?;
        Ok(())
    }

    pub fn as_slice(&self) -> Slice<'_> {
        // SAFETY: *Type*. They are borrowed for as long.
        unsafe { Slice::new(self.kind, self.first, self.len) }
    }

    /// Some of the values.
    ///
    /// # Panics
    /// If there are not as many.
    pub fn part(&self, range: Range<usize>) -> Slice<'_> {
        self.as_slice().part(range)
    }

    /// One of the values.
    pub fn one(&self, at: usize) -> Slice<'_> {
        self.as_slice().one(at)
    }

    pub fn as_mut(&mut self) -> SliceMut<'_> {
        // SAFETY: *Type*. They are borrowed for as long.
        unsafe { SliceMut::new(self.kind, self.first, self.len) }
    }

    /// Some of the values, to be written.
    ///
    /// # Panics
    /// If there are not as many.
    pub fn part_mut(&mut self, range: Range<usize>) -> SliceMut<'_> {
        assert!(range.start <= range.end && range.end <= self.len);
        let first = NonNull::new(self.place(range.start)).expect("it is in the list");
        // SAFETY: *Type*. They are borrowed for as long.
        unsafe { SliceMut::new(self.kind, first, range.len()) }
    }

    /// Takes the last value out of the list.
    ///
    /// The pointer owns it, and is used before the list is written again.
    fn pop(&mut self) -> OwningPtr<'_> {
        self.len = self.len.checked_sub(1).expect("there is a value");
        let last = NonNull::new(self.place(self.len)).expect("it was in the list");
        // SAFETY: *Type*. It is no longer in the list, whose memory is borrowed for as long.
        unsafe { OwningPtr::new(last) }
    }

    /// Inserts the last value into an entity, in place of the one that it has, and removes it from the list.
    pub fn insert_into(&mut self, entity: &mut EntityWorldMut) {
        let kind = self.kind;
        let id = match kind.id(entity.world().components()) {
            Some(id) => id,
            None => entity.world_scope(|world| kind.register(world)),
        };
        // SAFETY: *World*.
        unsafe { entity.insert_by_id(id, self.pop()) };
    }

    /// Inserts the last value of each list into an entity at once, and removes them from the lists.
    ///
    /// # Panics
    /// If a list has no value, or two have the same kind.
    pub fn insert_all_into(lists: &mut [Self], entity: &mut EntityWorldMut) {
        assert!(lists.iter().all(|values| values.len > 0), "no value");
        if lists.is_empty() {
            return;
        }
        let ids: Vec<ComponentId> = entity.world_scope(|world| {
            let ids = lists.iter().map(|values| values.kind.register(world));
            ids.collect()
        });
        // SAFETY: *World*. There are as many values as ids; Bevy checks that no id comes twice.
        unsafe { entity.insert_by_ids(&ids, lists.iter_mut().map(Self::pop)) };
    }

    /// Makes the last value that of the resource of a world, and removes it from the list.
    pub fn insert_resource(&mut self, world: &mut World) {
        let id = self.kind.register(world);
        // SAFETY: *World*.
        unsafe { world.insert_resource_by_id(id, self.pop(), MaybeLocation::caller()) };
    }
}

/// The memory of some values.
fn array(of: Layout, count: usize) -> Layout {
    let size = of.size().checked_mul(count).expect("it fits into memory");
    Layout::from_size_align(size, of.align()).expect("it fits into memory")
}
