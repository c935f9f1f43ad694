//! Measurements whose closed-form results are known. The tests of `tests/all/reference.rs` and `examples/accuracy` call them.
//!
//! Numbers are rows of the table of reference values.

mod arch;
mod bounce;
mod cantilever;
mod chain;
mod feet;
mod free;
mod glance;
mod hit;
mod impact;
mod incline;
mod ladder;
mod motion;
mod overhang;
mod piles;
mod pulse;
mod rolling;
mod shapes;
mod spin;
mod stack;
mod table;
mod tipping;
mod value;

pub use arch::*;
pub use bounce::*;
pub use cantilever::*;
pub use chain::*;
pub use free::*;
pub use glance::*;
pub use hit::*;
pub use impact::*;
pub use incline::*;
pub use ladder::*;
pub use motion::*;
pub use overhang::*;
pub use piles::*;
pub use pulse::*;
pub use rolling::*;
pub use spin::*;
pub use stack::*;
pub use table::*;
pub use tipping::*;
pub use value::*;

use crate::{Lab, narrow};
use drystone::solver::Pgs;

/// A laboratory for steps of so many seconds.
pub type Settings = fn(f32) -> Lab;

/// As [`Lab::exact`], with projected Gauss–Seidel.
pub fn gauss_seidel(dt: f32) -> Lab {
    let solver = Pgs {
        iterations: 300,
        warm_start: 0.3,
        tolerance: 1e-6,
        ..Default::default()
    };
    Lab::solved_by(dt, solver)
}

/// The parameter between what holds and what gives way, as [`bisect`](crate::bisect) finds it. `None` if the first end does not hold or the
/// second one does.
fn threshold(holds: f32, gives: f32, width: f32, stands: impl Fn(f32) -> bool) -> Option<f32> {
    (stands(holds) && !stands(gives)).then(|| narrow(holds, gives, width, stands))
}
