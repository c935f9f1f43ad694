//! Which body of a patch lies on the other.

use crate::solver::{PatchConstraint, PatchProblem};
use glam::Vec3;

/// Nothing lies on a patch whose normal is flatter than this, as a cosine to the vertical.
const FLAT: f32 = 0.1;

/// On which side of a patch the body is that lies on the other; none where the patch is too steep.
pub fn upper(patch: &PatchConstraint, up: Vec3) -> Option<usize> {
    let slope = patch.normal.dot(up);
    (slope.abs() >= FLAT).then_some(if slope > 0.0 { 0 } else { 1 })
}

/// Against gravity; zero without any.
pub fn up(problem: &PatchProblem) -> Vec3 {
    -problem.gravity.normalize_or_zero()
}
