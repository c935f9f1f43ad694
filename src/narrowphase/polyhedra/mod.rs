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
mod hull;
mod placement;
mod plane;
pub(crate) mod seams;
mod simplify;
mod solid;
mod triangle;

pub use crate::contact::FeatureId;
pub use crate::contact::cache::Axis;
pub use axis::{Separation, Separations, separate};
pub use clip::{Clipped, Origin, Outline, Space, clip, facing, outline};
pub use cuboid::Cuboid;
pub use placement::Placement;
pub use plane::meet_plane;
pub use solid::{Ridge, Side, Solid};
pub use triangle::Triangle;

use glam::DVec3;
use smallvec::SmallVec;

/// How far outside a face a corner still lies on it, as a share of the solid's size across.
pub(crate) const SLACK: f64 = 1e-4;

/// By how much less overlap a preferred axis may show, as a share of the same.
const LACKING: f64 = 1e-3;

/// Where two solids touch, or may soon, in the frame of A; without points where they do not. It is handed in to be written over, which
/// spares moving it about.
#[derive(Clone, Debug, Default)]
pub struct Contact {
    /// Unit vector from B to A.
    pub normal: DVec3,
    /// The corners of what they have in common, one after another around it.
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
            let [x, y] = [&pair[0], &pair[1]].map(|point| point.position - first.position);
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
    /// Which features meet there.
    pub feature: FeatureId,
}

impl Point {
    /// Where a point of one surface is so far (m) above another in a direction; none beyond `reach`.
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
    /// Points farther apart than this do not count, m.
    pub reach: f64,
    /// By how much they may overlap across the normal and still only graze each other, m.
    pub graze: f64,
}

/// Where B, placed in the frame of A, touches A. `axis`: that of the last time, and then that of this; it saves most of the work
/// where the two are still apart. Gives how far they are apart along it, m: within reach they may be without a point that faces the
/// other.
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

/// Where they touch, once it is known along which axis; returns that which held enough.
pub fn touch<A: Solid, B: Solid>(
    a: &A,
    b: &B,
    place: &Placement,
    found: &Separations,
    search: Search,
    contact: &mut Contact,
) -> Axis {
    let along = |axis: &Separation, contact: &mut Contact| {
        contact.normal = -axis.normal;
        contact.points.clear();
        common(a, b, place, axis, search.reach, contact);
    };
    let best = &found.best;
    contact.normal = -best.normal;
    contact.points.clear();
    if best.distance > search.reach {
        return best.axis;
    }
    along(best, contact);
    // A polygon in such a narrow strip is no larger.
    let strip = search.graze / (1.0 - seams::OWN * seams::OWN).sqrt();
    let most = strip * 2.0 * a.outer().min(b.outer());
    if contact.twice_area() <= 2.0 * most && seams::graze(a, b, place, best.normal, search.graze) {
        contact.points.clear();
        return best.axis;
    }
    // The preferred face may end where the other one begins.
    if let Some(beside) = &found.beside {
        let enough = beside.distance + LACKING * across(a).min(across(b));
        if contact.points.iter().all(|point| point.distance > enough) {
            along(beside, contact);
            return beside.axis;
        }
    }
    best.axis
}

/// The same for a normal that is given, from A to B: what the two have in common along it.
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

/// The intersection of the faces that look along a normal, from A to B.
fn faces_along<A: Solid, B: Solid>(
    a: &A,
    b: &B,
    place: &Placement,
    normal: DVec3,
    reach: f64,
    contact: &mut Contact,
) {
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
    common(a, b, place, &found, reach, contact);
}

/// How far off what counts as on, m.
fn slack<A: Solid, B: Solid>(a: &A, b: &B) -> f64 {
    SLACK * across(a).min(across(b))
}

/// A length that is not large for any part of the solid, m.
pub(crate) fn across<S: Solid>(solid: &S) -> f64 {
    match solid.inner() {
        0.0 => solid.outer(),
        inner => (2.5 * inner).min(solid.outer()),
    }
}

/// The intersection of a face with the facing one, or of two edges, no farther apart than `reach`.
fn common<A: Solid, B: Solid>(
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
            above.points(a, b, place, contact, |origin| origin.feature(true));
        }
        Axis::FaceOfB(face) => {
            let above = Above {
                face,
                normal: place.back(-found.normal),
                slack,
                reach,
            };
            let back = place.inverse();
            above.points(b, a, &back, contact, |origin| origin.feature(false));
            for point in &mut contact.points {
                point.position = place.point(point.position);
            }
        }
        Axis::Edges(of_a, of_b) => {
            let (point, crosses) = crossing(a, b, place, found, of_a, of_b);
            if !crosses && found.distance < 0.0 {
                // All but parallel, they cross anywhere: the faces beside them know more, if they have anything in common.
                faces_along(a, b, place, found.normal, reach, contact);
            }
            if crosses || found.distance < 0.0 && contact.points.is_empty() {
                contact.points.push(point);
            }
        }
        Axis::Unknown => {}
    }
}

/// Above which face of the reference to look, along which normal, how far off what counts as on, and how far, m.
struct Above {
    face: u16,
    normal: DVec3,
    slack: f64,
    reach: f64,
}

impl Above {
    /// The points there, in the frame of the reference. `feature` gives the number of a corner's features.
    fn points<R: Solid, I: Solid>(
        &self,
        reference: &R,
        incident: &I,
        place: &Placement,
        contact: &mut Contact,
        feature: impl Fn(Origin) -> FeatureId,
    ) {
        let below = facing(incident, place.back(-self.normal));
        let below =
            outline(incident, below).map(|(at, point, edge)| (place.point(at), point, edge));
        let sides = outline(reference, self.face);
        let (out, offset) = reference.plane(self.face);
        let slant = 1.0 / out.dot(self.normal);
        let Contact { points, space, .. } = contact;
        for clipped in clip(sides, below, self.normal, self.slack, space) {
            let distance = (out.dot(clipped.at) - offset) * slant;
            let feature = feature(clipped.origin);
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

/// Where two edges are nearest to each other, and whether they cross there and not only the lines that they are on.
fn crossing<A: Solid, B: Solid>(
    a: &A,
    b: &B,
    place: &Placement,
    found: &Separation,
    of_a: u16,
    of_b: u16,
) -> (Point, bool) {
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
    let crosses = on(s, uu.sqrt()) && on(t, vv.sqrt());
    let [s, t] = match crosses {
        true => [s, t],
        false => [s, t].map(|share| share.clamp(0.0, 1.0)),
    };
    let point = Point {
        position: 0.5 * (p + s * u + q + t * v),
        distance: found.distance,
        feature: FeatureId::edges(of_a, of_b),
    };
    (point, crosses)
}
