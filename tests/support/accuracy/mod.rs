//! Measurements whose closed-form results are known. The tests of `tests/all/reference.rs` and `examples/accuracy` call them.

mod incline;
mod ladder;
mod sphere;

pub use incline::*;
pub use ladder::*;
pub use sphere::*;

use crate::Lab;

/// A laboratory for steps of so many seconds.
pub type Settings = fn(f32) -> Lab;

/// The middle between what holds and what gives way, bracketed to `width`. `None` if the first end does not hold or the second one does.
fn threshold(
    mut holds: f32,
    mut gives: f32,
    width: f32,
    stands: impl Fn(f32) -> bool,
) -> Option<f32> {
    if !stands(holds) || stands(gives) {
        return None;
    }
    while (gives - holds).abs() > width {
        let middle = 0.5 * (holds + gives);
        if stands(middle) {
            holds = middle;
        } else {
            gives = middle;
        }
    }
    Some(0.5 * (holds + gives))
}
