//! The largest separation and the deepest overlap in a problem.

use crate::{PatchPoint, PatchProblem};

/// The extremes over all points of contact.
#[derive(Clone, Copy, Debug)]
pub struct Gaps {
    /// The largest separation, m, at least 0.
    pub widest: f32,
    /// The smallest separation, m, at most 0.
    pub deepest: f32,
}

impl Gaps {
    pub fn of(problem: &PatchProblem) -> Self {
        let mut gaps = Self {
            widest: 0.0,
            deepest: 0.0,
        };
        // Comparisons are faster: `max` and `min` also treat NaN.
        for &PatchPoint { separation, .. } in &*problem.points {
            if separation > gaps.widest {
                gaps.widest = separation;
            }
            if separation < gaps.deepest {
                gaps.deepest = separation;
            }
        }
        gaps
    }
}
