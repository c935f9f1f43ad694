//! The interface of a convex polyhedron for collision detection: corners, faces, edges and extents.
//!
//! All values are in the solid's own frame, in m, and in double precision. In scalar code double precision costs no more than single, and
//! all digits matter if faces and edges coincide.

use glam::DVec3;

/// A convex polyhedron.
pub trait Solid {
    /// A point inside.
    fn center(&self) -> DVec3;
    /// Radius of a ball around the centre that lies inside.
    fn inner(&self) -> f64;
    /// Radius of a ball around the centre that contains the solid.
    fn outer(&self) -> f64;

    /// Corner `i`.
    fn point(&self, i: u16) -> DVec3;
    /// The support function: the maximum of `direction · x` over the solid.
    fn reach(&self, direction: DVec3) -> f64;
    /// The corner that is farthest in a direction.
    fn farthest(&self, direction: DVec3) -> u16;

    /// The number of faces.
    fn faces(&self) -> u16;
    /// The outward unit normal of a face, and `normal · x` for the points x of its plane.
    fn plane(&self, face: u16) -> (DVec3, f64);
    /// The outline of a face, counterclockwise seen from outside.
    fn outline(&self, face: u16) -> impl ExactSizeIterator<Item = Side>;
    /// The faces that meet in a corner.
    fn around(&self, point: u16) -> impl Iterator<Item = u16>;

    /// The number of edges.
    fn edges(&self) -> u16;
    /// Edge `i`.
    fn edge(&self, i: u16) -> Ridge;

    /// Returns true if one corner is farther in a direction than all others by more than `slack` (m times the length of the direction). May
    /// return false if this is expensive to decide.
    fn stands_on_a_corner(&self, _direction: DVec3, _slack: f64) -> bool {
        false
    }

    /// The half extents, if the solid is a box around the origin along the axes. Two boxes have fewer candidate axes.
    fn half(&self) -> Option<DVec3> {
        None
    }
}

/// Part of a face's outline: a corner, and the edge from there to the next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Side {
    /// The corner.
    pub point: u16,
    /// The edge.
    pub edge: u16,
}

/// An edge: its two ends, and the two faces that meet in it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ridge {
    /// The corners.
    pub ends: [u16; 2],
    /// The faces.
    pub faces: [u16; 2],
}
