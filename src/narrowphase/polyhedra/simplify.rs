//! Few corners that hold as the whole polygon does.
//!
//! Two square faces turned a little against each other meet in an octagon whose corners crowd together unevenly. Each point is
//! a spring to a soft solver, so the side with more of them is stiffer, and what stands on it leans: a stack of 20 with 0.01 rad
//! of yaw fell by that alone. So the corner by which the polygon loses the least area goes first (Visvalingam and Whyatt 1993),
//! until every one counts and they are few enough. Corners that were there in the last step count more, or of two near each other
//! now this would stay, now that.

use super::{Contact, FeatureId};
use glam::DVec3;

/// A corner without which less than this share of the area is lost is none.
const SMALL: f64 = 0.05;

/// How many times as much a corner counts that was there before.
const KEPT: f64 = 2.0;

impl Contact {
    /// Drops corners until no more than `most` are left, and each of them counts. `known`: those that were there in the last step.
    pub fn simplify(&mut self, most: usize, known: impl Fn(FeatureId) -> bool) {
        let normal = self.normal;
        let points = &mut self.points;
        let twice = |x: DVec3, y: DVec3, z: DVec3| normal.dot((y - x).cross(z - x)).abs();
        let first = points[0].position;
        let whole: f64 = points
            .windows(2)
            .map(|pair| twice(first, pair[0].position, pair[1].position))
            .sum();
        while points.len() > 2 {
            let count = points.len();
            let loss = |i: usize| {
                let at = |k: usize| points[(i + k) % count].position;
                let area = twice(at(count - 1), at(0), at(1));
                match known(points[i].feature) {
                    true => KEPT * area,
                    false => area,
                }
            };
            let least = (0..count)
                .map(|i| (loss(i), i))
                .min_by(|x, y| x.0.total_cmp(&y.0));
            match least {
                Some((loss, i)) if count > most || loss < SMALL * whole => points.remove(i),
                _ => return,
            };
        }
    }
}
