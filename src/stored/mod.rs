//! The machinery for values of the [state](crate::state): how they are cloned, compared, written to bytes, and kept without their type.
//!
//! It knows no component. The list of them is in the module [`state`](crate::state).

mod clone_fields;
pub(crate) mod erased;
mod visitor;
#[cfg(feature = "serde")]
pub(crate) mod written;

pub(crate) use clone_fields::{clone_fields, copy, copy_into, share};
pub use visitor::{Role, Stored, Visitor};
