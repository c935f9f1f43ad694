//! The interface of a convex polyhedron for collision detection: corners, faces, edges and extents.
//!
//! Everything is in the solid's own frame, in m, and in double precision: without lanes it costs no more than single, and where
//! faces and edges coincide all digits count.

use glam::DVec3;

/// A convex polyhedron.
pub trait Solid {
    /// A point inside.
    fn center(&self) -> DVec3;
    /// Radius of a ball about the centre that lies inside.
    fn inner(&self) -> f64;
    /// Radius of a ball about the centre that holds it.
    fn outer(&self) -> f64;

    /// Corner `i`.
    fn point(&self, i: u16) -> DVec3;
    /// How far it reaches from the origin in a direction: max `direction · x`.
    fn reach(&self, direction: DVec3) -> f64;
    /// The corner that is farthest in a direction.
    fn farthest(&self, direction: DVec3) -> u16;

    /// How many faces there are.
    fn faces(&self) -> u16;
    /// The outward unit normal of a face, and its `normal · x`.
    fn plane(&self, face: u16) -> (DVec3, f64);
    /// The outline of a face, counterclockwise seen from outside.
    fn outline(&self, face: u16) -> impl ExactSizeIterator<Item = Side>;
    /// The faces that meet in a corner.
    fn around(&self, point: u16) -> impl Iterator<Item = u16>;

    /// How many edges there are.
    fn edges(&self) -> u16;
    /// Edge `i`.
    fn edge(&self, i: u16) -> Ridge;

    /// Returns true if no corner is as far in a direction as the farthest, but for less than `slack` (m times the direction's length), as
    /// far as that is seen at once.
    fn stands_on_a_corner(&self, _direction: DVec3, _slack: f64) -> bool {
        false
    }

    /// Half its edges, if it is a box about the origin along the axes: of such two, fewer axes have to be tried.
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
