//! **Drystone**: rigid-body contact for Bevy that holds without mortar.
#![warn(missing_docs)]
#![deny(unsafe_code)]

pub mod body;
pub mod broadphase;
pub mod collider;
pub mod contact;
pub mod diagnosis;
pub mod experiment;
pub mod grab;
pub mod integration;
pub mod islands;
pub mod metrics;
pub mod narrowphase;
mod plugin;
pub mod profile;
pub mod scenes;
pub mod schedule;
pub mod settings;
pub mod sleeping;
pub mod solve;
pub mod solver;
pub mod stabilization;
pub mod warm_start;

pub use plugin::*;
pub use schedule::step;
