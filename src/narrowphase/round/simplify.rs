//! Reduction of a contact to a few points, as for polyhedra, but the deepest point is always kept. No single corner of a round end
//! contributes much area, and a body that sinks in at an angle would go on sinking if its deepest point were removed.

use crate::narrowphase::polyhedra::{Contact, FeatureId, Point};

/// The deepest point is restored if it is deeper than all others by this share of the smaller radius.
const DEEPER_POINT_SHARE: f64 = 1e-3;

/// Removes points until at most `most` are left. `radius` is that of the smaller round body, m. `known` returns whether a point existed in
/// the last step.
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
    if deepest.distance < left.distance - DEEPER_POINT_SHARE * radius as f64 {
        // It replaces the nearest point, so that the points stay in order around the polygon.
        let away = |point: &Point| point.position.distance_squared(deepest.position);
        let points = contact.points.iter_mut();
        let nearest = points.min_by(|x, y| away(x).total_cmp(&away(y)));
        if let Some(nearest) = nearest {
            *nearest = deepest;
        }
    }
}
