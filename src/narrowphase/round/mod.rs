//! The contact of cylinders and cones with each other, with polyhedra and with half-spaces.
//!
//! First the direction along which they are farthest apart is found ([`separate`]). If faces lie on each other there, the contact is the
//! outline of one clipped by that of the other; otherwise it is the point at which the two are nearest.

mod face;
pub(super) mod frustum;
mod nearest;
mod normal;
mod part;
mod seams;
mod simplify;

use super::polyhedra::{CORNER_SLACK, Contact, FeatureId, Point, Search, clip};
use crate::solver::Both;
use face::{Face, LYING_COSINE};
pub use frustum::Frustum;
use glam::DVec3;
pub use normal::{Found, separate};
pub use part::Part;
pub use simplify::simplify;

/// Half the width of the line along which two round sides touch, as a share of the smaller size. If the sides cross at an angle, the points
/// are nearer to each other, because they must be within this width.
const LINE_HALF_WIDTH: f64 = 0.02;

/// Computes the contact of two bodies in their common frame. Returns a lower bound of their distance (m) if it is greater than the reach,
/// and −∞ otherwise.
///
/// `last` is the contact's direction in the last step, from A to B. The contact is overwritten.
pub fn meet(a: &Part, b: &Part, search: Search, last: Option<DVec3>, contact: &mut Contact) -> f64 {
    contact.points.clear();
    let found = match separate(a, b, search.reach, last) {
        Ok(found) => found,
        Err(apart) => return apart,
    };
    if !seams::graze(a, b, found.normal, search.graze) {
        touch(a, b, &found, search.reach, contact);
    }
    f64::NEG_INFINITY
}

/// Computes the contact along a direction that is known.
pub fn touch(a: &Part, b: &Part, found: &Found, reach: f64, contact: &mut Contact) {
    contact.normal = -found.normal;
    contact.points.clear();
    if let (Some(of_a), Some(of_b)) = (a.facing(found.normal), b.facing(-found.normal)) {
        let size = a.size().min(b.size());
        intersection(of_a, of_b, found.normal, size, reach, contact);
    }
    if contact.points.is_empty() && found.distance <= reach {
        contact.points.push(Point {
            position: 0.5 * (found.on[0] + found.on[1]),
            distance: found.distance,
            feature: FeatureId::NONE,
        });
    }
}

/// Computes the intersection of two faces. `size` is that of the smaller body, m.
fn intersection(
    of_a: Face,
    of_b: Face,
    normal: DVec3,
    size: f64,
    reach: f64,
    contact: &mut Contact,
) {
    let by_a = match [&of_a, &of_b].both(Face::is_line) {
        [false, true] => true,
        [true, false] => false,
        _ => of_a.normal.dot(normal) >= of_b.normal.dot(-normal),
    };
    let (reference, incident, up) = match by_a {
        true => (of_a, of_b, normal),
        false => (of_b, of_a, -normal),
    };
    if reference.is_line() && reference.along().dot(incident.along()).abs() < LYING_COSINE {
        return;
    }
    let (on, out) = (reference.outline[0].0, reference.normal);
    let reference = reference.widened(LINE_HALF_WIDTH * size);
    let slant = 1.0 / out.dot(up);
    let incident = incident.outline.into_iter();
    let Contact { points, space, .. } = contact;
    for clipped in clip(reference.outline, incident, up, CORNER_SLACK * size, space) {
        let distance = out.dot(clipped.at - on) * slant;
        let feature = clipped.origin.feature(by_a);
        points.extend(Point::above(clipped.at, up, distance, feature, reach));
    }
}

/// Computes the contact of a frustum with the half-space `up · x ≤ height` in its frame. `corner` returns the identity of a corner.
pub fn meet_plane(
    round: &Frustum,
    up: DVec3,
    height: f64,
    reach: f64,
    corner: impl Fn(u16) -> FeatureId,
    contact: &mut Contact,
) {
    contact.normal = up;
    contact.points.clear();
    let mut add = |at: DVec3, feature| {
        let distance = up.dot(at) - height;
        let point = Point::above(at, up, distance, feature, reach);
        contact.points.extend(point);
    };
    match round.facing(-up) {
        Some(face) => face
            .outline
            .iter()
            .for_each(|(at, i, _)| add(*at, corner(*i))),
        None => add(round.farthest(-up), FeatureId::NONE),
    }
}
