//! The contact of two convex polyhedra: cuboids, convex hulls, triangles.
//!
//! First the direction along which they are farthest apart or overlap least ([`separate`]); then what they have in common there:
//! of a face and what faces it the polygon of both, with a number for each corner that stays while the features do
//! ([`FeatureId`]); of two edges the point where they cross. `docs/contact.md` says why it is done so, with the sources.
//!
//! Plain functions on plain data: no entities, and no allocation but for faces of more than eight corners.

mod axis;
mod clip;
mod cuboid;
mod feature;
mod hull;
mod placement;
mod plane;
mod seams;
mod simplify;
mod solid;
mod triangle;

pub use axis::{Axis, Separation, separate};
pub use clip::{Clipped, Origin, Outline, Polygon, clip, facing, outline};
pub use cuboid::Cuboid;
pub use feature::FeatureId;
pub use placement::Placement;
pub use plane::meet_plane;
pub use solid::{Ridge, Side, Solid};
pub use triangle::Triangle;

use glam::DVec3;
use smallvec::SmallVec;

/// How far outside a face a corner still lies on it, as a share of the solid's size across.
const SLACK: f64 = 1e-4;

/// Where two solids touch, or may soon. In the frame of A.
#[derive(Clone, Debug)]
pub struct Contact {
    /// Unit vector from B to A.
    pub normal: DVec3,
    /// The corners of what they have in common, one after another around it.
    pub points: Points,
}

/// The points of a contact.
pub type Points = SmallVec<[Point; 8]>;

/// A point of contact, in the frame of A.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    /// Midway between the surfaces, m.
    pub position: DVec3,
    /// Distance of the surfaces there along the normal, m; negative: overlap.
    pub distance: f64,
    /// Which features meet there.
    pub feature: FeatureId,
}

/// What is known of two solids beforehand.
#[derive(Clone, Copy, Debug)]
pub struct Search {
    /// Points farther apart than this do not count, m.
    pub reach: f64,
    /// By how much they may overlap across the normal and still only graze each other, m.
    pub graze: f64,
}

/// Where B, placed in the frame of A, touches A. `axis`: that of the last time, and then that of this; it saves most of the work
/// where the two are still apart.
pub fn meet<A: Solid, B: Solid>(
    a: &A,
    b: &B,
    place: &Placement,
    search: Search,
    axis: &mut Axis,
) -> Option<Contact> {
    let found = separate(a, b, place, search.reach, *axis);
    *axis = found.axis;
    touch(a, b, place, &found, search)
}

/// Where they touch, once it is known along which axis.
pub fn touch<A: Solid, B: Solid>(
    a: &A,
    b: &B,
    place: &Placement,
    found: &Separation,
    search: Search,
) -> Option<Contact> {
    if found.distance > search.reach || seams::graze(a, b, place, found.normal, search.graze) {
        return None;
    }
    let points = match found.axis {
        Axis::Edges(of_a, of_b) => crossing(a, b, place, found, of_a, of_b)
            .into_iter()
            .collect(),
        _ => common(a, b, place, found),
    };
    finish(-found.normal, points, search.reach)
}

/// The same for a normal that is given, from A to B: what the two have in common along it.
pub fn meet_along<A: Solid, B: Solid>(
    a: &A,
    b: &B,
    place: &Placement,
    normal: DVec3,
    reach: f64,
) -> Option<Contact> {
    // The face that looks along the normal is the reference.
    let back = place.back(-normal);
    let (face_a, face_b) = (facing(a, normal), facing(b, back));
    let by_a = a.plane(face_a).0.dot(normal) >= b.plane(face_b).0.dot(back);
    let found = Separation {
        axis: match by_a {
            true => Axis::FaceOfA(face_a),
            false => Axis::FaceOfB(face_b),
        },
        normal,
        distance: 0.0,
    };
    finish(-normal, common(a, b, place, &found), reach)
}

fn finish(normal: DVec3, mut points: Points, reach: f64) -> Option<Contact> {
    points.retain(|point| point.distance <= reach);
    (!points.is_empty()).then_some(Contact { normal, points })
}

/// How far off what counts as on, m.
fn slack<A: Solid, B: Solid>(a: &A, b: &B) -> f64 {
    SLACK * across(a).min(across(b))
}

/// A length that is not large for any part of the solid, m.
fn across<S: Solid>(solid: &S) -> f64 {
    match solid.inner() {
        0.0 => solid.outer(),
        inner => (2.5 * inner).min(solid.outer()),
    }
}

/// What a face and what faces it have in common.
fn common<A: Solid, B: Solid>(a: &A, b: &B, place: &Placement, found: &Separation) -> Points {
    let slack = slack(a, b);
    match found.axis {
        Axis::FaceOfB(face) => {
            let (normal, back) = (place.back(-found.normal), place.inverse());
            let edges = |of_b, of_a| FeatureId::edges(of_a, of_b);
            let ids = (FeatureId::corner_of_b, FeatureId::corner_of_a, edges);
            let mut points = on_face(b, a, &back, face, normal, slack, ids);
            for point in &mut points {
                point.position = place.point(point.position);
            }
            points
        }
        Axis::FaceOfA(face) => {
            let ids = (
                FeatureId::corner_of_a,
                FeatureId::corner_of_b,
                FeatureId::edges,
            );
            on_face(a, b, place, face, found.normal, slack, ids)
        }
        _ => Points::new(),
    }
}

/// What lies on a face of the reference, in its frame. `normal` points away from it; the numbers of corners of the reference, of the
/// incident, and of crossings come from `ids`.
fn on_face<R: Solid, I: Solid>(
    reference: &R,
    incident: &I,
    place: &Placement,
    face: u16,
    normal: DVec3,
    slack: f64,
    (corner, other_corner, edges): (
        impl Fn(u16) -> FeatureId,
        impl Fn(u16) -> FeatureId,
        impl Fn(u16, u16) -> FeatureId,
    ),
) -> Points {
    let below = outline(incident, facing(incident, place.back(-normal)));
    let (out, offset) = reference.plane(face);
    let slant = 1.0 / out.dot(normal);
    let point = |clipped: Clipped| {
        let distance = (out.dot(clipped.at) - offset) * slant;
        Point {
            position: clipped.at - normal * (0.5 * distance),
            distance,
            feature: match clipped.origin {
                Origin::Reference(i) => corner(i),
                Origin::Incident(i) => other_corner(i),
                Origin::Edges(i, j) => edges(i, j),
            },
        }
    };
    clip(&outline(reference, face), &below, place, normal, slack)
        .into_iter()
        .map(point)
        .collect()
}

/// The point where two edges cross, if they do and not only the lines that they are on.
fn crossing<A: Solid, B: Solid>(
    a: &A,
    b: &B,
    place: &Placement,
    found: &Separation,
    of_a: u16,
    of_b: u16,
) -> Option<Point> {
    let [p, p_end] = a.edge(of_a).ends.map(|i| a.point(i));
    let [q, q_end] = b.edge(of_b).ends.map(|i| place.point(b.point(i)));
    let (u, v, w) = (p_end - p, q_end - q, q - p);
    // The point of each that is nearest to the other's line: both are in the plane of the two directions.
    let (uu, uv, vv) = (u.length_squared(), u.dot(v), v.length_squared());
    let square = uu * vv - uv * uv;
    let s = (w.dot(u) * vv - w.dot(v) * uv) / square;
    let t = (w.dot(u) * uv - w.dot(v) * uu) / square;
    let slack = slack(a, b);
    let on = |share: f64, length: f64| {
        let over = slack / length;
        (-over..=1.0 + over).contains(&share)
    };
    if !on(s, uu.sqrt()) || !on(t, vv.sqrt()) {
        return None;
    }
    Some(Point {
        position: 0.5 * (p + s * u + q + t * v),
        distance: found.distance,
        feature: FeatureId::edges(of_a, of_b),
    })
}
