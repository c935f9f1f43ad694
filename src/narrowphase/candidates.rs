//! Contact points before they are added to a manifold.

use super::Rules;
use crate::body::BodyState;
use crate::pair::{ContactPoint, FeatureId, Manifold, ManifoldPatch, PatchParts};
use crate::solver::sort;
use glam::Vec3;
use smallvec::SmallVec;

/// A contact point before it is added to a manifold.
#[derive(Clone, Copy)]
pub(super) struct Candidate {
    /// Midpoint between the surfaces, world, m.
    pub position: Vec3,
    /// Signed distance of the surfaces, m.
    pub distance: f32,
    pub feature: FeatureId,
}

pub(super) type Candidates = SmallVec<[Candidate; 8]>;

/// Smaller components of a normal are rounding and count as zero. A box on the ground has some of 1e-20; the solver multiplies them with
/// each other and with velocities at rest, and processors take a hundred times as long for the subnormal products.
const NONE: f32 = 1e-12;

/// A normal without components that are rounding.
pub(super) fn without_rounding(normal: Vec3) -> Vec3 {
    Vec3::select(normal.abs().cmplt(Vec3::splat(NONE)), Vec3::ZERO, normal)
}

/// A longer list is not sorted by insertion.
const MAX_INSERTION: usize = 16;

/// Sorts points by distance. There are few of them, so insertion is fastest.
pub(super) fn sort_deepest_first(points: &mut [Candidate]) {
    if points.len() > MAX_INSERTION {
        return sort::by_key(points, |point| point.distance);
    }
    for end in 1..points.len() {
        let mut at = end;
        while at > 0
            && points[at]
                .distance
                .total_cmp(&points[at - 1].distance)
                .is_lt()
        {
            points.swap(at, at - 1);
            at -= 1;
        }
    }
}

/// Adds a patch, its deepest point first.
///
/// The solver visits points in this order. With few iterations, the points visited first take more than their share of the load. If that is
/// always the same corner, the body leans over it; if it is the deepest point, the body is righted. This reduces the drift of walls and
/// stacks by a factor of 4 to 10 (`docs/findings.md`).
pub(super) fn push(
    manifold: &mut Manifold,
    bodies: [&BodyState; 2],
    normal: Vec3,
    curved: bool,
    mut points: Candidates,
) {
    if points.is_empty() {
        return;
    }
    sort_deepest_first(&mut points);
    let arm = |point: &Candidate| point.position - bodies[0].center;
    manifold.patches.push(ManifoldPatch {
        normal: without_rounding(normal),
        center: points.iter().map(arm).sum::<Vec3>() / points.len() as f32,
        first: manifold.points.len() as u32,
        count: points.len() as u32,
        curved,
        parts: PatchParts::default(),
        ahead: Vec3::ZERO,
    });
    manifold
        .points
        .extend(points.iter().map(|point| ContactPoint {
            arm: arm(point),
            distance: point.distance,
            detected: point.distance,
            feature: point.feature,
        }));
}

/// Maximum number of points of a patch.
pub(super) fn max_points(rules: &Rules) -> usize {
    match rules.manifolds.reduce_manifolds {
        true => 4,
        false => usize::MAX,
    }
}
