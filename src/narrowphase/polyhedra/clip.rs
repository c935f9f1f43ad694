//! The intersection of two faces: the incident face, clipped by the sides of the reference face (Sutherland and Hodgman 1974; Ericson 2005,
//! 5.4.2 and 8.3.4).
//!
//! The boundary belongs to a face: corners on edges, edges on edges and corners on corners are inside, with a tolerance far above rounding.
//! Faces that coincide therefore keep all their corners. Each corner of the result knows its features, because each edge knows to which
//! face it belongs.

use super::solid::{Side, Solid};
use crate::pair::FeatureId;
use crate::solver::Both;
use glam::DVec3;
use smallvec::SmallVec;

/// A corner of the intersection of two faces.
#[derive(Clone, Copy, Debug)]
pub struct Clipped {
    /// On the incident face, m, in the frame of the reference.
    pub at: DVec3,
    /// The features that it is made of.
    pub origin: Origin,
}

/// The features of a clipped corner.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// A corner of the reference.
    Reference(u16),
    /// A corner of the incident face.
    Incident(u16),
    /// The crossing of an edge of the reference and an edge of the incident face.
    Edges(u16, u16),
}

impl Origin {
    /// The identity of the features. `by_a`: whether the reference is A.
    pub fn feature(self, by_a: bool) -> FeatureId {
        match (self, by_a) {
            (Self::Reference(i), true) | (Self::Incident(i), false) => FeatureId::corner_of_a(i),
            (Self::Reference(i), false) | (Self::Incident(i), true) => FeatureId::corner_of_b(i),
            (Self::Edges(i, j), true) | (Self::Edges(j, i), false) => FeatureId::edges(i, j),
        }
    }
}

/// The face that an edge belongs to, with its index in the outline of the reference face, or its number among the edges of the incident
/// solid.
#[derive(Clone, Copy, Debug)]
enum Owner {
    Reference(u16),
    Incident(u16),
}

/// A corner of a polygon while it is clipped: its index among all corners, and the edge that follows it. Both are packed into one word,
/// because reading a word that has just been written in parts is slow (it cannot be forwarded from the store buffer).
#[derive(Clone, Copy, Debug)]
struct Link(u32);

impl Link {
    const OF_REFERENCE: u32 = 1 << 15;

    fn new(corner: usize, side: Owner) -> Self {
        let side = match side {
            Owner::Reference(i) => u32::from(i) | Self::OF_REFERENCE,
            Owner::Incident(edge) => u32::from(edge),
        };
        Self((corner as u32) << 16 | side)
    }

    fn corner(self) -> usize {
        (self.0 >> 16) as usize
    }

    fn side(self) -> Owner {
        let number = (self.0 & (Self::OF_REFERENCE - 1)) as u16;
        match self.0 & Self::OF_REFERENCE {
            0 => Owner::Incident(number),
            _ => Owner::Reference(number),
        }
    }
}

/// The corners of a polygon. Polygons with more corners than this are allocated.
type Polygon = SmallVec<[Link; 16]>;

/// Scratch memory for clipping. It is kept between calls because it is large.
#[derive(Clone, Debug, Default)]
pub struct Space {
    /// All corners created so far.
    corners: SmallVec<[Clipped; 24]>,
    polygon: Polygon,
    /// The polygon after the current side has clipped it.
    next: Polygon,
}

/// A face's outline: each corner, with the numbers of the corner and of the edge that follows it.
pub type Outline = SmallVec<[(DVec3, u16, u16); 8]>;

/// The outline of a solid's face in its own frame.
pub fn outline<S: Solid>(solid: &S, face: u16) -> impl ExactSizeIterator<Item = (DVec3, u16, u16)> {
    let corner = |side: Side| (solid.point(side.point), side.point, side.edge);
    solid.outline(face).map(corner)
}

/// A solid stands on all corners of a face if the cosine between the face's normal and the direction is above this.
const WHOLE_FACE_COSINE: f64 = 0.9999;

/// The cosine to a direction above which a face faces it at all.
const FACING_COSINE: f64 = 0.02;

/// Returns the longest of the faces around the farthest corner in a direction (in the solid's own frame) that face it, if there is one.
pub fn longest_facing<S: Solid>(solid: &S, direction: DVec3) -> Option<u16> {
    let farthest = solid.farthest(direction);
    let corner = solid.point(farthest);
    let cosine = |face: u16| solid.plane(face).0.dot(direction);
    // Of faces of one length, that which faces it most.
    let merit = |face: u16| {
        let corners = solid.outline(face).map(|side| solid.point(side.point));
        let lengths = corners.map(|at| at.distance_squared(corner));
        cosine(face) * lengths.fold(0.0, f64::max)
    };
    let facing = solid
        .around(farthest)
        .filter(|&face| cosine(face) > FACING_COSINE);
    facing.max_by(|&a, &b| merit(a).total_cmp(&merit(b)))
}

/// Returns the face with which a solid touches another in a direction (in its own frame). It is the face around the farthest corner whose
/// normal is nearest to the direction. If the solid stands on an edge, it is one of the two faces at that edge; otherwise the contact would
/// be at one end only.
pub fn facing<S: Solid>(solid: &S, direction: DVec3) -> u16 {
    let cosine_of = |face: u16| solid.plane(face).0.dot(direction);
    let farthest = solid.farthest(direction);
    let (mut best, mut most) = (0, f64::NEG_INFINITY);
    for face in solid.around(farthest) {
        let cosine = cosine_of(face);
        if cosine > most {
            (best, most) = (face, cosine);
        }
    }
    if most > WHOLE_FACE_COSINE {
        return best;
    }
    let slack = super::CORNER_SLACK * super::across(solid);
    if solid.stands_on_a_corner(direction, slack) {
        return best;
    }
    let level = direction.dot(solid.point(farthest)) - slack;
    let lowest_corners = |face: u16| {
        let corners = solid.outline(face).map(|side| solid.point(side.point));
        corners.filter(|at| direction.dot(*at) >= level).count()
    };
    let mut count = lowest_corners(best);
    for face in solid.around(farthest) {
        let (own, cosine) = (lowest_corners(face), cosine_of(face));
        if own > count || own == count && cosine > most {
            (best, count, most) = (face, own, cosine);
        }
    }
    best
}

/// Clips the incident outline (in the frame of the reference) to the prism over the reference outline along `normal`.
///
/// `slack` is the distance outside the prism up to which a point counts as inside, m. `space` is scratch, and holds the resulting polygon.
pub fn clip(
    reference: impl IntoIterator<Item = (DVec3, u16, u16)>,
    incident: impl Iterator<Item = (DVec3, u16, u16)>,
    normal: DVec3,
    slack: f64,
    space: &mut Space,
) -> impl Iterator<Item = &Clipped> {
    space.begin();
    for corner in incident {
        space.add(corner);
    }
    let mut sides = reference.into_iter();
    let first = sides.next().unwrap_or_default();
    let (mut from, mut next_from) = (first, sides.next());
    for i in 0.. {
        let (is_last, to) = (next_from.is_none(), next_from.unwrap_or(first));
        let side = ClippingSide {
            i,
            ends: [from, to],
            is_last,
        };
        space.clip(&side, normal, slack);
        if is_last || space.polygon.is_empty() {
            break;
        }
        (from, next_from) = (to, sides.next());
    }
    drop_duplicates(&mut space.polygon, &space.corners, slack);
    let Space {
        corners, polygon, ..
    } = space;
    polygon.iter().map(|link| &corners[link.corner()])
}

/// A side of the reference outline.
struct ClippingSide {
    /// Its index in the outline.
    i: u16,
    /// Its two corners: position, number, and number of the edge that follows.
    ends: [(DVec3, u16, u16); 2],
    is_last: bool,
}

impl ClippingSide {
    /// The features of the corner between this side and another edge. The last side meets the first side at the first corner.
    fn meeting(&self, other: Owner) -> Origin {
        let [from, to] = &self.ends;
        match other {
            Owner::Incident(edge) => Origin::Edges(from.2, edge),
            Owner::Reference(0) if self.is_last => Origin::Reference(to.1),
            Owner::Reference(_) => Origin::Reference(from.1),
        }
    }
}

impl Space {
    fn begin(&mut self) {
        self.corners.clear();
        self.polygon.clear();
    }

    /// Adds a corner of the incident face: position, number, and number of the edge that follows.
    fn add(&mut self, (at, point, edge): (DVec3, u16, u16)) {
        self.polygon
            .push(Link::new(self.corners.len(), Owner::Incident(edge)));
        self.corners.push(Clipped {
            at,
            origin: Origin::Incident(point),
        });
    }

    /// Clips the polygon by one side.
    fn clip(&mut self, side: &ClippingSide, normal: DVec3, slack: f64) {
        let Self {
            corners,
            polygon,
            next,
        } = self;
        let [from, to] = side.ends.both(|end| end.0);
        // Its length is that of the side, so depths and slack are multiplied by that length, too.
        let inward = normal.cross(to - from);
        let start = inward.dot(from);
        let slack = slack * inward.length();
        let depth = |at: DVec3| inward.dot(at) - start;
        // Most sides clip nothing.
        if !polygon
            .iter()
            .any(|link| depth(corners[link.corner()].at) < -slack)
        {
            return;
        }
        let own = Owner::Reference(side.i);
        next.clear();
        let Some(&last) = polygon.last() else {
            return;
        };
        let (mut link, mut here) = (last, depth(corners[last.corner()].at));
        for &after in polygon.iter() {
            let there = depth(corners[after.corner()].at);
            let mut cross = |owner| {
                let [from, to] = [link, after].both(|link| corners[link.corner()].at);
                corners.push(Clipped {
                    at: from.lerp(to, here / (here - there)),
                    origin: side.meeting(link.side()),
                });
                Link::new(corners.len() - 1, owner)
            };
            match (here >= -slack, there >= -slack) {
                (true, true) => next.push(link),
                (true, false) if here > slack => {
                    next.push(link);
                    next.push(cross(own));
                }
                (true, false) => next.push(Link::new(link.corner(), own)),
                (false, true) if there > slack => next.push(cross(link.side())),
                (false, _) => {}
            }
            (link, here) = (after, there);
        }
        std::mem::swap(polygon, next);
    }
}

/// Removes corners that coincide with the next corner. Corners of a face are kept in preference to crossings of edges.
fn drop_duplicates(polygon: &mut Polygon, corners: &[Clipped], slack: f64) {
    let mut i = 0;
    while i < polygon.len() && polygon.len() > 1 {
        let next = if i + 1 < polygon.len() { i + 1 } else { 0 };
        let [one, other] = [i, next].both(|i| &corners[polygon[i].corner()]);
        if one.at.distance_squared(other.at) > slack * slack {
            i += 1;
        } else if matches!(one.origin, Origin::Edges(..)) {
            polygon.remove(i);
        } else {
            polygon.remove(next);
        }
    }
}
