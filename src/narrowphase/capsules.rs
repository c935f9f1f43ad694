//! The contact of two capsules: the nearest points, or the two ends of the line along which they lie side by side.
//!
//! Parry's manifold has only the nearest point. Between nearly parallel capsules it jumps from one end to the other when they tilt
//! slightly, and a capsule that lies on another would drop each time.

use crate::pair::ParryManifold;
use glam::Vec3;
use parry3d::math::Pose;
use parry3d::query::details::closest_points_segment_segment_with_locations;
use parry3d::query::{PointQuery, TrackedContact};
use parry3d::shape::{Capsule, PackedFeatureId};

/// Capsules lie side by side if the line between them leans from the normal by at most this angle, as a sine.
const MAX_LEAN: f32 = 0.02;

/// Fills the manifold with the points whose distance is at most `reach`, m.
pub(super) fn touch(
    place: &Pose,
    a: &Capsule,
    b: &Capsule,
    reach: f32,
    manifold: &mut ParryManifold,
) {
    let of_a = a.segment;
    let of_b = b.segment.transformed(place);
    let (at_a, at_b) = closest_points_segment_segment_with_locations(place, &a.segment, &b.segment);
    let (nearest_a, nearest_b) = (of_a.point_at(&at_a), of_b.point_at(&at_b));
    let between = nearest_b - nearest_a;
    let normal = between.try_normalize().unwrap_or(Vec3::Y);
    manifold.points.clear();
    manifold.local_n1 = normal;
    manifold.local_n2 = place.rotation.inverse() * -normal;
    let mut add = |on_a: Vec3, on_b: Vec3| {
        let distance = (on_b - on_a).dot(normal) - a.radius - b.radius;
        if distance <= reach {
            manifold.points.push(TrackedContact::new(
                on_a + normal * a.radius,
                place.inverse_transform_point(on_b - normal * b.radius),
                PackedFeatureId::face(0),
                PackedFeatureId::face(0),
                distance,
            ));
        }
    };
    add(nearest_a, nearest_b);
    let mut add_end = |on_a: Vec3, on_b: Vec3| {
        let between = on_b - on_a;
        let aside = between - normal * between.dot(normal);
        if aside.length_squared() <= MAX_LEAN * MAX_LEAN * between.length_squared() {
            add(on_a, on_b);
        }
    };
    for end in [of_a.a, of_a.b] {
        add_end(end, of_b.project_local_point(end, true).point);
    }
    for end in [of_b.a, of_b.b] {
        add_end(of_a.project_local_point(end, true).point, end);
    }
}
