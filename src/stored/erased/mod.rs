//! Values whose type is known only when the program runs. This is the one module of the library with `unsafe` code for them.
//!
//! A [`Kind`] says what can be done with the values of a type: clone, compare, write to bytes. It is a table of functions, the only code
//! that is compiled for each type. All else is compiled once: [`Values`] is a list, [`Slice`] and [`SliceMut`] are borrowed values, and
//! [`Kind::read`] and [`Kind::write`] find those of a world.
//!
//! # Contract
//!
//! Every function that is not `unsafe` can be called with any arguments. Three rules make that so, and each `SAFETY` comment names the one
//! that it needs:
//!
//! - *Type*: a [`Values`], [`Slice`] or [`SliceMut`] points to valid values of the type of its kind, and a function of the kind gets no
//!   others. Two of them meet only if their kinds have the same type, which is checked.
//! - *World*: the id of a component is looked up by the [`TypeId`](std::any::TypeId) of the kind in the world in which it is used. Bevy
//!   stores values of that type under it.
//! - *Borrow*: values of a world are read while it is borrowed, and written while it is borrowed mutably, one column at a time.
//!
//! A value may panic when it is cloned or dropped. Then values may be leaked, but none is dropped twice.

#![allow(
    unsafe_code,
    reason = "values are reached by pointers, since their types are not known here"
)]

mod kind;
mod slice;
#[cfg(test)]
mod tests;
mod values;
mod world;

#[cfg(feature = "serde")]
pub(crate) use kind::Out;
pub(crate) use kind::{How, Kind};
pub(crate) use slice::{Slice, SliceMut};
pub(crate) use values::Values;
#[cfg(feature = "serde")]
pub(crate) use world::In;
pub(crate) use world::{Cells, CellsMut};
