//! Along which direction two convex polyhedra are farthest apart, or overlap least: the separating axis.
//!
//! Such a direction is the normal of a face of one, or square to an edge of each, and then only of edges whose arcs cross on the
//! sphere of normals: the normals with which A is supported by its edge are the arc between the normals of the edge's two faces,
//! and B's, turned round, must hold the same direction (Gregorius, GDC 2013). All other pairs of edges need not be looked at.
//!
//! Nor need what cannot win: no direction parts the bodies further than it parts A from a ball inside B. With that a few faces
//! and edges near the contact are left of however many there are.
//!
//! Faces win over edges by a margin far below what matters and far above rounding: where faces coincide the crossed edges of the same
//! faces are as far apart, and say less. Of two faces turned a little against each other some pair of edges is often farther apart,
//! along a direction between their normals: where an arch settles, its joints would have one point now and four then. So edges that look where the best face looks must win by more, and anything must that
//! shall win over the axis of the last time.

use super::cuboid;
use super::placement::Placement;
use super::solid::Solid;
use crate::contact::cache::Axis;
use glam::DVec3;
use smallvec::SmallVec;

/// By what faces win, as a share of the smaller solid's radius.
const MARGIN: f64 = 5e-6;

/// As near to a face's normal as this, as a cosine, that of two edges says the same (5°) …
const ALIKE: f64 = 0.996;

/// … unless they are farther apart by this share of the smaller solid's radius.
const MORE: f64 = 2e-3;

/// The axis of the last time is kept as long as another is not better by this share of the smaller solid's radius. What rocks on an
/// edge would otherwise meet now the face beside it and now the edge, and never come to rest: of six piles of 300 splinters two slept.
const STEADY: f64 = 0.005;

/// The sine of the angle below which two edges are parallel: the faces beside them know as much.
const PARALLEL: f64 = 1e-7;

/// Single precision tells a direction in a plane from one beside it by no less than this sine, squared: a hull's normals.
const ROUNDING: f64 = 4e-14;

/// How far edges may be behind other corners along their normal, as a share of the smaller solid's radius.
const BEHIND: f64 = 1e-7;

/// A direction, and how far the two are apart along it.
#[derive(Clone, Copy, Debug)]
pub struct Separation {
    /// The features that define the direction.
    pub axis: Axis,
    /// Unit vector from A to B, in the frame of A.
    pub normal: DVec3,
    /// m; negative: they overlap by as much.
    pub distance: f64,
}

/// The axis to try first, and the one to try if that gives too small an overlap.
#[derive(Clone, Copy, Debug)]
pub struct Separations {
    /// The greatest, or one that is preferred to it.
    pub best: Separation,
    /// The greatest, where another is preferred.
    pub beside: Option<Separation>,
}

impl From<Separation> for Separations {
    fn from(best: Separation) -> Self {
        Self { best, beside: None }
    }
}

/// The greatest separation; any that is beyond `reach` (m), if there is one. `last`: the axis of the last time.
pub fn separate<A: Solid, B: Solid>(
    a: &A,
    b: &B,
    place: &Placement,
    reach: f64,
    last: Axis,
) -> Separations {
    let back = place.inverse();
    let last = along(a, b, place, &back, last);
    if let Some(last) = last
        && last.distance > reach
    {
        return last.into();
    }
    let size = a.outer().min(b.outer());
    let face = best_face(a, b, place, &back, reach, last, MARGIN * size);
    if face.distance > reach {
        return face.into();
    }
    let edges = match (a.half(), b.half()) {
        (Some(half_a), Some(half_b)) => box_edges(half_a, half_b, place, face.distance),
        _ => best_edges(a, b, place, face.distance),
    };
    let best = edges.unwrap_or(face);
    if best.distance > reach {
        return best.into();
    }
    let alike = face.normal.dot(best.normal) > ALIKE;
    let more = if alike { MORE } else { MARGIN };
    let preferred = match last {
        Some(last) if last.distance + STEADY * size >= best.distance => last,
        _ if face.distance + more * size >= best.distance => face,
        _ => best,
    };
    Separations {
        best: preferred,
        beside: (preferred.axis != best.axis).then_some(best),
    }
}

/// The separation along an axis that is known; none where edges no longer face each other.
fn along<A: Solid, B: Solid>(
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
            distance: outside(a, b, place, face),
        }),
        Axis::FaceOfB(face) if face < b.faces() => Some(Separation {
            axis,
            normal: -place.direction(b.plane(face).0),
            distance: outside(b, a, back, face),
        }),
        Axis::Edges(of_a, of_b) if of_a < a.edges() && of_b < b.edges() => {
            let (one, two) = (Arc::of(a, of_a), Arc::of(b, of_b).turned_round(place));
            let (normal, _) = one.crosses(&two)?;
            let distance = between(a, b, place, normal);
            Some(Separation {
                axis,
                normal,
                distance,
            })
        }
        _ => None,
    }
}

/// How far B is from A along a direction, m, whatever is farthest there. Where edges are all but parallel, rounding says on which
/// side of an arc a normal is, and theirs may be any that is square to them: before it counts it is asked for here.
fn between<A: Solid, B: Solid>(a: &A, b: &B, place: &Placement, normal: DVec3) -> f64 {
    normal.dot(place.origin) - b.reach(-place.back(normal)) - a.reach(normal)
}

/// How far B is outside the plane of a face of A, m.
fn outside<A: Solid, B: Solid>(a: &A, b: &B, place: &Placement, face: u16) -> f64 {
    let (normal, offset) = a.plane(face);
    normal.dot(place.origin) - b.reach(-place.back(normal)) - offset
}

/// The face of either that the other is farthest outside of; any beyond `reach`. Of two that are as good within `margin`, the last
/// one, or else A's.
fn best_face<A: Solid, B: Solid>(
    a: &A,
    b: &B,
    place: &Placement,
    back: &Placement,
    reach: f64,
    last: Option<Separation>,
    margin: f64,
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
        None => farther_face(a, b, place, floor, reach),
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
        None => farther_face(b, a, back, floor, reach),
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

/// The face of A that B is farthest outside of, if that is farther than `floor`; any beyond `reach`.
fn farther_face<A: Solid, B: Solid>(
    a: &A,
    b: &B,
    place: &Placement,
    mut floor: f64,
    reach: f64,
) -> Option<(u16, f64)> {
    let (center, inner) = (place.point(b.center()), b.inner());
    // No point of B's ball is farther outside, so neither is all of B.
    let bound = |face: u16| {
        let (normal, offset) = a.plane(face);
        normal.dot(center) - offset - inner
    };
    let mut best = None;
    let mut improve = |face: u16, floor: &mut f64| {
        let distance = outside(a, b, place, face);
        if distance > *floor {
            (*floor, best) = (distance, Some((face, distance)));
        }
    };
    // Where nothing is known, the likeliest first: it spares the most others.
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

/// The same of two boxes: of each two opposite faces it is the one that B's middle is on the side of.
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
        let [from, to] = ridge.ends.map(|i| solid.point(i));
        Self {
            edge,
            on: from,
            along: to - from,
            normals: ridge.faces.map(|face| solid.plane(face).0),
        }
    }

    /// Of B, in the frame of A, with the normals that A would need to face it.
    fn turned_round(self, place: &Placement) -> Self {
        Self {
            edge: self.edge,
            on: place.point(self.on),
            along: place.direction(self.along),
            normals: self.normals.map(|normal| -place.direction(normal)),
        }
    }

    /// Upper bound of `normal · way` over the normals of the arc.
    fn most(&self, way: DVec3) -> f64 {
        let [x, y] = self.normals.map(|normal| normal.dot(way));
        let cos = self.normals[0].dot(self.normals[1]);
        if y > cos * x && x > cos * y && cos.abs() < 1.0 {
            // Steepest between the two.
            ((x * x + y * y - 2.0 * cos * x * y) / (1.0 - cos * cos)).sqrt()
        } else {
            x.max(y)
        }
    }

    /// Where the arcs cross, and how far the second edge is from the first in that direction.
    fn crosses(&self, other: &Self) -> Option<(DVec3, f64)> {
        let [a, b] = self.normals;
        let [c, d] = other.normals;
        // On either side of the other's great circle, both ways, and on the same half of the sphere. What is on the circle but for
        // rounding may be on either side.
        let [c_side, d_side] = [c, d].map(|normal| normal.dot(self.along));
        if c_side * d_side >= ROUNDING * self.along.length_squared() {
            return None;
        }
        let [a_side, b_side] = [a, b].map(|normal| normal.dot(other.along));
        if a_side * b_side >= ROUNDING * other.along.length_squared() {
            return None;
        }
        let across = self.along.cross(other.along);
        let length = across.length();
        if length <= PARALLEL * self.along.length() * other.along.length() {
            return None;
        }
        let normal = across * ((a + b).dot(across).signum() / length);
        ((c + d).dot(normal) > 0.0).then(|| (normal, normal.dot(other.on - self.on)))
    }
}

/// The edges of solids of which so many can win are kept in place.
type Arcs = SmallVec<[Arc; 32]>;

/// The two edges along whose cross product the solids are farthest apart, if that is farther than `floor`.
fn best_edges<A: Solid, B: Solid>(
    a: &A,
    b: &B,
    place: &Placement,
    mut floor: f64,
) -> Option<Separation> {
    let behind = BEHIND * a.outer().min(b.outer());
    let (center_a, center_b) = (
        place.back(a.center() - place.origin),
        place.point(b.center()),
    );
    let mut of_b = Arcs::new();
    for edge in 0..b.edges() {
        let arc = Arc::of(b, edge);
        if arc.most(center_a - arc.on) - a.inner() > floor {
            of_b.push(arc.turned_round(place));
        }
    }
    let mut best = None;
    for edge in 0..a.edges() {
        let arc = Arc::of(a, edge);
        if arc.most(center_b - arc.on) - b.inner() <= floor {
            continue;
        }
        for other in &of_b {
            if let Some((normal, own)) = arc.crosses(other)
                && own > floor
                && let distance = between(a, b, place, normal)
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
    }
    best
}

/// The same of two boxes: of each three directions of edges there are nine cross products, and signs say which edges they are.
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
            // Axis i of A × axis j of B has no part along axis i, and along the axes of B by the same rule.
            let (m, n) = (next[i], next[next[i]]);
            let (along_m, along_n) = (-turn[j][n], turn[j][m]);
            let square = along_m * along_m + along_n * along_n;
            let center = along_m * origin[m] + along_n * origin[n];
            let of_a = along_m.abs() * half_a[m] + along_n.abs() * half_a[n];
            let of_b = turn[l][i].abs() * half_b[k] + turn[k][i].abs() * half_b[l];
            let apart = center.abs() - of_a - of_b;
            // Without a root for most: apart / √square > floor.
            if apart * apart.abs() > floor * floor.abs() * square && square > PARALLEL * PARALLEL {
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
