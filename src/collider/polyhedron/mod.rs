//! Convex polyhedra: corners, edges and faces, and how they join.
//!
//! Parry's hull leaves coplanar triangles, merges faces up to 1.5° apart, and panics on bad input. This one is of whole numbers
//! ([`lattice`]), and so has no rounding to go wrong ([`quickhull`]); what single precision made of flat faces is put right
//! after ([`outlines`]), and what comes out is checked ([`join`]).

mod join;
mod lattice;
mod moments;
mod outlines;
mod quickhull;

pub use moments::Moments;

use super::ColliderError;
use glam::Vec3;
use std::ops::Range;

/// A convex polyhedron in its body's frame, m: corners, faces, edges, and how they join.
///
/// Faces are true polygons. A point that is outside of the others by less than some millionths of the size, or by less than single
/// precision resolves so far from the origin, is no corner.
///
/// # Source
/// C. B. Barber, D. P. Dobkin and H. Huhdanpaa, *The Quickhull algorithm for convex hulls*, 1996, for finding the corners;
/// D. Gregorius, *Implementing Quickhull*, Game Developers Conference 2014, for what single precision does to it.
#[derive(Clone, Debug, PartialEq)]
pub struct Polyhedron {
    /// The corners, m: of the points given, without doubles and such as lie inside a face or on an edge.
    pub points: Box<[Vec3]>,
    /// The faces.
    pub faces: Box<[Face]>,
    /// The corners of all faces, one face after another, each face's counterclockwise as seen from outside.
    pub corners: Box<[u16]>,
    /// For each of `corners`, the edge from it to the next corner of the face.
    pub sides: Box<[u16]>,
    /// The edges.
    pub edges: Box<[Edge]>,
    /// The faces around each point, one point after another.
    pub around: Box<[u16]>,
    /// Where the faces around each point begin in `around`, and after the last point where they end.
    pub first_around: Box<[u32]>,
    /// The centroid of the volume, m.
    pub center: Vec3,
    /// Radius of a ball about `center` that lies inside, m.
    pub inner: f32,
    /// Radius of a ball about `center` that holds it, m.
    pub outer: f32,
}

/// A face of a [`Polyhedron`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Face {
    /// The way out, of unit length.
    pub normal: Vec3,
    /// How far along the normal the polyhedron reaches from the origin, m.
    pub offset: f32,
    /// Where it begins in [`Polyhedron::corners`] and [`Polyhedron::sides`].
    pub first: u32,
    /// Its number of corners, which is that of its sides.
    pub count: u32,
    /// Extent of the polyhedron along the normal, m.
    pub depth: f32,
}

/// An edge of a [`Polyhedron`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Edge {
    /// The points it joins.
    pub ends: [u16; 2],
    /// The faces it divides. That from the first end to the second is counterclockwise around the first face, and clockwise
    /// around the second.
    pub faces: [u16; 2],
}

impl Polyhedron {
    /// Most corners there may be. Faces and edges are then fewer than 2¹⁴, and parry, which takes faces less than 1.5° apart for
    /// one, still finds some on what is as round as a ball.
    pub const MAX_CORNERS: usize = 4096;

    /// The convex hull of points, m.
    ///
    /// # Errors
    /// [`ColliderError::DegenerateHull`] where they enclose no volume or are not finite, [`ColliderError::TooManyCorners`] where
    /// the hull has more than [`MAX_CORNERS`](Self::MAX_CORNERS).
    pub fn new(points: &[Vec3]) -> Result<Self, ColliderError> {
        let lattice = lattice::Lattice::new(points).ok_or(ColliderError::DegenerateHull)?;
        let outlines = lattice.faces().ok_or(ColliderError::DegenerateHull)?;
        join::join(points, &lattice, &outlines)
    }

    /// The corners of a face, counterclockwise as seen from outside.
    #[inline]
    pub fn corners_of(&self, face: usize) -> &[u16] {
        &self.corners[self.faces[face].range()]
    }

    /// The edges around a face: each from the corner of the same place in [`corners_of`](Self::corners_of) to the next.
    #[inline]
    pub fn sides_of(&self, face: usize) -> &[u16] {
        &self.sides[self.faces[face].range()]
    }

    /// The faces around a point.
    #[inline]
    pub fn faces_around(&self, point: usize) -> &[u16] {
        &self.around[self.first_around[point] as usize..self.first_around[point + 1] as usize]
    }

    /// Volume, centroid and inertia at a density of 1 kg/m³.
    pub fn moments(&self) -> Moments {
        Moments::of(self)
    }

    /// Each face as a fan of triangles.
    pub(crate) fn triangles(&self) -> impl Iterator<Item = [u16; 3]> + '_ {
        (0..self.faces.len()).flat_map(|face| {
            let corners = self.corners_of(face);
            let pairs = corners[1..].windows(2);
            pairs.map(|pair| [corners[0], pair[0], pair[1]])
        })
    }
}

impl Face {
    /// Where its corners are in [`Polyhedron::corners`], and its sides in [`Polyhedron::sides`].
    #[inline]
    pub fn range(&self) -> Range<usize> {
        self.first as usize..(self.first + self.count) as usize
    }
}
