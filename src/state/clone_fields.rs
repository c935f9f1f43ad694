//! Clones that use memory again.

use smallvec::{Array, SmallVec};

/// Copies a list of plain numbers as a block. Its `Clone` copies it number by number.
pub(crate) fn copy<A: Array<Item: Copy>>(list: &SmallVec<A>) -> SmallVec<A> {
    SmallVec::from_slice(list)
}

/// Makes a list equal to another one, in the memory that it has.
#[inline]
pub(crate) fn copy_into<A: Array<Item: Copy>>(list: &mut SmallVec<A>, from: &SmallVec<A>) {
    if list.len() == from.len() {
        list.copy_from_slice(from);
    } else {
        list.clear();
        list.extend_from_slice(from);
    }
}

/// Implements `Clone` field by field. Unlike a derived one, its `clone_from` uses the memory of lists again: snapshots of large worlds are taken and
/// restored many times a second.
macro_rules! clone_fields {
    ($Type:ident { $($field:ident),+ $(,)? }) => {
        impl Clone for $Type {
            fn clone(&self) -> Self {
                Self {
                    $($field: self.$field.clone(),)+
                }
            }

            fn clone_from(&mut self, from: &Self) {
                $(self.$field.clone_from(&from.$field);)+
            }
        }
    };
}
pub(crate) use clone_fields;
