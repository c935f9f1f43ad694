//! What two faces have in common: that of one, the incident, clipped by the sides of the other, the reference (Sutherland and
//! Hodgman 1974; Ericson 2005, 5.4.2 and 8.3.4).
//!
//! What lies on the border belongs to it: corners on edges, edges on edges and corners on corners are inside within a slack that is
//! far above rounding. So faces that coincide keep all their corners, whichever way rounding turns them. Each corner of the
//! result knows which features it is made of, since each edge on the way knows whose it is.

use super::placement::Placement;
use super::solid::Solid;
use glam::DVec3;
use smallvec::SmallVec;

/// A corner of what two faces have in common.
#[derive(Clone, Copy, Debug)]
pub struct Clipped {
    /// On the incident face, m, in the frame of the reference.
    pub at: DVec3,
    /// What it is.
    pub origin: Origin,
    /// Whose edge leads on from here.
    side: Owner,
}

/// What a clipped corner is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// A corner of the reference.
    Reference(u16),
    /// A corner of the incident face.
    Incident(u16),
    /// Where an edge of the reference and one of the incident face cross.
    Edges(u16, u16),
}

/// Whose an edge is: of the reference by its place in the outline, of the incident by its number.
#[derive(Clone, Copy, Debug)]
enum Owner {
    Reference(usize),
    Incident(u16),
}

/// Faces of more corners than this leave the stack.
pub type Polygon = SmallVec<[Clipped; 16]>;

/// A face's outline: each corner, and the numbers of the corner and of the edge that leads on.
pub type Outline = SmallVec<[(DVec3, u16, u16); 8]>;

/// The outline of a solid's face in its own frame.
pub fn outline<S: Solid>(solid: &S, face: u16) -> Outline {
    solid
        .outline(face)
        .map(|side| (solid.point(side.point), side.point, side.edge))
        .collect()
}

/// The face by which a solid meets another that it lies on in a direction (of its own frame): of those around its farthest corner
/// the one that looks there most.
pub fn facing<S: Solid>(solid: &S, direction: DVec3) -> u16 {
    let looks = |face: &u16| solid.plane(*face).0.dot(direction);
    solid
        .around(solid.farthest(direction))
        .max_by(|x, y| looks(x).total_cmp(&looks(y)))
        .unwrap_or_default()
}

/// The part of the incident outline (placed in the frame of the reference) inside the prism over the reference outline along `normal`.
/// `slack`: how far outside still is inside, m.
pub fn clip(
    reference: &Outline,
    incident: &Outline,
    place: &Placement,
    normal: DVec3,
    slack: f64,
) -> Polygon {
    let mut polygon: Polygon = incident
        .iter()
        .map(|&(at, point, edge)| Clipped {
            at: place.point(at),
            origin: Origin::Incident(point),
            side: Owner::Incident(edge),
        })
        .collect();
    let mut next = Polygon::new();
    let count = reference.len();
    for (i, &(from, ..)) in reference.iter().enumerate() {
        let to = reference[(i + 1) % count].0;
        let Some(inward) = normal.cross(to - from).try_normalize() else {
            continue;
        };
        let depth = |corner: &Clipped| inward.dot(corner.at - from);
        next.clear();
        for (k, corner) in polygon.iter().enumerate() {
            let after = &polygon[(k + 1) % polygon.len()];
            let (here, there) = (depth(corner), depth(after));
            let crossing = |side| Clipped {
                at: corner.at.lerp(after.at, here / (here - there)),
                origin: meeting(reference, i, corner.side),
                side,
            };
            match (here >= -slack, there >= -slack) {
                (true, true) => next.push(*corner),
                (true, false) if here > slack => {
                    next.push(*corner);
                    next.push(crossing(Owner::Reference(i)));
                }
                (true, false) => next.push(Clipped {
                    side: Owner::Reference(i),
                    ..*corner
                }),
                (false, true) if there > slack => next.push(crossing(corner.side)),
                (false, _) => {}
            }
        }
        std::mem::swap(&mut polygon, &mut next);
    }
    drop_doubles(&mut polygon, slack);
    polygon
}

/// Where the reference's side `i` meets another edge.
fn meeting(reference: &Outline, i: usize, other: Owner) -> Origin {
    let count = reference.len();
    match other {
        Owner::Incident(edge) => Origin::Edges(reference[i].2, edge),
        Owner::Reference(j) if (i + 1) % count == j => Origin::Reference(reference[j].1),
        Owner::Reference(_) => Origin::Reference(reference[i].1),
    }
}

/// Of corners in one place the first stays, a true corner rather than a crossing.
fn drop_doubles(polygon: &mut Polygon, slack: f64) {
    let mut kept = Polygon::new();
    let same = |x: &Clipped, y: &Clipped| x.at.distance_squared(y.at) <= slack * slack;
    let is_crossing = |corner: &Clipped| matches!(corner.origin, Origin::Edges(..));
    for corner in polygon.iter() {
        match kept.iter_mut().find(|k| same(k, corner)) {
            Some(double) if is_crossing(double) && !is_crossing(corner) => *double = *corner,
            Some(_) => {}
            None => kept.push(*corner),
        }
    }
    *polygon = kept;
}
