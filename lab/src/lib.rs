//! Drystone's laboratory: what its examples, tests and benches, and the comparison with other engines, set up and measure with. It uses
//! drystone as any user does, by its public items.
//!
//! ```
//! use drystone::settings::Preset;
//! use drystone_lab::experiment::Experiment;
//!
//! let scene = "wall:4x3".parse().unwrap();
//! let outcome = Experiment::new(scene, Preset::Default).run_seconds(1.0);
//! assert!(outcome.stands && outcome.displacement.drift < 1e-3);
//! ```
//!
//! | module | contents |
//! |---|---|
//! | [`scenes`] | walls, stacks, arches, heaps: by name, with noise from a seed |
//! | [`blows`] | bodies that fall on a stack or are shot at a wall, and how far they move other bodies |
//! | [`energy`] | the energy that loose bodies gain |
//! | [`experiment`] | a scene under given settings, stepped and measured |
//! | [`hashes`] | a hash of all poses and velocities of a simulation |
//! | [`housner`] | a block that rocks, in double precision |
//! | [`memory`] | the memory of this process |
//! | [`metrics`] | the meters: penetration, drift, sag, tilt, jitter, energy |
//! | [`overlap`] | how deep two bodies are in each other, from shapes and poses alone |
//! | [`play`] | a player who lays, takes and throws |
//! | [`quake`] | structures on a shaking table |
//! | [`report`] | the result of an experiment as JSON |
//! | [`solvers`] | solvers from the literature, as baselines |
//! | [`slopes`] | mixed bodies dropped on hills, and who of them does not come to rest |
//! | [`town`] | many walls that stand asleep |
//! | [`tilt`] | the slope at which a box slides, and at which a block and a column topple |
//! | [`output`] | where an example writes |
//! | `plots` | a canvas with a font, and legends |
//! | `pictures` | frames of a scene |
//!
//! The last two come with the feature `plots`, which is on by default.

#![warn(missing_docs)]
#![deny(unsafe_code)]

pub mod blows;
pub mod energy;
pub mod experiment;
pub mod hashes;
pub mod housner;
pub mod memory;
pub mod metrics;
pub mod output;
pub mod overlap;
#[cfg(feature = "plots")]
pub mod pictures;
pub mod play;
#[cfg(feature = "plots")]
pub mod plots;
pub mod quake;
pub mod report;
pub mod scenes;
pub mod slopes;
pub mod solvers;
pub mod tilt;
pub mod town;
