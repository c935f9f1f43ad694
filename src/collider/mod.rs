//! Shapes and surfaces.

mod layers;
mod material;
mod polyhedron;
mod sizes;
mod solid;

pub use layers::CollisionLayers;
pub use material::{CombineRule, Friction, Restitution, RollingFriction};
pub use polyhedron::{Edge, Face, Moments, Polyhedron};

use crate::body::{BodyProperty, BodyState, MassProperties};
use bevy_ecs::prelude::*;
use glam::{Quat, Vec3};
use parry3d::math::Pose as ParryPose;
use parry3d::shape::{
    Cone, Cylinder, HeightField, HeightFieldFlags, Shape, ShapeType, SharedShape, TriMeshFlags,
};
use parry3d::utils::Array2;
use solid::Solid;
use std::fmt;

/// The shape of a body, in metres, in the body's frame. Any shape of [`parry3d`] can be had through `From<SharedShape>`;
/// the constructors here cover the common ones. Of convex hulls it also holds the [`Polyhedron`].
#[derive(Component, Clone)]
#[component(on_insert = crate::body::weigh, on_remove = crate::body::lost_description, summary_tick)]
pub struct Collider {
    shape: SharedShape,
    solid: Solid,
}

impl BodyProperty for Collider {
    fn is_known(&self, body: &BodyState) -> bool {
        let known = body.collider.as_ref();
        known.is_some_and(|known| known.is_same(self))
    }
}

/// Why a shape could not be made.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ColliderError {
    /// The points lie in one plane or line or nearly so, are fewer than four, or hold a number that is not finite.
    DegenerateHull,
    /// A convex hull has so many corners, more than [`Polyhedron::MAX_CORNERS`].
    TooManyCorners(usize),
    /// A triangle names a vertex that is not there, or there are no triangles.
    InvalidMesh(String),
    /// A compound of nothing, or with a part that is itself composite.
    InvalidCompound,
    /// A height field with fewer than two rows or columns, or a height that is not finite.
    InvalidHeightField,
}

impl fmt::Display for ColliderError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::DegenerateHull => f.write_str(
                "a convex hull needs four points that are not in one plane, all of them finite",
            ),
            Self::TooManyCorners(count) => write!(
                f,
                "a convex hull of {count} corners, more than {}",
                Polyhedron::MAX_CORNERS
            ),
            Self::InvalidMesh(why) => write!(f, "invalid triangle mesh: {why}"),
            Self::InvalidCompound => f.write_str(
                "a compound needs at least one part, and its parts must be convex and have a size",
            ),
            Self::InvalidHeightField => {
                f.write_str("a height field needs two rows and two columns of finite heights")
            }
        }
    }
}

impl std::error::Error for ColliderError {}

impl Default for Collider {
    /// A cube of 1 m.
    fn default() -> Self {
        Self::cuboid(1.0, 1.0, 1.0)
    }
}

impl fmt::Debug for Collider {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Collider({:?})", self.shape.shape_type())
    }
}

impl From<SharedShape> for Collider {
    fn from(shape: SharedShape) -> Self {
        let solid = Solid::of(&shape);
        Self { shape, solid }
    }
}

impl Collider {
    /// A ball.
    pub fn ball(radius: f32) -> Self {
        SharedShape::ball(radius).into()
    }

    /// A box, by its full edge lengths.
    pub fn cuboid(x: f32, y: f32, z: f32) -> Self {
        SharedShape::cuboid(0.5 * x, 0.5 * y, 0.5 * z).into()
    }

    /// A box with rounded edges, by its full lengths before `border` is added all around.
    pub fn round_cuboid(x: f32, y: f32, z: f32, border: f32) -> Self {
        SharedShape::round_cuboid(0.5 * x, 0.5 * y, 0.5 * z, border).into()
    }

    /// A cylinder about the y axis.
    pub fn cylinder(radius: f32, height: f32) -> Self {
        // Not by its constructor, which panics on a negative size; the stage *prepare* finds that.
        SharedShape::new(Cylinder {
            half_height: 0.5 * height,
            radius,
        })
        .into()
    }

    /// A cone about the y axis, its tip upwards.
    pub fn cone(radius: f32, height: f32) -> Self {
        SharedShape::new(Cone {
            half_height: 0.5 * height,
            radius,
        })
        .into()
    }

    /// A capsule about the y axis; `length` is that of its cylinder.
    pub fn capsule(radius: f32, length: f32) -> Self {
        SharedShape::capsule_y(0.5 * length, radius).into()
    }

    /// A single triangle, without volume: for static bodies.
    pub fn triangle(a: Vec3, b: Vec3, c: Vec3) -> Self {
        SharedShape::triangle(a, b, c).into()
    }

    /// Everything below the plane through the origin with this outward normal: for static bodies.
    pub fn half_space(normal: Vec3) -> Self {
        SharedShape::halfspace(normal.normalize_or(Vec3::Y)).into()
    }

    /// The convex hull of points, m. Its faces are as they are; no two are taken for one because the edge between them is blunt.
    ///
    /// # Errors
    /// [`ColliderError::DegenerateHull`] where they enclose no volume, or next to none; [`ColliderError::TooManyCorners`] where
    /// the hull has more than [`Polyhedron::MAX_CORNERS`], of any number of points.
    pub fn convex_hull(points: &[Vec3]) -> Result<Self, ColliderError> {
        let polyhedron = Polyhedron::new(points)?;
        let shape = solid::to_parry(&polyhedron)?;
        let solid = Solid::Hull(polyhedron.into());
        let hull = Self { shape, solid };
        hull.has_mass()
            .then_some(hull)
            .ok_or(ColliderError::DegenerateHull)
    }

    /// A box cut in half from edge to edge, by its full edge lengths: a ramp that rises along x to the height y, and is z wide.
    /// Its origin is the middle of the box, which is the middle of the slope.
    ///
    /// # Errors
    /// [`ColliderError::DegenerateHull`] where a length is not positive, or tiny beside another.
    pub fn wedge(x: f32, y: f32, z: f32) -> Result<Self, ColliderError> {
        let half = 0.5 * Vec3::new(x, y, z);
        if half.min_element() <= 0.0 {
            return Err(ColliderError::DegenerateHull);
        }
        let profile = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0)];
        let corner = |(x, y)| [-1.0, 1.0].map(|z| half * Vec3::new(x, y, z));
        Self::convex_hull(profile.map(corner).as_flattened())
    }

    /// Of what is hardly a tenth of a millimetre across no body can be made: it is lighter than any may be.
    fn has_mass(&self) -> bool {
        let mass = MassProperties::new(Some(self), None, None, None, None);
        mass.is_valid(self.radius_about(mass.local_center))
    }

    /// Several convex shapes, each at a position and rotation in the body's frame.
    ///
    /// # Errors
    /// [`ColliderError::InvalidCompound`] where there are none, or one is itself composite or without size.
    pub fn compound(parts: Vec<(Vec3, Quat, Collider)>) -> Result<Self, ColliderError> {
        let placed = |p: &(Vec3, Quat, Collider)| {
            p.0.is_finite() && p.1.is_normalized() && p.2.shape.is_convex() && !p.2.is_degenerate()
        };
        if parts.is_empty() || !parts.iter().all(placed) {
            return Err(ColliderError::InvalidCompound);
        }
        let solid = Solid::Parts(parts.iter().map(|part| part.2.solid.hull()).collect());
        let parts = parts
            .into_iter()
            .map(|(position, rotation, collider)| {
                let at = ParryPose::from_parts(position, rotation);
                (at, collider.shape)
            })
            .collect();
        let shape = SharedShape::compound(parts);
        Ok(Self { shape, solid })
    }

    /// A triangle mesh: a surface, for static and kinematic bodies. Seams between its triangles are smooth: contacts use
    /// the face normals where an edge is not a true corner.
    ///
    /// It holds from one side: that from which its triangles run counterclockwise. What comes from behind goes through.
    ///
    /// # Errors
    /// [`ColliderError::InvalidMesh`] where parry cannot build it.
    pub fn trimesh(vertices: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Result<Self, ColliderError> {
        let count = vertices.len() as u32;
        if !vertices.iter().all(|v| v.is_finite()) {
            return Err(ColliderError::InvalidMesh("a vertex is not finite".into()));
        }
        if triangles.iter().flatten().any(|&i| i >= count) {
            return Err(ColliderError::InvalidMesh(format!(
                "a triangle names a vertex beyond the {count} given"
            )));
        }
        SharedShape::trimesh_with_flags(vertices, triangles, TriMeshFlags::FIX_INTERNAL_EDGES)
            .map(Self::from)
            .map_err(|e| ColliderError::InvalidMesh(e.to_string()))
    }

    /// A height field over the x–z plane, centred on the origin: `heights[row][column]` with rows along z and columns
    /// along x, and its full size along x, y (a factor on the heights) and z.
    ///
    /// It holds from above. What comes from below goes through.
    ///
    /// # Errors
    /// [`ColliderError::InvalidHeightField`] where it has fewer than two rows or columns, ragged rows, or a bad height.
    pub fn height_field(heights: &[Vec<f32>], size: Vec3) -> Result<Self, ColliderError> {
        let rows = heights.len();
        let columns = heights.first().map_or(0, Vec::len);
        let even = heights.iter().all(|row| row.len() == columns);
        let finite = heights.iter().flatten().all(|h| h.is_finite()) && size.is_finite();
        if rows < 2 || columns < 2 || !even || !finite {
            return Err(ColliderError::InvalidHeightField);
        }
        let mut data = Array2::zeros(rows, columns);
        for (i, row) in heights.iter().enumerate() {
            for (j, &height) in row.iter().enumerate() {
                data[(i, j)] = height;
            }
        }
        let smooth = HeightFieldFlags::FIX_INTERNAL_EDGES;
        let field = HeightField::with_flags(data, size, smooth);
        Ok(SharedShape::new(field).into())
    }

    /// The parry shape.
    pub fn shape(&self) -> &SharedShape {
        &self.shape
    }

    /// Its corners, edges and faces, where it is a convex hull: for contacts of flat faces.
    pub(crate) fn polyhedron(&self) -> Option<&Polyhedron> {
        match &self.solid {
            Solid::Hull(hull) => Some(hull),
            _ => None,
        }
    }

    /// The same of a part of a compound.
    pub(crate) fn part_polyhedron(&self, part: u32) -> Option<&Polyhedron> {
        match &self.solid {
            Solid::Parts(parts) => parts.get(part as usize)?.as_deref(),
            _ => None,
        }
    }

    /// Mass, centre and moments at 1 kg/m³: of hulls in double precision, of other shapes as parry has them.
    pub(crate) fn mass_properties(&self) -> parry3d::mass_properties::MassProperties {
        let solid = self.solid.moments(&self.shape);
        let found = solid.map_or_else(|| self.shape.mass_properties(1.0), solid::rounded);
        let bounds = self.shape.compute_local_aabb();
        // An open mesh encloses no volume. What parry makes of it has its centre anywhere, and contacts are found relative to that.
        match self.is_surface() && !bounds.contains_local_point(found.local_com) {
            true => parry3d::mass_properties::MassProperties::new(bounds.center(), 0.0, Vec3::ZERO),
            false => found,
        }
    }

    /// True where no contact can be computed with it: a size that is zero, negative, not finite or beyond
    /// [`limits`](crate::body::limits).
    pub fn is_degenerate(&self) -> bool {
        !sizes::are_valid(&*self.shape)
    }

    /// True where the other is certainly the same shape.
    pub(crate) fn is_same(&self, other: &Self) -> bool {
        std::sync::Arc::ptr_eq(&self.shape.0, &other.shape.0)
            || sizes::are_equal(&*self.shape, &*other.shape)
            || self.solid.is_same_hull(&other.solid)
    }

    /// Radius of the sphere about a local point that holds the shape, m; infinite for a half-space.
    pub(crate) fn radius_about(&self, center: Vec3) -> f32 {
        if self.shape.as_halfspace().is_some() {
            return f32::INFINITY;
        }
        let sphere = self.shape.compute_local_bounding_sphere();
        (sphere.center - center).length() + sphere.radius
    }

    /// Half the edges of the box that holds the shape, in the body's axes, m; infinite for a half-space.
    pub fn half_extents(&self) -> Vec3 {
        if self.shape.as_halfspace().is_some() {
            return Vec3::INFINITY;
        }
        self.shape.compute_local_aabb().half_extents()
    }

    /// True of meshes and height fields.
    pub(crate) fn is_surface(&self) -> bool {
        is_surface(&*self.shape)
    }

    /// True where the surface is curved, so that a rolling contact point moves over it.
    pub(crate) fn is_curved(&self) -> bool {
        use parry3d::shape::ShapeType as S;
        matches!(
            self.shape.shape_type(),
            S::Ball | S::Capsule | S::Cylinder | S::Cone | S::RoundCylinder | S::RoundCone
        )
    }
}

/// True of what has triangles and nothing behind them.
pub(crate) fn is_surface(shape: &dyn Shape) -> bool {
    matches!(
        shape.shape_type(),
        ShapeType::TriMesh | ShapeType::HeightField
    )
}
