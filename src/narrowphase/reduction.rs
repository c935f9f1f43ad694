//! Four points that hold as the whole polygon does.
//!
//! Two square faces turned a little against each other meet in an octagon whose corners crowd together unevenly. Each point is
//! a spring to a soft solver, so the side with more of them is stiffer, and what stands on it leans: a stack of 20 with 0.01 rad
//! of yaw fell by that alone. The two points farthest from each other and the farthest on either side of the line between them
//! are the corners that matter.

use super::Candidates;
use glam::Vec3;

/// Keeps at most four points of a patch, in the order in which they stand.
pub(super) fn reduce(points: &mut Candidates, normal: Vec3) {
    if points.len() <= 4 {
        return;
    }
    let at = |i: usize| points[i].position;
    let (mut a, mut b, mut longest) = (0, 1, 0.0);
    for i in 0..points.len() {
        for j in 0..i {
            let length = at(i).distance_squared(at(j));
            if length > longest {
                (a, b, longest) = (j, i, length);
            }
        }
    }
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
