//! Reduction of a patch to four points that support a body like the whole polygon.
//!
//! Two square faces rotated slightly against each other meet in an octagon with unevenly spaced corners. Each point is a spring to a soft
//! solver, so the side with more points is stiffer, and the body on it leans: a stack of 20 with 0.01 rad of yaw fell because of that
//! alone. The corners that matter are the two points farthest from each other, and the farthest point on either side of the line between
//! them.

use super::candidates::Candidates;
use glam::Vec3;

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
