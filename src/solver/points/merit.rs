//! The merit: the measure by which solves are stopped and compared.
//!
//! √(Σ Wᵢᵢ Δλᵢ²) over a sweep, relative to that of the free motion: the share of the unopposed effect of gravity and impacts that sweeps
//! still correct. Its square is an energy, so neither mass ratios nor sizes distort it.

use super::PointConstraint;
use crate::solver::Body;

/// The merit of the free motion, √J: the change that a first sweep from λ = 0 would make if every contact were alone. Friction has no part
/// in it, as its bounds are zero there.
pub fn free_merit(bodies: &[Body], constraints: &[PointConstraint]) -> f32 {
    let sum: f32 = constraints
        .iter()
        .filter(|c| c.diagonal.x > 0.0)
        .map(|c| {
            let missing = (c.target.x - c.velocity(bodies).x).max(0.0);
            missing * missing / c.diagonal.x
        })
        .sum();
    sum.sqrt()
}
