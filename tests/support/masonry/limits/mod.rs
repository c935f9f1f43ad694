//! Families of limits that statics knows.

pub mod arches;
pub mod columns;
pub mod wedges;
