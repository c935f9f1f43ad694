//! Reduction to a few points, as for polyhedra, but always with the deepest point. Of the many corners of a round end none contributes much to the area, and
//! a body that sinks in at an angle would go on sinking where no point is kept.

use crate::narrowphase::polyhedra::{Contact, FeatureId, Point};

/// Deeper than all others by this share of the smaller radius the deepest point is missed.
const DEEPER: f64 = 1e-3;

/// Drops points until no more than `most` are left. `radius`: of the smaller round body, m; `known`: those of the last step.
pub fn simplify(
    contact: &mut Contact,
    most: usize,
    radius: f32,
    known: impl Fn(FeatureId) -> bool,
) {
    let deepest_of = |contact: &Contact| {
        let points = contact.points.iter().copied();
        points.min_by(|x, y| x.distance.total_cmp(&y.distance))
    };
    let deepest = deepest_of(contact);
    contact.simplify(most, known);
    let (Some(deepest), Some(left)) = (deepest, deepest_of(contact)) else {
        return;
    };
    if deepest.distance < left.distance - DEEPER * radius as f64 {
        // In the place of the nearest, so that they still go around.
        let away = |point: &Point| point.position.distance_squared(deepest.position);
        let points = contact.points.iter_mut();
        let nearest = points.min_by(|x, y| away(x).total_cmp(&away(y)));
        if let Some(nearest) = nearest {
            *nearest = deepest;
        }
    }
}
