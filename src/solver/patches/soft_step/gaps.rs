//! How far the bodies of a problem are apart, and how deep in each other.

use crate::solver::PatchProblem;

/// Of all points of contact.
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
        for point in &*problem.points {
            gaps.widest = gaps.widest.max(point.separation);
            gaps.deepest = gaps.deepest.min(point.separation);
        }
        gaps
    }
}
