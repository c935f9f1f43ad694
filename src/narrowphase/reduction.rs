//! Reduction of a patch to four points that support a body like the whole polygon.
//!
//! Two square faces rotated slightly against each other meet in an octagon with unevenly spaced corners. Each point is a spring to a soft
//! solver, so the side with more points is stiffer, and the body on it leans: a stack of 20 with 0.01 rad of yaw fell because of that
//! alone. The corners that matter are the two points farthest from each other, and the farthest point on either side of the line between
//! them.

use super::candidates::{Candidate, Candidates};
use crate::solver::sort;
use glam::{Vec2, Vec3};

/// A patch narrower than this share of the smaller face's size is a line.
const LINE_WIDTH: f32 = 0.01;

/// The two points farthest from each other.
fn farthest(points: &Candidates) -> (usize, usize) {
    let at = |i: usize| points[i].position;
    let (mut a, mut b, mut longest) = (0, 0, 0.0);
    for i in 0..points.len() {
        for j in 0..i {
            let length = at(i).distance_squared(at(j));
            if length > longest {
                (a, b, longest) = (j, i, length);
            }
        }
    }
    (a, b)
}

/// Returns true if all points lie on one line.
pub(super) fn is_line(points: &Candidates, size: f32) -> bool {
    let (a, b) = farthest(points);
    let Some(first) = points.get(a).map(|a| a.position) else {
        return true;
    };
    let along = (points[b].position - first).normalize_or_zero();
    points.iter().all(|point| {
        let from = point.position - first;
        (from - along * along.dot(from)).length() < LINE_WIDTH * size
    })
}

/// Keeps the ends of a line.
pub(super) fn keep_ends(points: &mut Candidates) {
    let (a, b) = farthest(points);
    let mut i = 0;
    points.retain(|_| {
        i += 1;
        i - 1 == a || i - 1 == b
    });
}

/// Keeps at most four points of a patch, in their current order.
pub(super) fn reduce(points: &mut Candidates, normal: Vec3) {
    if points.len() <= 4 {
        return;
    }
    let at = |i: usize| points[i].position;
    let (a, b) = farthest(points);
    let across = normal.cross(at(b) - at(a));
    let side = |i: usize| across.dot(at(i) - at(a));
    let all = 0..points.len();
    let left = all.clone().max_by(|&i, &j| side(i).total_cmp(&side(j)));
    let right = all.min_by(|&i, &j| side(i).total_cmp(&side(j)));
    let kept = [Some(a), Some(b), left, right];
    let mut i = 0;
    points.retain(|_| {
        i += 1;
        kept.contains(&Some(i - 1))
    });
}

/// A patch of several parts keeps at most so many corners.
const MAX_CORNERS: usize = 8;

/// Keeps the corners of the convex hull of points of one plane with this normal. Points nearer than `tolerance` (m) to the line between two
/// corners are none.
pub(super) fn keep_corners(points: &mut Candidates, normal: Vec3, tolerance: f32) {
    let (u, v) = normal.any_orthonormal_pair();
    let at = |point: &Candidate| Vec2::new(u.dot(point.position), v.dot(point.position));
    // The sort is stable, so points are in the order of `u`, and then of `v`.
    sort::by_key(points, |point| at(point).y);
    sort::by_key(points, |point| at(point).x);
    let mut corners = Candidates::new();
    chain(points.iter(), at, tolerance, &mut corners);
    corners.pop();
    chain(points.iter().rev(), at, tolerance, &mut corners);
    corners.pop();
    while corners.len() > MAX_CORNERS {
        let count = corners.len();
        let area = |i: usize| {
            let [before, here, after] =
                [count - 1, 0, 1].map(|step| at(&corners[(i + step) % count]));
            (here - before).perp_dot(after - before).abs()
        };
        let least = (0..count).min_by(|&i, &j| area(i).total_cmp(&area(j)));
        corners.remove(least.unwrap_or(0));
    }
    if !corners.is_empty() {
        *points = corners;
    }
}

/// Adds one half of a convex hull, of points that are sorted along it: Andrew's monotone chain.
fn chain<'a>(
    points: impl Iterator<Item = &'a Candidate>,
    at: impl Fn(&Candidate) -> Vec2,
    tolerance: f32,
    corners: &mut Candidates,
) {
    let first = corners.len();
    for point in points {
        while let [.., before, last] = &corners[first..] {
            let (way, beyond) = (at(point) - at(before), at(last) - at(before));
            if beyond.perp_dot(way) > tolerance * way.length() {
                break;
            }
            corners.pop();
        }
        corners.push(*point);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pair::FeatureId;

    fn candidate(x: f32, z: f32) -> Candidate {
        Candidate {
            position: Vec3::new(x, 1.0, z),
            distance: 0.0,
            feature: FeatureId::NONE,
        }
    }

    fn corners(points: &[(f32, f32)]) -> Vec<(f32, f32)> {
        let mut candidates: Candidates = points.iter().map(|&(x, z)| candidate(x, z)).collect();
        keep_corners(&mut candidates, Vec3::Y, 1e-3);
        let mut found: Vec<_> = candidates
            .iter()
            .map(|c| (c.position.x, c.position.z))
            .collect();
        found.sort_by(|a, b| a.partial_cmp(b).unwrap());
        found
    }

    #[test]
    fn a_floor_of_cubes_keeps_its_corners() {
        let cube = |x: f32, z: f32| [(x, z), (x + 1.0, z), (x, z + 1.0), (x + 1.0, z + 1.0)];
        let square: Vec<_> = (0..9)
            .flat_map(|i| cube((i % 3) as f32, (i / 3) as f32))
            .collect();
        assert_eq!(
            corners(&square),
            [(0.0, 0.0), (0.0, 3.0), (3.0, 0.0), (3.0, 3.0)]
        );
        let angle: Vec<_> = [cube(0.0, 0.0), cube(1.0, 0.0), cube(0.0, 1.0)].concat();
        assert_eq!(
            corners(&angle),
            [(0.0, 0.0), (0.0, 2.0), (1.0, 2.0), (2.0, 0.0), (2.0, 1.0)]
        );
        let row: Vec<_> = (0..5).map(|i| (i as f32, 2.0 * i as f32)).collect();
        assert_eq!(corners(&row), [(0.0, 0.0), (4.0, 8.0)]);
    }

    #[test]
    fn a_round_floor_keeps_few_corners_around_its_middle() {
        let round: Vec<_> = (0..60).map(|i| (0.1 * i as f32).sin_cos()).collect();
        let kept = corners(&round);
        assert_eq!(kept.len(), MAX_CORNERS);
        for i in 0..16 {
            let (x, z) = (0.39 * i as f32).sin_cos();
            let reach = kept
                .iter()
                .map(|at| at.0 * x + at.1 * z)
                .fold(0.0, f32::max);
            assert!(reach > 0.85, "{kept:?} towards {x} {z}");
        }
    }
}
