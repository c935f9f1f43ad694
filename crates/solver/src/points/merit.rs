//! The merit: the measure that decides when a solve ends, and by which solves are compared.
//!
//! It is √(Σ Wᵢᵢ Δλᵢ²) over a sweep, divided by the same for the free motion. So it is the share of the unopposed effect of gravity and
//! impacts that a sweep still corrects. Its square is an energy, so mass ratios and sizes do not distort it.

use super::PointConstraint;
use crate::Body;

/// The merit of the free motion, √J: the change that a first sweep from λ = 0 would make if every contact were alone. Friction is not
/// included, because its bounds are zero if λ = 0.
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
