//! Convex polyhedra: corners, edges and faces, and how they are connected.
//!
//! Parry's convex hull leaves coplanar triangles, merges faces up to 1.5° apart, and panics on bad input. This one uses integer coordinates
//! ([`lattice`]), so the hull ([`quickhull`]) has no rounding errors. Faces that were flat before their corners were rounded to single
//! precision are restored afterwards ([`outlines`]), and the result is checked ([`join`]).

mod join;
mod lattice;
mod moments;
mod outlines;
mod quickhull;

pub use moments::Moments;

use super::ColliderError;
use glam::Vec3;
use parry3d::mass_properties::MassProperties;
use std::ops::Range;

/// A convex polyhedron in its body's frame: corners, faces and edges, and how they are connected. Lengths are in metres.
///
/// Faces are polygons of any number of corners. A point that lies outside the hull of the others by less than some millionths of the
/// size, or by less than single precision resolves at its distance from the origin, is not a corner.
///
/// # Source
/// C. B. Barber, D. P. Dobkin and H. Huhdanpaa, *The Quickhull algorithm for convex hulls*, 1996, for finding the corners; D. Gregorius,
/// *Implementing Quickhull*, Game Developers Conference 2014, for the effects of single precision.
#[derive(Clone, Debug, PartialEq)]
pub struct Polyhedron {
    /// Positions of the corners, m: the given points without duplicates and without those inside a face or on an edge.
    pub points: Box<[Vec3]>,
    /// The faces.
    pub faces: Box<[Face]>,
    /// Indices of the corners of all faces, one face after another, counterclockwise as seen from outside.
    pub corners: Box<[u16]>,
    /// For each of [`corners`](Self::corners), the index of the edge from it to the next corner of the face.
    pub sides: Box<[u16]>,
    /// The edges.
    pub edges: Box<[Edge]>,
    /// Indices of the faces around each point, one point after another.
    pub around: Box<[u16]>,
    /// Where the faces around each point begin in [`around`](Self::around), and one final entry where they end.
    pub first_around: Box<[u32]>,
    /// Centroid of the volume, m.
    pub center: Vec3,
    /// Radius of a ball around [`center`](Self::center) that lies inside, m.
    pub inner: f32,
    /// Radius of a ball around [`center`](Self::center) that contains the polyhedron, m.
    pub outer: f32,
    has_given_faces: bool,
    moments: Moments,
    /// The same as parry's mass properties. Each component of a body that changes its mass asks for them.
    mass: MassProperties,
}

/// The faces of a box as loops of corners, counterclockwise as seen from outside; [`octant`] says where the corners are.
pub(crate) const BOX_FACES: [[u32; 4]; 6] = [
    [0, 4, 6, 2],
    [1, 3, 7, 5],
    [0, 1, 5, 4],
    [2, 6, 7, 3],
    [0, 2, 3, 1],
    [4, 5, 7, 6],
];

/// The direction of a corner of a box: ±1 along each axis.
pub(crate) fn octant(corner: usize) -> Vec3 {
    let sign = |axis: usize| if corner >> axis & 1 == 0 { -1.0 } else { 1.0 };
    Vec3::from_array(std::array::from_fn(sign))
}

/// A face of a [`Polyhedron`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Face {
    /// Outward unit normal.
    pub normal: Vec3,
    /// Distance of the face's plane from the origin along the normal, m.
    pub offset: f32,
    /// Index of its first entry in [`Polyhedron::corners`] and [`Polyhedron::sides`].
    pub first: u32,
    /// Number of its corners, which is also that of its sides.
    pub count: u32,
    /// Extent of the polyhedron along the normal, m.
    pub depth: f32,
}

/// An edge of a [`Polyhedron`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Edge {
    /// Indices of the two points that it joins.
    pub ends: [u16; 2],
    /// Indices of the two faces that it divides. From the first end to the second it runs counterclockwise around the first face, and
    /// clockwise around the second.
    pub faces: [u16; 2],
}

impl Polyhedron {
    /// Maximum number of corners: 4096. The numbers of faces and edges then stay below 2¹⁴. On a hull as round as a ball with more
    /// corners, parry would merge all faces, because it merges those less than 1.5° apart.
    pub const MAX_CORNERS: usize = 4096;

    /// The convex hull of these points, m.
    ///
    /// # Errors
    /// [`ColliderError::DegenerateHull`] if they enclose no volume or are not finite. [`ColliderError::TooManyCorners`] if the hull has
    /// more than [`MAX_CORNERS`](Self::MAX_CORNERS).
    pub fn new(points: &[Vec3]) -> Result<Self, ColliderError> {
        let lattice = lattice::Lattice::new(points).ok_or(ColliderError::DegenerateHull)?;
        let outlines = lattice.faces().ok_or(ColliderError::DegenerateHull)?;
        join::join(points, &lattice, &outlines)
    }

    /// The polyhedron with these corners, m, and faces; see [`Collider::convex_polyhedron`](super::Collider::convex_polyhedron).
    pub(super) fn of_faces(
        corners: &[Vec3],
        faces: &[impl AsRef<[u32]>],
    ) -> Result<Self, ColliderError> {
        let lattice = lattice::Lattice::new(corners).ok_or(ColliderError::DegenerateHull)?;
        let mut all = faces.iter().flat_map(AsRef::as_ref);
        if all.any(|&corner| corner as usize >= corners.len()) {
            return Err(ColliderError::DegenerateHull);
        }
        let mut polyhedron = join::join(corners, &lattice, faces)?;
        polyhedron.has_given_faces = true;
        Ok(polyhedron)
    }

    /// Whether it was made from its faces. The hull of its corners may have them in another order.
    pub(super) fn has_given_faces(&self) -> bool {
        self.has_given_faces
    }

    /// The corners of each face.
    pub(super) fn outlines(&self) -> impl Iterator<Item = Vec<u32>> + '_ {
        let faces = (0..self.faces.len()).map(|face| self.corners_of(face));
        faces.map(|corners| corners.iter().map(|&corner| corner.into()).collect())
    }

    /// The indices of a face's corners, counterclockwise as seen from outside.
    ///
    /// # Panics
    /// If there is no such face.
    #[inline]
    pub fn corners_of(&self, face: usize) -> &[u16] {
        &self.corners[self.faces[face].range()]
    }

    /// The indices of the edges around a face. Each leads from the corner at the same place in [`corners_of`](Self::corners_of) to the
    /// next corner.
    ///
    /// # Panics
    /// If there is no such face.
    #[inline]
    pub fn sides_of(&self, face: usize) -> &[u16] {
        &self.sides[self.faces[face].range()]
    }

    /// The indices of the faces around a point.
    ///
    /// # Panics
    /// If there is no such point.
    #[inline]
    pub fn faces_around(&self, point: usize) -> &[u16] {
        &self.around[self.first_around[point] as usize..self.first_around[point + 1] as usize]
    }

    /// Volume, centroid and inertia at a density of 1 kg/m³.
    pub fn moments(&self) -> Moments {
        self.moments
    }

    /// Mass, centre of mass and inertia at a density of 1 kg/m³, as parry's mass properties.
    pub(super) fn mass(&self) -> MassProperties {
        self.mass
    }

    /// The surface as triangles: each face as a fan.
    pub(crate) fn triangles(&self) -> impl Iterator<Item = [u16; 3]> + '_ {
        (0..self.faces.len()).flat_map(|face| {
            let corners = self.corners_of(face);
            let pairs = corners[1..].windows(2);
            pairs.map(|pair| [corners[0], pair[0], pair[1]])
        })
    }
}

impl Face {
    /// The indices of its entries in [`Polyhedron::corners`] and [`Polyhedron::sides`].
    #[inline]
    pub fn range(&self) -> Range<usize> {
        self.first as usize..(self.first + self.count) as usize
    }
}
