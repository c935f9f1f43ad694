//! Finds the separating axis of two convex polyhedra: the direction along which they are farthest apart, or overlap least.
//!
//! The axis is the normal of a face, or perpendicular to one edge of each solid. An edge supports its solid in the directions on the arc
//! between the normals of its two faces. Only pairs of edges are candidates for which the arc of A crosses the reversed arc of B on the
//! sphere of directions (Gregorius, GDC 2013).
//!
//! A candidate is skipped if it cannot be the best: the distance along a direction is at most the distance between A and a ball inside B.
//! This leaves a few faces and edges near the contact, however many the solids have.
//!
//! Faces are preferred to edges by a margin far below any relevant length and far above rounding: if faces coincide, the crossed edges of
//! the same faces are equally far apart, and give only one point. If two faces are rotated slightly against each other, a pair of edges is
//! often farther apart along a direction between their normals. The joints of a settling arch would then alternate between one point and
//! four. Therefore the margin is larger for edges whose direction is near that of the best face, and any other axis must be better than the
//! last axis by a margin.

use super::cuboid;
use super::placement::Placement;
use super::solid::Solid;
use crate::pair::cache::Axis;
use crate::solver::Both;
use glam::DVec3;
use smallvec::SmallVec;

/// Margin by which faces are preferred to edges, as a share of the smaller solid's radius.
const FACE_MARGIN: f64 = 5e-6;

/// The direction of two edges is similar to a face's normal if the cosine between them is above this (5°). Then …
const SIMILAR_COSINE: f64 = 0.996;

/// … this is the margin by which the face is preferred, as a share of the smaller solid's radius.
const SIMILAR_FACE_MARGIN: f64 = 2e-3;

/// The axis of the last step is kept unless another is better by this share of the smaller solid's radius. Without it, a body that rocks on
/// an edge alternates between the adjacent face and the edge, and never comes to rest: of six piles of 300 splinters only two fell asleep.
const LAST_AXIS_MARGIN: f64 = 0.005;

/// Two edges are parallel if the sine of the angle between them is below this. Their cross product gives no more than the adjacent faces
/// do.
const PARALLEL_SINE: f64 = 1e-7;

/// The rounding error of a hull's normals in single precision, as the square of the sine of an angle.
const NORMAL_ROUNDING: f64 = 4e-14;

/// Tolerance for other corners that are farther along the normal than the edges, as a share of the smaller solid's radius.
const CORNER_TOLERANCE: f64 = 1e-7;

/// A direction, and the distance of two solids along it.
#[derive(Clone, Copy, Debug)]
pub struct Separation {
    /// The features that define the direction.
    pub axis: Axis,
    /// Unit vector from A to B, in the frame of A.
    pub normal: DVec3,
    /// Distance along it, m. Negative: overlap.
    pub distance: f64,
}

/// The axis to use, and an alternative if the contact along it has too little overlap.
#[derive(Clone, Copy, Debug)]
pub struct Separations {
    /// The axis with the greatest distance, or one that is preferred to it.
    pub best: Separation,
    /// The axis with the greatest distance, if another is preferred.
    pub beside: Option<Separation>,
}

impl From<Separation> for Separations {
    fn from(best: Separation) -> Self {
        Self { best, beside: None }
    }
}

/// Returns the axis with the greatest distance. If there is an axis along which the distance is greater than `reach` (m), returns any such
/// axis. `last` is the axis of the last step.
pub fn separate<A: Solid, B: Solid>(
    a: &A,
    b: &B,
    place: &Placement,
    reach: f64,
    last: Axis,
) -> Separations {
    let back = place.inverse();
    let last = known_separation(a, b, place, &back, last);
    if let Some(last) = last
        && last.distance > reach
    {
        return last.into();
    }
    let size = a.outer().min(b.outer());
    let mut heights = [Heights::new(), Heights::new()];
    let limits = (reach, FACE_MARGIN * size);
    let face = best_face(a, b, place, &back, limits, last, &mut heights);
    if face.distance > reach {
        return face.into();
    }
    let edges = match (a.half(), b.half()) {
        (Some(half_a), Some(half_b)) => box_edges(half_a, half_b, place, face.distance),
        _ => best_edges(a, b, place, face.distance, &heights),
    };
    let best = edges.unwrap_or(face);
    if best.distance > reach {
        return best.into();
    }
    let alike = face.normal.dot(best.normal) > SIMILAR_COSINE;
    let more = if alike {
        SIMILAR_FACE_MARGIN
    } else {
        FACE_MARGIN
    };
    let preferred = match last {
        Some(last) if last.distance + LAST_AXIS_MARGIN * size >= best.distance => last,
        _ if face.distance + more * size >= best.distance => face,
        _ => best,
    };
    Separations {
        best: preferred,
        beside: (preferred.axis != best.axis).then_some(best),
    }
}

/// Computes the distance along the axis of the last step. Returns `None` if its edges no longer face each other.
fn known_separation<A: Solid, B: Solid>(
    a: &A,
    b: &B,
    place: &Placement,
    back: &Placement,
    axis: Axis,
) -> Option<Separation> {
    match axis {
        Axis::FaceOfA(face) if face < a.faces() => Some(Separation {
            axis,
            normal: a.plane(face).0,
            distance: distance_from_face(a, b, place, face),
        }),
        Axis::FaceOfB(face) if face < b.faces() => Some(Separation {
            axis,
            normal: -place.direction(b.plane(face).0),
            distance: distance_from_face(b, a, back, face),
        }),
        Axis::Edges(of_a, of_b) if of_a < a.edges() && of_b < b.edges() => {
            let (one, two) = (Arc::of(a, of_a), Arc::of(b, of_b).reversed(place));
            let (normal, _) = one.crosses(&two)?;
            let distance = distance_along(a, b, place, normal);
            Some(Separation {
                axis,
                normal,
                distance,
            })
        }
        _ => None,
    }
}

/// The distance of B from A along a direction, m, over all corners. If two edges are almost parallel, rounding decides whether their arcs
/// cross, and their normal may be any direction perpendicular to them. So the distance along it is computed from all corners.
fn distance_along<A: Solid, B: Solid>(a: &A, b: &B, place: &Placement, normal: DVec3) -> f64 {
    normal.dot(place.origin) - b.reach(-place.back(normal)) - a.reach(normal)
}

/// The distance of B from the plane of a face of A, m. Negative if some part of B is below it.
fn distance_from_face<A: Solid, B: Solid>(a: &A, b: &B, place: &Placement, face: u16) -> f64 {
    let (normal, offset) = a.plane(face);
    normal.dot(place.origin) - b.reach(-place.back(normal)) - offset
}

/// The normal of each face of a solid, and the height of the other solid's centre above the face, m. More than this are allocated.
type Heights = SmallVec<[(DVec3, f64); 64]>;

/// Measures the heights of a point above all faces of a solid.
fn measure<S: Solid>(solid: &S, at: DVec3, heights: &mut Heights) {
    for face in 0..solid.faces() {
        let (normal, offset) = solid.plane(face);
        heights.push((normal, normal.dot(at) - offset));
    }
}

/// Returns the face of either solid from which the other is farthest. If some face is farther than `reach`, returns any such face. Within
/// `margin`, the face of the last step is preferred, and then those of A. Measures `heights`, which are empty, unless both are boxes.
fn best_face<A: Solid, B: Solid>(
    a: &A,
    b: &B,
    place: &Placement,
    back: &Placement,
    (reach, margin): (f64, f64),
    last: Option<Separation>,
    [heights_a, heights_b]: &mut [Heights; 2],
) -> Separation {
    let is_face = |last: &Separation| !matches!(last.axis, Axis::Edges(..));
    let mut best = last.filter(is_face).unwrap_or(Separation {
        axis: Axis::Unknown,
        normal: DVec3::Y,
        distance: f64::NEG_INFINITY,
    });
    let halves = a.half().zip(b.half());
    let floor = best.distance + margin;
    let of_a = match halves {
        Some((half_a, half_b)) => farther_side(half_a, half_b, place, floor),
        None => {
            measure(a, place.point(b.center()), heights_a);
            farther_face(a, b, place, heights_a, floor, reach)
        }
    };
    if let Some((face, distance)) = of_a {
        best = Separation {
            axis: Axis::FaceOfA(face),
            normal: a.plane(face).0,
            distance,
        };
    }
    if best.distance > reach {
        return best;
    }
    let floor = best.distance + margin;
    let of_b = match halves {
        Some((half_a, half_b)) => farther_side(half_b, half_a, back, floor),
        None => {
            measure(b, back.point(a.center()), heights_b);
            farther_face(b, a, back, heights_b, floor, reach)
        }
    };
    if let Some((face, distance)) = of_b {
        best = Separation {
            axis: Axis::FaceOfB(face),
            normal: -place.direction(b.plane(face).0),
            distance,
        };
    }
    best
}

/// Returns the face of A from which B is farthest, if that is farther than `floor`. If some face is farther than `reach`, returns any such
/// face.
fn farther_face<A: Solid, B: Solid>(
    a: &A,
    b: &B,
    place: &Placement,
    heights: &[(DVec3, f64)],
    mut floor: f64,
    reach: f64,
) -> Option<(u16, f64)> {
    let inner = b.inner();
    // Upper bound: the distance of a ball inside B.
    let bound = |face: u16| heights[face as usize].1 - inner;
    let mut best = None;
    let mut improve = |face: u16, floor: &mut f64| {
        let distance = distance_from_face(a, b, place, face);
        if distance > *floor {
            (*floor, best) = (distance, Some((face, distance)));
        }
    };
    // Without a known distance, begin with the face that has the highest bound, so that most others are skipped.
    let mut first = None;
    if floor == f64::NEG_INFINITY {
        let bounds = (0..a.faces()).map(|face| (bound(face), face));
        first = bounds
            .max_by(|x, y| x.0.total_cmp(&y.0))
            .map(|(_, face)| face);
    }
    if let Some(first) = first {
        improve(first, &mut floor);
    }
    for face in 0..a.faces() {
        if floor > reach {
            break;
        }
        if bound(face) > floor && Some(face) != first {
            improve(face, &mut floor);
        }
    }
    best
}

/// The same for two boxes. Of two opposite faces, only the one on the side of B's centre is a candidate.
fn farther_side(
    half_a: DVec3,
    half_b: DVec3,
    place: &Placement,
    mut floor: f64,
) -> Option<(u16, f64)> {
    let [x, y, z] = place.axes();
    let (x, y, z) = (x.abs(), y.abs(), z.abs());
    let of_b = x * half_b.x + y * half_b.y + z * half_b.z;
    let distances = place.origin.abs() - half_a - of_b;
    let mut best = None;
    for axis in 0..3 {
        let distance = distances[axis];
        if distance > floor {
            let face = 2 * axis as u16 + (place.origin[axis] > 0.0) as u16;
            (floor, best) = (distance, Some((face, distance)));
        }
    }
    best
}

/// An edge, and the normals of its two faces.
#[derive(Clone, Copy)]
struct Arc {
    edge: u16,
    on: DVec3,
    along: DVec3,
    normals: [DVec3; 2],
}

impl Arc {
    fn of<S: Solid>(solid: &S, edge: u16) -> Self {
        let ridge = solid.edge(edge);
        let ends = ridge.ends.both(|i| solid.point(i));
        Self::new(edge, ends, ridge.faces.both(|face| solid.plane(face).0))
    }

    fn new(edge: u16, [from, to]: [DVec3; 2], normals: [DVec3; 2]) -> Self {
        Self {
            edge,
            on: from,
            along: to - from,
            normals,
        }
    }

    /// Transforms an edge of B to the frame of A, and reverses its normals, so that they are the directions from A to B.
    fn reversed(self, place: &Placement) -> Self {
        Self {
            edge: self.edge,
            on: place.point(self.on),
            along: place.direction(self.along),
            normals: self.normals.both(|normal| -place.direction(normal)),
        }
    }

    /// Returns the direction in which the arcs cross, and the distance of the second edge from the first along it.
    fn crosses(&self, other: &Self) -> Option<(DVec3, f64)> {
        let [a, b] = self.normals;
        let [c, d] = other.normals;
        // Two arcs cross if the ends of each are on different sides of the other's great circle, and both arcs are on the same half of the
        // sphere. An end on the circle, up to rounding, counts as on either side.
        let [c_side, d_side] = [c, d].both(|normal| normal.dot(self.along));
        if c_side * d_side >= NORMAL_ROUNDING * self.along.length_squared() {
            return None;
        }
        let [a_side, b_side] = [a, b].both(|normal| normal.dot(other.along));
        if a_side * b_side >= NORMAL_ROUNDING * other.along.length_squared() {
            return None;
        }
        let across = self.along.cross(other.along);
        let length = across.length();
        if length <= PARALLEL_SINE * self.along.length() * other.along.length() {
            return None;
        }
        let normal = across * ((a + b).dot(across).signum() / length);
        ((c + d).dot(normal) > 0.0).then(|| (normal, normal.dot(other.on - self.on)))
    }
}

/// Edges that are candidates. More than this are allocated.
type Arcs = SmallVec<[Arc; 32]>;

/// Returns the two edges along whose cross product the solids are farthest apart, if that is farther than `floor`. `heights` are those of
/// each one's centre above the faces of the other.
fn best_edges<A: Solid, B: Solid>(
    a: &A,
    b: &B,
    place: &Placement,
    mut floor: f64,
    [heights_a, heights_b]: &[Heights; 2],
) -> Option<Separation> {
    let behind = CORNER_TOLERANCE * a.outer().min(b.outer());
    let mut of_b = Arcs::new();
    towards(b, heights_b, floor + a.inner(), |arc| {
        of_b.push(arc.reversed(place));
    });
    let mut best = None;
    towards(a, heights_a, floor + b.inner(), |arc| {
        for other in &of_b {
            if let Some((normal, own)) = arc.crosses(other)
                && own > floor
                && let distance = distance_along(a, b, place, normal)
                && distance > floor
                && own - distance <= behind
            {
                floor = distance;
                best = Some(Separation {
                    axis: Axis::Edges(arc.edge, other.edge),
                    normal,
                    distance,
                });
            }
        }
    });
    best
}

/// Visits the edges of a solid along whose arcs a point is, or may be, higher than `least`, m.
///
/// An edge lies in the planes of its two faces. So the heights of the point above the faces, each of which has several edges, are those
/// above the edge along the two ends of its arc.
fn towards<S: Solid>(solid: &S, heights: &[(DVec3, f64)], least: f64, mut visit: impl FnMut(Arc)) {
    let (below, square) = (least.min(0.0), least * least);
    for edge in 0..solid.edges() {
        let ridge = solid.edge(edge);
        let [(one, x), (other, y)] = ridge.faces.both(|face| heights[face as usize]);
        // Where both faces look away from the point, so does all between them.
        if x <= below && y <= below {
            continue;
        }
        let cos = one.dot(other);
        let is_between = y > cos * x && x > cos * y && cos.abs() < 1.0;
        // Between the two it is √(x² + y² − 2xy cos) / sin.
        let is_high = match is_between {
            true => least < 0.0 || x * x + y * y - 2.0 * cos * x * y > square * (1.0 - cos * cos),
            false => x > least || y > least,
        };
        if is_high {
            let ends = ridge.ends.both(|i| solid.point(i));
            visit(Arc::new(edge, ends, [one, other]));
        }
    }
}

/// The same for two boxes. Their edges have three directions each, so there are nine cross products. The signs of the normal give the
/// edges.
fn box_edges(
    half_a: DVec3,
    half_b: DVec3,
    place: &Placement,
    mut floor: f64,
) -> Option<Separation> {
    // turn[j][i]: axis j of B along axis i of A.
    let [x, y, z] = place.axes();
    let turn = [x.to_array(), y.to_array(), z.to_array()];
    let (origin, half_a, half_b) = (
        place.origin.to_array(),
        half_a.to_array(),
        half_b.to_array(),
    );
    let next = [1, 2, 0];
    let mut best = None;
    for j in 0..3 {
        let (k, l) = (next[j], next[next[j]]);
        for i in 0..3 {
            // Axis i of A × axis j of B has no component along axis i of A, and none along axis j of B.
            let (m, n) = (next[i], next[next[i]]);
            let (along_m, along_n) = (-turn[j][n], turn[j][m]);
            let square = along_m * along_m + along_n * along_n;
            let center = along_m * origin[m] + along_n * origin[n];
            let of_a = along_m.abs() * half_a[m] + along_n.abs() * half_a[n];
            let of_b = turn[l][i].abs() * half_b[k] + turn[k][i].abs() * half_b[l];
            let apart = center.abs() - of_a - of_b;
            // This is apart / √square > floor, without a square root.
            if apart * apart.abs() > floor * floor.abs() * square
                && square > PARALLEL_SINE * PARALLEL_SINE
            {
                floor = apart / square.sqrt();
                best = Some((i, j, center.signum()));
            }
        }
    }
    let (i, j, side) = best?;
    let normal = side * DVec3::AXES[i].cross(place.axes()[j]).normalize();
    let corner = |direction: DVec3| {
        (0..3).fold(0u16, |corner, k| {
            corner | ((direction[k] > 0.0) as u16) << k
        })
    };
    Some(Separation {
        axis: Axis::Edges(
            cuboid::edge_at(i as u16, corner(normal)),
            cuboid::edge_at(j as u16, corner(place.back(-normal))),
        ),
        normal,
        distance: floor,
    })
}
