//! Reduction of a polygon to a few corners that support a body like the whole polygon.
//!
//! Two square faces rotated slightly against each other meet in an octagon with unevenly spaced corners. Each point is a spring to a soft
//! solver, so the side with more points is stiffer, and the body on it leans: a stack of 20 with 0.01 rad of yaw fell because of that
//! alone. Therefore the corner that contributes the least area is removed first (Visvalingam and Whyatt 1993), until the corners are few
//! enough and each contributes enough. Corners that existed in the last step count more; otherwise two neighbours would alternate. A corner
//! that is clearly the deepest always stays; without it one body would sink into the other.
//!
//! A corner that was removed early may be needed later: of a round face four corners were left that enclosed 0.56 of its area. Therefore
//! each remaining corner is replaced by one between its neighbours that contributes clearly more.

use super::{Contact, FeatureId, Point, Points};
use glam::DVec3;
use smallvec::SmallVec;

/// Corners that contribute less than this share of the area are removed.
const SMALL_AREA_SHARE: f64 = 0.05;

/// A corner that is deeper than all others by this share of the polygon's width (the root of its area) stays.
const DEEP_CORNER_SHARE: f64 = 0.005;

/// For a corner that existed in the last step, [`DEEP_CORNER_SHARE`] is multiplied by this. A body whose supporting point is removed would
/// sink, rise, and rock for ever.
const LOADED_CORNER_FACTOR: f64 = 0.1;

/// Maximum number of corners of the intersection of two quadrilaterals. Only polygons with more corners are improved after the reduction.
const MAX_QUADRILATERAL_CORNERS: usize = 8;

/// Relative gain of area above which a corner is replaced.
const REPLACING_GAIN: f64 = 1.05;

/// Maximum number of passes that replace corners.
const MAX_PASSES: usize = 2;

/// Factor for the area that a corner contributes if it existed in the last step.
const KEPT_CORNER_FACTOR: f64 = 2.0;

impl Contact {
    /// Removes corners until at most `most` are left, and each of them contributes enough area. `known` returns whether a corner existed in
    /// the last step.
    pub fn simplify(&mut self, most: usize, known: impl Fn(FeatureId) -> bool) {
        if self.points.len() < 3 {
            return;
        }
        let whole = self.twice_area();
        let (normal, points) = (self.normal, &mut self.points);
        // Twice the area, as for the whole polygon.
        let area = |x: DVec3, y: DVec3, z: DVec3| normal.dot((y - x).cross(z - x)).abs();
        let counts = |before: &Point, point: &Point, after: &Point| {
            let area = area(before.position, point.position, after.position);
            match known(point.feature) {
                true => KEPT_CORNER_FACTOR * area,
                false => area,
            }
        };
        let loss = |points: &Points, i: usize| {
            let count = points.len();
            let before = &points[if i > 0 { i - 1 } else { count - 1 }];
            let after = &points[if i + 1 < count { i + 1 } else { 0 }];
            counts(before, &points[i], after)
        };
        let all = (points.len() > most.max(MAX_QUADRILATERAL_CORNERS)).then(|| points.to_vec());
        let mut losses = SmallVec::<[f64; 16]>::new();
        for i in 0..points.len() {
            losses.push(loss(points, i));
        }
        let clearly = DEEP_CORNER_SHARE * whole.sqrt();
        loop {
            if let Some(deepest) = clearly_deepest(points, clearly, &known) {
                losses[deepest] = f64::INFINITY;
            }
            let mut least = 0;
            for i in 1..losses.len() {
                if losses[i] < losses[least] {
                    least = i;
                }
            }
            if points.len() <= most && losses[least] >= SMALL_AREA_SHARE * whole
                || points.len() == 2
            {
                break;
            }
            points.remove(least);
            losses.remove(least);
            let count = points.len();
            for i in [least + count - 1, least] {
                losses[i % count] = loss(points, i % count);
            }
        }
        if let Some(all) = all
            && points.len() > 2
        {
            let deepest = clearly_deepest(points, clearly, &known);
            exchange(points, &all, deepest, counts);
        }
    }
}

/// Replaces each point by the corner of `all` between its neighbours that contributes the most area, if the gain is large enough.
fn exchange(
    points: &mut Points,
    all: &[Point],
    deepest: Option<usize>,
    counts: impl Fn(&Point, &Point, &Point) -> f64,
) {
    let (count, around) = (points.len(), all.len());
    for i in (0..MAX_PASSES * count).map(|i| i % count) {
        if Some(i) == deepest {
            continue;
        }
        let (before, after) = (points[(i + count - 1) % count], points[(i + 1) % count]);
        let mut most = REPLACING_GAIN * counts(&before, &points[i], &after);
        let place = |point: &Point| all.iter().position(|p| p.feature == point.feature);
        let (Some(first), Some(last)) = (place(&before), place(&after)) else {
            return;
        };
        let mut next = (first + 1) % around;
        while next != last {
            let counts = counts(&before, &all[next], &after);
            if counts > most && all[next].feature != points[i].feature {
                (most, points[i]) = (counts, all[next]);
            }
            next = (next + 1) % around;
        }
    }
}

/// Returns the corner that is deeper than all others by at least `by` (m), if there is one.
fn clearly_deepest(points: &Points, by: f64, known: impl Fn(FeatureId) -> bool) -> Option<usize> {
    let (mut deepest, mut least, mut second) = (0, f64::INFINITY, f64::INFINITY);
    for (i, point) in points.iter().enumerate() {
        if point.distance < least {
            (deepest, least, second) = (i, point.distance, least);
        } else {
            second = second.min(point.distance);
        }
    }
    let by = match known(points[deepest].feature) {
        true => LOADED_CORNER_FACTOR * by,
        false => by,
    };
    (least + by < second).then_some(deepest)
}
