//! Masonry of hulls that touch exactly, against limit analysis: it stands where statics lets it and falls where it does not.
//!
//! `cargo test --test all masonry:: -- --nocapture` prints the figures; with `--ignored` the limits, by bisection.

mod arches;
mod blocks;
mod drawings;
mod limit;
mod site;
mod slides;
mod slope;
mod stacks;
mod statics;
mod tilts;
mod truth;
mod wedges;
