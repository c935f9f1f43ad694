//! A polyhedron on a plane: the corners of the face that it turns to it.

use super::clip::{facing, outline};
use super::solid::Solid;
use super::{Contact, FeatureId, Point};
use glam::DVec3;

/// Where a solid touches everything below a plane, or may soon: `up · x = height` in its frame, with the unit vector `up`. The
/// contact's normal is `up`; `corner` numbers its corners. The contact that is handed in is written over.
pub fn meet_plane<S: Solid>(
    solid: &S,
    up: DVec3,
    height: f64,
    reach: f64,
    corner: impl Fn(u16) -> FeatureId,
    contact: &mut Contact,
) {
    contact.normal = up;
    contact.points.clear();
    for (at, number, _) in outline(solid, facing(solid, -up)) {
        let distance = up.dot(at) - height;
        let point = Point::above(at, up, distance, corner(number), reach);
        contact.points.extend(point);
    }
}
