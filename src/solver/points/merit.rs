//! The merit that solves are stopped and compared by.
//!
//! √(Σ Wᵢᵢ Δλᵢ²) over a sweep, relative to that of the free motion: how much of what gravity and impacts would do unopposed
//! is still being put right. Its square is an energy, so neither mass ratios nor sizes distort it.

use super::PointConstraint;
use crate::solver::Body;

/// The merit of the free motion, √J: the change a first sweep from λ = 0 would make if every contact were alone. Friction
/// has no part in it, as its bounds are zero there.
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
