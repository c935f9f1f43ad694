//! The contact of two convex polyhedra: cuboids, convex hulls, triangles.
//!
//! First the direction is found along which they are farthest apart, or overlap least ([`separate`]). Then the contact is computed along
//! that direction. For two faces it is the polygon in which they overlap, and each of its corners has a number that persists as long as its
//! features do ([`FeatureId`]). For two edges it is the point where they cross. `docs/contact.md` explains the reasons and gives the
//! sources.
//!
//! The module consists of plain functions on plain data: no entities, and no allocation except for faces with more than eight corners.

mod axis;
mod clip;
mod cuboid;
mod hull;
mod placement;
mod plane;
pub(crate) mod seams;
mod simplify;
mod solid;
mod triangle;

pub use crate::pair::FeatureId;
pub use crate::pair::cache::Axis;
pub use axis::{Separation, Separations, separate};
pub use clip::{Clipped, Origin, Outline, Space, clip, facing, longest_facing, outline};
pub use cuboid::Cuboid;
pub use placement::Placement;
pub use plane::meet_plane;
pub use solid::{Ridge, Side, Solid};
pub use triangle::Triangle;

use crate::solver::Both;
use glam::DVec3;
use smallvec::SmallVec;

/// Tolerance for a corner outside a face that still counts as on it, as a share of the solid's size ([`across`]).
pub(crate) const CORNER_SLACK: f64 = 1e-4;

/// The overlap along a preferred axis may be less by this share of the solid's size ([`across`]) than along the best axis.
const OVERLAP_SLACK: f64 = 1e-3;

/// The contact of two solids that touch or soon may, in the frame of A. It has no points if they do not touch. Functions overwrite a
/// contact that the caller provides, which avoids copying it.
#[derive(Clone, Debug, Default)]
pub struct Contact {
    /// Unit vector from B to A.
    pub normal: DVec3,
    /// The corners of the common polygon, in order around it.
    pub points: Points,
    pub(super) space: Space,
}

impl Contact {
    /// Twice the area of the polygon, m².
    fn twice_area(&self) -> f64 {
        let Some(first) = self.points.first() else {
            return 0.0;
        };
        let pairs = self.points.windows(2).map(|pair| {
            let [x, y] = [&pair[0], &pair[1]].both(|point| point.position - first.position);
            self.normal.dot(x.cross(y)).abs()
        });
        pairs.sum()
    }
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
    /// The features that meet there.
    pub feature: FeatureId,
}

impl Point {
    /// Creates a point for a point of one surface that is `distance` (m) above the other surface. Returns `None` beyond `reach` (m).
    pub(super) fn above(
        at: DVec3,
        up: DVec3,
        distance: f64,
        feature: FeatureId,
        reach: f64,
    ) -> Option<Self> {
        (distance <= reach).then(|| Self {
            position: at - up * (0.5 * distance),
            distance,
            feature,
        })
    }
}

/// The limits of a search for contacts.
#[derive(Clone, Copy, Debug)]
pub struct Search {
    /// Maximum distance of contact points, m.
    pub reach: f64,
    /// Overlap across the normal up to which the solids only graze each other, m. See `seams.rs`.
    pub graze: f64,
}

/// Computes the contact of A and B, which is placed in the frame of A. Returns their distance along the separating axis, m. If it is within
/// reach, there may still be no contact points, if no point of either faces the other.
///
/// `axis` is the axis of the last step, and is replaced by the new one. It saves most of the work if the solids are still apart.
pub fn meet<A: Solid, B: Solid>(
    a: &A,
    b: &B,
    place: &Placement,
    search: Search,
    axis: &mut Axis,
    contact: &mut Contact,
) -> f64 {
    let found = separate(a, b, place, search.reach, *axis);
    *axis = touch(a, b, place, &found, search, contact);
    found.best.distance
}

/// Computes the contact along separations that are known. Returns the axis that was used.
pub fn touch<A: Solid, B: Solid>(
    a: &A,
    b: &B,
    place: &Placement,
    found: &Separations,
    search: Search,
    contact: &mut Contact,
) -> Axis {
    let write = |axis: &Separation, contact: &mut Contact| {
        contact.normal = -axis.normal;
        contact.points.clear();
        intersection(a, b, place, axis, search.reach, contact);
    };
    let best = &found.best;
    contact.normal = -best.normal;
    contact.points.clear();
    if best.distance > search.reach {
        return best.axis;
    }
    write(best, contact);
    // Upper bound of the area of a polygon in such a narrow strip.
    let strip = search.graze / (1.0 - seams::OWN_FACE_COSINE * seams::OWN_FACE_COSINE).sqrt();
    let max_area = strip * 2.0 * a.outer().min(b.outer());
    if contact.twice_area() <= 2.0 * max_area
        && seams::graze(a, b, place, best.normal, search.graze)
    {
        contact.points.clear();
        return best.axis;
    }
    // The preferred face may end where the other one begins.
    if let Some(beside) = &found.beside {
        let enough = beside.distance + OVERLAP_SLACK * across(a).min(across(b));
        if contact.points.iter().all(|point| point.distance > enough) {
            write(beside, contact);
            return beside.axis;
        }
    }
    best.axis
}

/// Computes the contact along a given normal, from A to B.
pub fn touch_along<A: Solid, B: Solid>(
    a: &A,
    b: &B,
    place: &Placement,
    normal: DVec3,
    reach: f64,
    contact: &mut Contact,
) {
    contact.normal = -normal;
    contact.points.clear();
    faces_along(a, b, place, normal, reach, contact);
}

/// Replaces the contact of a face with a solid above it by that with a long face of the solid, from its nearest corner on, so that points
/// at both of its ends count. `axis` is that of the contact, and `long` says which of the two is such a solid. There may be none, and then
/// the contact stays.
pub fn touch_lengthwise<A: Solid, B: Solid>(
    a: &A,
    b: &B,
    place: &Placement,
    (axis, long): (Axis, [bool; 2]),
    reach: f64,
    contact: &mut Contact,
) {
    let slack = slack(a, b);
    let before = contact.points.clone();
    let normal = -contact.normal;
    contact.points.clear();
    match axis {
        Axis::FaceOfA(face) if long[1] => {
            let above = Above {
                face,
                normal,
                slack,
                reach,
            };
            if let Some(below) = longest_facing(b, place.back(-normal)) {
                above.points_on(a, (b, below), place, contact, true);
            }
        }
        Axis::FaceOfB(face) if long[0] => {
            let above = Above {
                face,
                normal: place.back(-normal),
                slack,
                reach,
            };
            let back = place.inverse();
            if let Some(below) = longest_facing(a, normal) {
                above.points_on(b, (a, below), &back, contact, false);
            }
            for point in &mut contact.points {
                point.position = place.point(point.position);
            }
        }
        _ => {}
    }
    if contact.points.is_empty() {
        contact.points = before;
    }
}

/// Computes the intersection of the faces that face each other along a normal, from A to B.
fn faces_along<A: Solid, B: Solid>(
    a: &A,
    b: &B,
    place: &Placement,
    normal: DVec3,
    reach: f64,
    contact: &mut Contact,
) {
    // The reference is the face that is closer to perpendicular to the normal.
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
    intersection(a, b, place, &found, reach, contact);
}

/// Tolerance within which a point counts as on a face or an edge, m.
fn slack<A: Solid, B: Solid>(a: &A, b: &B) -> f64 {
    CORNER_SLACK * across(a).min(across(b))
}

/// A length that is not large for any part of the solid, m.
pub(crate) fn across<S: Solid>(solid: &S) -> f64 {
    match solid.inner() {
        0.0 => solid.outer(),
        inner => (2.5 * inner).min(solid.outer()),
    }
}

/// Computes the intersection of a face with the opposite face, or of two edges, for points whose distance is at most `reach`.
fn intersection<A: Solid, B: Solid>(
    a: &A,
    b: &B,
    place: &Placement,
    found: &Separation,
    reach: f64,
    contact: &mut Contact,
) {
    let slack = slack(a, b);
    match found.axis {
        Axis::FaceOfA(face) => {
            let above = Above {
                face,
                normal: found.normal,
                slack,
                reach,
            };
            above.points(a, b, place, contact, true);
        }
        Axis::FaceOfB(face) => {
            let above = Above {
                face,
                normal: place.back(-found.normal),
                slack,
                reach,
            };
            let back = place.inverse();
            above.points(b, a, &back, contact, false);
            for point in &mut contact.points {
                point.position = place.point(point.position);
            }
        }
        Axis::Edges(of_a, of_b) => {
            let (point, crosses) = crossing(a, b, place, found, of_a, of_b);
            if !crosses && found.distance < 0.0 {
                // The crossing of almost parallel edges is arbitrary. The adjacent faces give a better contact, if they overlap.
                faces_along(a, b, place, found.normal, reach, contact);
            }
            if crosses || found.distance < 0.0 && contact.points.is_empty() {
                contact.points.push(point);
            }
        }
        Axis::Unknown => {}
    }
}

/// The part of the incident solid above a face of the reference solid.
struct Above {
    /// Face of the reference.
    face: u16,
    /// Direction of the contact, from the reference.
    normal: DVec3,
    /// Tolerance within which a point counts as inside, m.
    slack: f64,
    /// Maximum distance, m.
    reach: f64,
}

impl Above {
    /// Computes the contact points, in the frame of the reference. `by_a`: whether the reference is A.
    fn points<R: Solid, I: Solid>(
        &self,
        reference: &R,
        incident: &I,
        place: &Placement,
        contact: &mut Contact,
        by_a: bool,
    ) {
        let below = facing(incident, place.back(-self.normal));
        self.points_on(reference, (incident, below), place, contact, by_a);
    }

    /// As [`points`](Self::points), with this face of the incident solid.
    fn points_on<R: Solid, I: Solid>(
        &self,
        reference: &R,
        (incident, below): (&I, u16),
        place: &Placement,
        contact: &mut Contact,
        by_a: bool,
    ) {
        let below =
            outline(incident, below).map(|(at, point, edge)| (place.point(at), point, edge));
        let sides = outline(reference, self.face);
        let (out, offset) = reference.plane(self.face);
        let slant = 1.0 / out.dot(self.normal);
        let Contact { points, space, .. } = contact;
        for clipped in clip(sides, below, self.normal, self.slack, space) {
            let distance = (out.dot(clipped.at) - offset) * slant;
            let feature = clipped.origin.feature(by_a);
            points.extend(Point::above(
                clipped.at,
                self.normal,
                distance,
                feature,
                self.reach,
            ));
        }
    }
}

/// Returns the point at which two edges are nearest to each other, and whether the edges cross there, and not only the lines through them.
fn crossing<A: Solid, B: Solid>(
    a: &A,
    b: &B,
    place: &Placement,
    found: &Separation,
    of_a: u16,
    of_b: u16,
) -> (Point, bool) {
    let [p, p_end] = a.edge(of_a).ends.both(|i| a.point(i));
    let [q, q_end] = b.edge(of_b).ends.both(|i| place.point(b.point(i)));
    let (u, v, w) = (p_end - p, q_end - q, q - p);
    // The point of each that is nearest to the line of the other.
    let (uu, uv, vv) = (u.length_squared(), u.dot(v), v.length_squared());
    let square = uu * vv - uv * uv;
    let s = (w.dot(u) * vv - w.dot(v) * uv) / square;
    let t = (w.dot(u) * uv - w.dot(v) * uu) / square;
    let slack = slack(a, b);
    let on = |share: f64, length: f64| {
        let over = slack / length;
        (-over..=1.0 + over).contains(&share)
    };
    let crosses = on(s, uu.sqrt()) && on(t, vv.sqrt());
    let [s, t] = match crosses {
        true => [s, t],
        false => [s, t].both(|share| share.clamp(0.0, 1.0)),
    };
    let point = Point {
        position: 0.5 * (p + s * u + q + t * v),
        distance: found.distance,
        feature: FeatureId::edges(of_a, of_b),
    };
    (point, crosses)
}
