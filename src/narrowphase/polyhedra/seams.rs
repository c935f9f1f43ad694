//! Seams: prevents a body that slides over flush faces from catching on an edge between them.
//!
//! A brick that slides along a course of bricks sinks in by a fraction of a millimetre, and then overlaps the side of the next brick by as
//! much. Collision detection would find a wall there, and the brick would bump or stop. The true contact is the one on top, which is about
//! to begin. Therefore a pair has no contact while it overlaps by almost nothing across the normal, at faces of both bodies that are flush.
//!
//! The same holds if the next face falls away at a small angle: the tops of the voussoirs of an arch form a polygon, and a body that slides
//! up one of them extends beyond the ridge before it tips over it.

use super::clip::facing;
use super::placement::Placement;
use super::solid::Solid;
use glam::DVec3;

/// Overlap below which flush faces do not touch, as a share of the smaller solid's extent.
const MIN_OVERLAP: f64 = 0.02;

/// The same at a ridge. It is smaller because in heaps of hulls many pairs of faces are at such small angles.
const RIDGE_SHARE: f64 = 0.01;

/// A face belongs to the contact itself if the cosine between its normal and the contact's is at least this.
pub(crate) const OWN_FACE_COSINE: f64 = 0.7;

/// Two faces may be flush if the cosine of the angle between them is above this (2°).
const FLUSH_COSINE: f64 = 0.9994;

/// Two faces may be the sides of a ridge if the cosine of the angle between them is above this (30°, as in an arch of six voussoirs).
const RIDGE_COSINE: f64 = 0.866;

/// The share of the extent below which an overlap is ignored, from the cosine of the angle between two faces.
fn share(along: f64) -> f64 {
    match along {
        _ if along > FLUSH_COSINE => MIN_OVERLAP,
        _ if along > RIDGE_COSINE => RIDGE_SHARE,
        _ => 0.0,
    }
}

/// Returns true if, along the normal of some face other than the contact's, the solids overlap by less than `most` (m) and by almost
/// nothing, and the face is flush with a face of the other solid.
pub fn graze<A: Solid, B: Solid>(
    a: &A,
    b: &B,
    place: &Placement,
    normal: DVec3,
    most: f64,
) -> bool {
    grazes(a, b, place, normal, most) || grazes(b, a, &place.inverse(), place.back(normal), most)
}

/// The same as [`graze`], for the faces of A.
fn grazes<A: Solid, B: Solid>(a: &A, b: &B, place: &Placement, normal: DVec3, most: f64) -> bool {
    let (center, inner) = (place.point(b.center()), b.inner());
    (0..a.faces()).any(|face| {
        let (out, offset) = a.plane(face);
        // A quick test: the ball inside B alone overlaps too much.
        if out.dot(normal).abs() >= OWN_FACE_COSINE || offset + inner - out.dot(center) >= most {
            return false;
        }
        let back = place.back(out);
        let near = b.reach(-back);
        let overlap = offset + near - out.dot(place.origin);
        if overlap >= most {
            return false;
        }
        let extent = (offset + a.reach(-out)).min(near + b.reach(back));
        let along = || -b.plane(facing(b, -back)).0.dot(back);
        overlap < MIN_OVERLAP * extent && overlap < share(along()) * extent
    })
}

#[cfg(test)]
mod tests {
    use super::super::Cuboid;
    use super::*;
    use glam::{DQuat, Vec3};

    #[test]
    fn a_brick_on_a_course_grazes_the_next_brick_only() {
        let brick = Cuboid::new(Vec3::new(0.5, 0.25, 0.25));
        let grazes = |from: [f64; 2], to: [f64; 2], normal: DVec3| {
            let way = DVec3::new(to[0] - from[0], to[1] - from[1], 0.0);
            graze(
                &brick,
                &brick,
                &Placement::new(way, DQuat::IDENTITY),
                normal,
                0.01,
            )
        };
        let sliding = [0.3, 0.4998];
        assert!(grazes(sliding, [1.4, 0.0], DVec3::X), "ahead");
        assert!(!grazes(sliding, [0.0, 0.0], DVec3::Y), "below");
        assert!(!grazes([0.0, 0.0], [1.0, 0.0], DVec3::X), "beside");
        assert!(!grazes(sliding, [1.4, 0.1], DVec3::X), "in the way");
    }

    /// A box slides up a slope to its end, where another slope begins.
    #[test]
    fn a_box_does_not_catch_on_a_ridge() {
        let cuboid = |x: f32, y: f32| Cuboid::new(Vec3::new(x, y, 0.5));
        let (sled, next) = (cuboid(0.2, 0.15), cuboid(0.35, 0.3));
        // In the frame of the sled. Its front bottom edge is `high` above the upper corner of the next slope.
        let passes = |degrees: f64, high: f64| {
            let turn = DQuat::from_rotation_z(-degrees.to_radians());
            let corner = turn * DVec3::new(-0.35, 0.3, 0.0);
            let way = DVec3::new(0.2, -0.15 - high, 0.0) - corner;
            graze(&sled, &next, &Placement::new(way, turn), DVec3::X, 0.01)
        };
        for degrees in [0.0, 6.0, 12.0, 24.0] {
            assert!(passes(degrees, -5e-4), "{degrees}°");
            assert!(!passes(degrees, -0.02), "a step at {degrees}°");
        }
        assert!(!passes(45.0, -5e-4), "a corner");
    }
}
