//! Which contacts a sweep visits, and when.

pub mod budget;
pub mod halves;
pub mod load_statistics;
pub mod pipeline;
pub mod quiet;
pub mod skewed;
