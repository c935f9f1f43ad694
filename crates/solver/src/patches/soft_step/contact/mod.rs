//! The physics of a patch of contact: its springs, its rows, and a visit to them.
//!
//! - [`block`]: patches side by side, each in the six coordinates of its own contact.
//! - [`carry`]: loads patches into a block at the begin of a step, and stores its results.
//! - [`visit`]: one visit to a block: [`friction`], [`rolling`], [`normals`] and [`landing`].
//! - [`spring`], [`pass`]: the coefficients of springs, and the parameters of a pass; [`smooth`]: how bodies drift after it.
//! - [`kinds`]: which lanes of a block a visit treats as springs, and which as rigid.
//! - [`locks`], [`surface`]: bodies whose axes are locked, and surfaces that move.

pub mod block;
mod carry;
mod friction;
pub mod kinds;
mod landing;
mod locks;
pub mod normals;
pub mod pass;
mod rolling;
pub mod smooth;
pub mod spring;
mod surface;
pub mod visit;
