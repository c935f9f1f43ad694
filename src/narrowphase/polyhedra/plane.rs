//! The contact of a polyhedron with a plane: the corners of the face that faces the plane.

use super::clip::{facing, outline};
use super::solid::Solid;
use super::{Contact, FeatureId, Point};
use glam::DVec3;

/// Computes the contact of a solid with the half-space `up · x ≤ height` in its frame, where `up` is a unit vector. The normal of the
/// contact is `up`. `corner` returns the identity of a corner. The contact is overwritten.
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
