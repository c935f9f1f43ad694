//! The physics of a patch of contact: its springs, its rows, and a visit to them.
//!
//! - [`block`]: patches side by side, each in the six coordinates of its own contact.
//! - [`carry`]: loads patches into a block at the begin of a step, and stores its results.
//! - [`visit`]: one visit to a block, which relaxes its rows.
//! - [`kinds`]: which lanes of a block a visit treats as springs, and which as rigid.
//! - [`locks`], [`surface`]: bodies whose axes are locked, and surfaces that move.

pub mod block;
mod carry;
pub mod kinds;
pub mod locks;
mod surface;
pub mod visit;
