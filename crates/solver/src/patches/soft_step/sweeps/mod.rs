//! Which contacts a sweep visits, and when.
//!
//! A sweep visits every contact once. [`budget`] finds how many sweeps a step needs, [`plan`] their order, [`layout`] which contacts lie
//! side by side in a block. Then sweeps run [one by one](one_by_one), or overlap: several in the lanes of one block ([`skewed`]), or one
//! behind the other through the blocks ([`pipeline`]). All of these ways give the same result, to the bit. [`quiet`] leaves out sweeps that
//! would change nothing.

pub mod budget;
pub mod following;
pub mod halves;
mod handed;
pub mod layout;
pub mod load_statistics;
mod one_by_one;
pub mod pipeline;
mod plan;
pub mod quiet;
pub mod skewed;

use smallvec::SmallVec;

/// Σ Wᵢᵢ Δλᵢ² of sweeps that are done, J.
pub type Changes = SmallVec<[f32; 8]>;

/// How the sweeps of a step run. This is decided once, before the first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// Sweeps may overlap.
    Overlapping,
    /// Each sweep ends before the next begins: joints are solved after each, bodies spin, or rigid sweeps go down.
    OneByOne,
    /// The same, and substeps in which bodies hit each other get more sweeps.
    Blows,
}
