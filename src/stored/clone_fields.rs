//! Clones that use memory again.

use smallvec::{Array, SmallVec};
use std::sync::Arc;

/// Copies a list of plain numbers as a block. Its `Clone` copies it number by number.
pub(crate) fn copy<A: Array<Item: Copy>>(list: &SmallVec<A>) -> SmallVec<A> {
    SmallVec::from_slice(list)
}

/// Makes a list equal to another one, in the memory that it has.
#[inline]
pub(crate) fn copy_into<A: Array<Item: Copy>>(list: &mut SmallVec<A>, from: &SmallVec<A>) {
    if list.len() != from.len() {
        list.clear();
        list.extend_from_slice(from);
        return;
    }
    // Most pairs have one patch of four points. A copy of known length is no call.
    match (list.len(), list.first_chunk_mut(), from.first_chunk::<4>()) {
        (4, Some(to), Some(from)) => *to = *from,
        (1, ..) => list[0] = from[0],
        _ => list.copy_from_slice(from),
    }
}

/// Makes two owners share a value. If they share it already, nothing is written: counting owners is an atomic operation.
#[inline]
pub(crate) fn share<T: ?Sized>(known: &mut Arc<T>, from: &Arc<T>) {
    if !Arc::ptr_eq(known, from) {
        known.clone_from(from);
    }
}

/// Implements `Clone` field by field. Unlike a derived one, its `clone_from` uses the memory of lists again: snapshots of large worlds are
/// taken and restored many times a second. Fields after `shared` are `Arc`s.
macro_rules! clone_fields {
    ($Type:ident { $($field:ident),+ $(,)? } $(shared { $($shared:ident),+ $(,)? })?) => {
        impl Clone for $Type {
            fn clone(&self) -> Self {
                Self {
                    $($field: self.$field.clone(),)+
                    $($($shared: self.$shared.clone(),)+)?
                }
            }

            fn clone_from(&mut self, from: &Self) {
                $(self.$field.clone_from(&from.$field);)+
                $($($crate::stored::share(&mut self.$shared, &from.$shared);)+)?
            }
        }
    };
}
pub(crate) use clone_fields;
