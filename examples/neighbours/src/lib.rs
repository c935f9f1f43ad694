//! Compiles and runs the pages of drystone's cookbook about other crates, each with the version of `Cargo.lock`:
//!
//! ```sh
//! cargo test --ignore-rust-version --manifest-path examples/neighbours/Cargo.toml
//! ```
//!
//! `--all-features` adds the pages about `bevy_remote`, which on Linux needs `pkg-config` and `libasound2-dev`, and `bevy-inspector-egui`.
//! Bevy 0.20 names Rust 1.97.1; what is used of it here builds with drystone's 1.95 too, hence `--ignore-rust-version`.
//!
//! The pages are part of drystone's documentation. Drystone does not test them itself, because its tests would need these crates.

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

#[cfg(test)]
mod tests {
    const PAGE: &str = include_str!("../../../src/cookbook/neighbours/neighbours.md");
    const LOCK: &str = include_str!("../Cargo.lock");

    /// The table of what was run names the versions that are compiled here.
    #[test]
    fn versions_are_those_of_the_lockfile() {
        let (run, _) = PAGE.split_once("These were not run").unwrap();
        let mut crates = 0;
        for row in run.lines().filter(|line| line.starts_with("| `")) {
            let mut cells = row.split('|').skip(1);
            let names = cells.next().unwrap().split('`').skip(1).step_by(2);
            let versions: Vec<&str> = cells.next().unwrap().split(',').map(str::trim).collect();
            let names: Vec<&str> = names.collect();
            assert_eq!(names.len(), versions.len(), "{row}");
            for (name, version) in names.into_iter().zip(versions) {
                let locked = format!("name = \"{name}\"\nversion = \"{version}\"\n");
                assert!(LOCK.contains(&locked), "{name} {version}");
                crates += 1;
            }
        }
        assert!(crates >= 8, "{crates}");
    }
}
