//! Masonry of hulls that touch exactly, what statics says of it, and how it ends when it is simulated.

pub mod blocks;
pub mod drawings;
pub mod limit;
pub mod limits;
pub mod site;
pub mod slope;
pub mod statics;
pub mod tables;
mod truth;
