//! Masonry of hulls that touch exactly, against limit analysis: it stands where statics lets it and falls where it does not.
//!
//! `cargo test --test all masonry:: -- --nocapture` prints the figures. `cargo run --release --example limits` finds the limits by
//! bisection.

mod arches;
mod slides;
mod stacks;
mod statics;
mod tilts;
mod wedges;
