//! Hulls on half-spaces. Parry takes the feature that faces the plane best, and so may miss the corner that is deepest.

use crate::body::BodyState;
use glam::Vec3;

/// Of more than four corners those count that are no higher above the lowest than this share of the body's size.
const LOW: f32 = 0.02;

/// Points on A and on B: the corners of one, and where they are on the plane of the other; none for other shapes.
pub(super) fn contacts(a: &BodyState, b: &BodyState) -> Vec<[Vec3; 2]> {
    let of = |hull: &BodyState, plane: &BodyState| {
        let corners = hull.shape()?.as_convex_polyhedron()?.points();
        let up = plane.pose.rotation * plane.shape()?.as_halfspace()?.normal;
        let height = |corner: Vec3| up.dot(corner - plane.pose.position);
        let mut found: Vec<_> = corners
            .iter()
            .map(|corner| hull.pose.transform_point(*corner))
            .collect();
        found.sort_by(|x, y| height(*x).total_cmp(&height(*y)));
        let limit = height(found[0]) + LOW * hull.size();
        let low = found.partition_point(|corner| height(*corner) <= limit);
        found.truncate(low.max(4));
        Some(
            found
                .into_iter()
                .map(move |corner| [corner, corner - up * height(corner)])
                .collect(),
        )
    };
    let swap = |pairs: Vec<[Vec3; 2]>| pairs.into_iter().map(|[on_a, on_b]| [on_b, on_a]).collect();
    of(a, b).or_else(|| of(b, a).map(swap)).unwrap_or_default()
}
