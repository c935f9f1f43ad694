//! Measurements whose closed-form results are known. The tests of `tests/all/reference.rs` and `examples/accuracy` call them.

mod incline;
mod ladder;
mod sphere;

pub use incline::*;
pub use ladder::*;
pub use sphere::*;

use crate::{Lab, narrow};

/// A laboratory for steps of so many seconds.
pub type Settings = fn(f32) -> Lab;

/// The parameter between what holds and what gives way, as [`bisect`](crate::bisect) finds it. `None` if the first end does not hold or the
/// second one does.
fn threshold(holds: f32, gives: f32, width: f32, stands: impl Fn(f32) -> bool) -> Option<f32> {
    (stands(holds) && !stands(gives)).then(|| narrow(holds, gives, width, stands))
}
