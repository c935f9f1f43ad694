//! Bodies that rock, slide, are shaken and are struck, beside integrations in double precision.

mod rocking;
mod rods;
mod shaking;
mod sliding;
mod together;

pub use rocking::{rocks, rocks_elsewhere, rocks_on};
pub use rods::rods_bounce;
pub use shaking::shakes;
pub use sliding::slides_from_the_start;
pub use together::rocks_together;

/// A tolerance for steps of 0.1 s, 1/60 s, 1/240 s and less.
fn at_step(dt: f32, tolerances: [f32; 4]) -> f32 {
    let steps = [0.05, 0.01, 0.002];
    tolerances[steps.iter().filter(|&&step| dt < step).count()]
}
