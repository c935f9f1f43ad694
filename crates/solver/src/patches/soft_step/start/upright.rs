//! The vertical direction, and the upper body of a patch.

use crate::{PatchConstraint, PatchProblem};
use glam::Vec3;

/// A patch supports nothing if the cosine of its normal to the vertical is smaller than this.
const MIN_COSINE: f32 = 0.1;

/// The side of the body that lies on the other; none if the patch is too steep.
pub fn upper(patch: &PatchConstraint, up: Vec3) -> Option<usize> {
    let slope = patch.normal.dot(up);
    (slope.abs() >= MIN_COSINE).then_some(if slope > 0.0 { 0 } else { 1 })
}

/// The direction against gravity; zero without gravity.
pub fn up(problem: &PatchProblem) -> Vec3 {
    -problem.gravity.normalize_or_zero()
}
