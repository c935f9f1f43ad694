//! Seams: solids whose faces lie in one plane must not catch on each other's edges.
//!
//! A brick that slides along a course sinks in by a fraction of a millimetre, and the next brick then stands in its way by as
//! much: collision detection finds a wall, and the brick bumps or stops. The true contact is the one that is about to begin, on
//! top. So a pair has no contact while it overlaps by next to nothing across the normal, where faces of both are flush.
//!
//! The same holds where the next face falls away a little: the tops of an arch's voussoirs are a polygon, and what slides up one of them looks over the
//! ridge before it tips over it.

use super::clip::facing;
use super::placement::Placement;
use super::solid::Solid;
use glam::DVec3;

/// Overlap that counts as none, as a share of the smaller solid's extent.
const SHARE: f64 = 0.02;

/// The same on a ridge: half as much, since in heaps of hulls many faces are as little turned.
const RIDGE_SHARE: f64 = 0.01;

/// A face whose normal is nearer to the contact's than this, as a cosine, is the contact's own.
pub(crate) const OWN: f64 = 0.7;

/// Two faces nearer to parallel than this, as a cosine, may be flush (2°).
const FLUSH: f64 = 0.9994;

/// Two faces nearer to parallel than this, as a cosine, may be two sides of a ridge (30°, which is an arch of six voussoirs).
const RIDGE: f64 = 0.866;

/// Cosine of the angle between two faces for which the smaller overlap counts.
fn share(along: f64) -> f64 {
    match along {
        _ if along > FLUSH => SHARE,
        _ if along > RIDGE => RIDGE_SHARE,
        _ => 0.0,
    }
}

/// True where the two overlap by less than `most` (m) and next to nothing along the normal of some face other than the contact's, which
/// lies along one of the other's.
pub fn graze<A: Solid, B: Solid>(
    a: &A,
    b: &B,
    place: &Placement,
    normal: DVec3,
    most: f64,
) -> bool {
    grazes(a, b, place, normal, most) || grazes(b, a, &place.inverse(), place.back(normal), most)
}

/// The same for the faces of A.
fn grazes<A: Solid, B: Solid>(a: &A, b: &B, place: &Placement, normal: DVec3, most: f64) -> bool {
    let (center, inner) = (place.point(b.center()), b.inner());
    (0..a.faces()).any(|face| {
        let (out, offset) = a.plane(face);
        // The ball inside B overlaps too much by itself.
        if out.dot(normal).abs() >= OWN || offset + inner - out.dot(center) >= most {
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
        overlap < SHARE * extent && overlap < share(along()) * extent
    })
}

#[cfg(test)]
mod tests {
    use super::super::Cuboid;
    use super::*;
    use glam::{DQuat, Vec3};

    #[test]
    fn a_brick_on_a_course_grazes_the_next_and_stands_on_its_own() {
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
    fn a_box_looks_over_a_ridge() {
        let cuboid = |x: f32, y: f32| Cuboid::new(Vec3::new(x, y, 0.5));
        let (sled, next) = (cuboid(0.2, 0.15), cuboid(0.35, 0.3));
        // In the frame of the sled, whose front bottom edge is at the next one's upper corner, `high` above that.
        let looks = |degrees: f64, high: f64| {
            let turn = DQuat::from_rotation_z(-degrees.to_radians());
            let corner = turn * DVec3::new(-0.35, 0.3, 0.0);
            let way = DVec3::new(0.2, -0.15 - high, 0.0) - corner;
            graze(&sled, &next, &Placement::new(way, turn), DVec3::X, 0.01)
        };
        for degrees in [0.0, 6.0, 12.0, 24.0] {
            assert!(looks(degrees, -5e-4), "{degrees}°");
            assert!(!looks(degrees, -0.02), "a step at {degrees}°");
        }
        assert!(!looks(45.0, -5e-4), "a corner");
    }
}
