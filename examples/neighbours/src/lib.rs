//! Compiles and runs the pages of drystone's cookbook about other crates, each with the version of `Cargo.lock`:
//!
//! ```sh
//! cargo test --doc --ignore-rust-version --manifest-path examples/neighbours/Cargo.toml
//! ```
//!
//! Bevy 0.20 names Rust 1.97.1 as its oldest; the parts of it that are used here build with drystone's 1.95, and
//! `--ignore-rust-version` says so. The pages are part of drystone's documentation, which does not test them, because it would need these
//! crates.

// Links of the pages are to drystone's items.
#[doc(no_inline)]
pub use drystone::*;

#[doc = include_str!("../../../src/cookbook/neighbours/neighbours.md")]
pub mod neighbours {}

#[doc = include_str!("../../../src/cookbook/neighbours/replicon.md")]
pub mod replicon {}

#[doc = include_str!("../../../src/cookbook/neighbours/ggrs.md")]
pub mod ggrs {}

#[doc = include_str!("../../../src/cookbook/neighbours/tnua.md")]
pub mod tnua {}

#[cfg(feature = "remote")]
#[doc = include_str!("../../../src/cookbook/neighbours/remote.md")]
pub mod remote {}

#[cfg(feature = "inspector")]
#[doc = include_str!("../../../src/cookbook/neighbours/inspector.md")]
pub mod inspector {}

#[doc = include_str!("../../../src/cookbook/neighbours/interpolation.md")]
pub mod interpolation {}
