//! Collision shapes, surface materials and collision layers.
//!
//! [`Collider`] is the shape of a body. [`Friction`], [`Restitution`] and [`RollingFriction`] describe its surface, [`CollisionLayers`]
//! what it collides with. All lengths are in metres.

mod decompose;
mod description;
mod exceptions;
mod first_touch;
#[cfg(feature = "mesh")]
mod fit;
mod layer_mask;
mod layers;
mod material;
#[cfg(feature = "mesh")]
mod mesh;
mod polyhedron;
mod primitives;
#[cfg(feature = "serde")]
mod saved;
mod scale;
mod sizes;
mod solid;
mod surface_velocity;

pub use decompose::DecompositionSettings;
pub use description::{ColliderShape, CompoundPart};
pub use exceptions::CollisionExceptions;
pub(crate) use first_touch::{Approach, TOUCHING_DISTANCE, first_touch};
pub use layer_mask::{CollisionLayer, LayerMask};
pub use layers::CollisionLayers;
pub use material::{CombineRule, Friction, Restitution, RollingFriction};
#[cfg(feature = "mesh")]
pub use mesh::{MeshShape, mesh_triangles};
pub(crate) use polyhedron::{BOX_FACES, octant};
pub use polyhedron::{Edge, Face, Moments, Polyhedron};
#[cfg(feature = "serde")]
pub(crate) use saved::SharedShapes;
pub(crate) use solid::volume;
pub use surface_velocity::SurfaceVelocity;

use crate::body::{MassProperties, SpawnOrder};
use crate::solver::Both;
use bevy_ecs::prelude::*;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::{Reflect, std_traits::ReflectDefault};
use glam::{Quat, Vec3};
use parry3d::math::Pose as ParryPose;
use parry3d::shape::{
    Cone, Cylinder, HeightField, HeightFieldFlags, Shape, ShapeType, SharedShape, TriMeshFlags,
};
use parry3d::utils::Array2;
use solid::Solid;
use std::fmt;
use thiserror::Error;

/// The collision shape of a body, in metres and in the body's frame. Default: a cube of 1 m.
///
/// The constructors cover the common shapes. Any other shape of [`parry3d`] can be converted with `From<SharedShape>`. On an entity with a
/// [`RigidBody`](crate::body::RigidBody) it is the shape of that body. On an entity below a body in the hierarchy it is a part of that
/// body, and without a body above it stands still; see [`children`](crate::children). The shape follows the scale of its `Transform`.
///
/// [`description`](Self::description) returns the shape with all of its parameters. With the feature `serde` a collider is written to files
/// in that form.
#[derive(Component)]
#[cfg_attr(
    feature = "bevy_reflect",
    derive(Reflect),
    reflect(opaque),
    reflect(Component, Clone, Debug, Default)
)]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[component(on_insert = crate::body::parts::collider_inserted, on_remove = crate::body::lost_description, summary_tick)]
#[require(SpawnOrder)]
pub struct Collider {
    shape: SharedShape,
    solid: Solid,
}

/// Why a shape cannot be made.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum ColliderError {
    /// The points of a convex hull are fewer than four, lie (nearly) in one plane or line, or contain a number that is not finite.
    #[error("a convex hull needs four points that are not in one plane, all of them finite")]
    DegenerateHull,
    /// The convex hull has this many corners, more than [`Polyhedron::MAX_CORNERS`].
    #[error("a convex hull of {0} corners, more than {max}", max = Polyhedron::MAX_CORNERS)]
    TooManyCorners(usize),
    /// A triangle names a vertex that does not exist, a vertex is not finite, or there are no triangles.
    #[error("invalid triangle mesh: {0}")]
    InvalidMesh(String),
    /// The compound has no parts, or a part that is itself composite, degenerate, or at an invalid pose.
    #[error("a compound needs at least one part, and its parts must be convex and have a size")]
    InvalidCompound,
    /// The height field has fewer than two rows or columns, rows of different lengths, or a height that is not finite.
    #[error("a height field needs two rows and two columns of finite heights")]
    InvalidHeightField,
    /// A factor of the scale is zero or not finite, or a height field would be mirrored.
    #[error(
        "a scale must be finite and not zero along any axis, and not negative for a height field"
    )]
    InvalidScale,
}

impl Default for Collider {
    /// A cube of 1 m.
    fn default() -> Self {
        Self::cuboid(1.0, 1.0, 1.0)
    }
}

impl Clone for Collider {
    fn clone(&self) -> Self {
        Self {
            shape: self.shape.clone(),
            solid: self.solid.clone(),
        }
    }

    fn clone_from(&mut self, from: &Self) {
        // A snapshot that is taken again has the same shapes, and its polyhedra are those of the shape.
        if !std::sync::Arc::ptr_eq(&self.shape.0, &from.shape.0) {
            *self = from.clone();
        }
    }
}

impl fmt::Debug for Collider {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let half = self.half_extents();
        write!(f, "Collider({:?}, half {half:?})", self.shape.shape_type())
    }
}

/// Two colliders are equal if they are certainly the same shape. Two meshes that were made one after the other are not.
impl PartialEq for Collider {
    fn eq(&self, other: &Self) -> bool {
        self.is_same(other)
    }
}

impl From<SharedShape> for Collider {
    fn from(shape: SharedShape) -> Self {
        let solid = Solid::of(&shape);
        Self { shape, solid }
    }
}

impl Collider {
    /// A ball with this radius, m. On a level floor it rolls on and on, unless it has [`RollingFriction`].
    pub fn ball(radius: f32) -> Self {
        SharedShape::ball(radius).into()
    }

    /// A box with these full edge lengths, m.
    pub fn cuboid(x: f32, y: f32, z: f32) -> Self {
        SharedShape::cuboid(0.5 * x, 0.5 * y, 0.5 * z).into()
    }

    /// A box with rounded edges: a box with these full edge lengths, m, enlarged by `border` (m) on all sides.
    pub fn round_cuboid(x: f32, y: f32, z: f32, border: f32) -> Self {
        SharedShape::round_cuboid(0.5 * x, 0.5 * y, 0.5 * z, border).into()
    }

    /// A cylinder around the y axis, with its radius and full height, m. On its side it rolls on and on, unless it has
    /// [`RollingFriction`].
    pub fn cylinder(radius: f32, height: f32) -> Self {
        // Not by its constructor, which panics on a negative size; the stage *prepare* finds that.
        SharedShape::new(Cylinder {
            half_height: 0.5 * height,
            radius,
        })
        .into()
    }

    /// A cone around the y axis with its tip upwards, with its radius and full height, m.
    pub fn cone(radius: f32, height: f32) -> Self {
        SharedShape::new(Cone {
            half_height: 0.5 * height,
            radius,
        })
        .into()
    }

    /// A capsule around the y axis, with its radius and the length of its cylindrical part, m. It rolls on and on, unless it has
    /// [`RollingFriction`].
    pub fn capsule(radius: f32, length: f32) -> Self {
        SharedShape::capsule_y(0.5 * length, radius).into()
    }

    /// A single triangle with these corners, m. It has no volume, so it is for static bodies.
    pub fn triangle(a: Vec3, b: Vec3, c: Vec3) -> Self {
        SharedShape::triangle(a, b, c).into()
    }

    /// The half-space below the plane through the origin with this outward normal. It is for static bodies. A zero normal counts as +y.
    pub fn half_space(normal: Vec3) -> Self {
        SharedShape::halfspace(normal.normalize_or(Vec3::Y)).into()
    }

    /// The convex hull of these points, m. Faces that are nearly coplanar are not merged.
    ///
    /// # Errors
    /// [`ColliderError::DegenerateHull`] if the points enclose (nearly) no volume or are not finite. [`ColliderError::TooManyCorners`] if
    /// the hull has more than [`Polyhedron::MAX_CORNERS`] corners; the number of points is not limited.
    pub fn convex_hull(points: &[Vec3]) -> Result<Self, ColliderError> {
        Self::of_polyhedron(Polyhedron::new(points)?)
    }

    /// A convex polyhedron with these corners, m, and faces: loops of the indices of corners, counterclockwise as seen from outside. It is
    /// made twice as fast as the [hull](Self::convex_hull) of the corners. Each of them must be a corner of every face that it touches, and
    /// faces must not lie in one plane.
    ///
    /// # Errors
    /// As [`convex_hull`](Self::convex_hull), and [`ColliderError::DegenerateHull`] if the faces do not form a closed convex surface.
    pub fn convex_polyhedron(
        corners: &[Vec3],
        faces: &[impl AsRef<[u32]>],
    ) -> Result<Self, ColliderError> {
        Self::of_polyhedron(Polyhedron::of_faces(corners, faces)?)
    }

    fn of_polyhedron(polyhedron: Polyhedron) -> Result<Self, ColliderError> {
        let shape = solid::to_parry(&polyhedron)?;
        let solid = Solid::Hull(polyhedron.into());
        let hull = Self { shape, solid };
        hull.has_mass()
            .then_some(hull)
            .ok_or(ColliderError::DegenerateHull)
    }

    /// A wedge: a box with these full edge lengths, m, cut in half from edge to edge. Its slope rises along x to the height `y`, and it
    /// is `z` wide. Its origin is the middle of the box, which is also the middle of the slope.
    ///
    /// # Errors
    /// [`ColliderError::DegenerateHull`] if a length is not positive, or tiny compared to another.
    pub fn wedge(x: f32, y: f32, z: f32) -> Result<Self, ColliderError> {
        let half = 0.5 * Vec3::new(x, y, z);
        if half.min_element() <= 0.0 {
            return Err(ColliderError::DegenerateHull);
        }
        let profile = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0)];
        let corner = |(x, y)| [-1.0, 1.0].both(|z| half * Vec3::new(x, y, z));
        Self::convex_hull(profile.map(corner).as_flattened())
    }

    /// Whether a body of this shape has a valid mass. Shapes of less than about a tenth of a millimetre are lighter than the lightest
    /// body allowed.
    fn has_mass(&self) -> bool {
        let mass = MassProperties::new(Some(self), None, None, None, None);
        mass.is_valid(self.radius_about(mass.local_center))
    }

    /// A compound of convex shapes, each at a position (m) and rotation in the body's frame.
    ///
    /// # Errors
    /// [`ColliderError::InvalidCompound`] if there are no parts, or a part is itself composite or degenerate, or its pose is invalid.
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

    /// A triangle mesh, for static and kinematic bodies: a surface without volume. Seams between its triangles are smooth: contacts use
    /// the face normal where an edge is not a true corner.
    ///
    /// The mesh is one-sided. It stops bodies on the side from which its triangles run counterclockwise; bodies from the other side pass
    /// through.
    ///
    /// # Errors
    /// [`ColliderError::InvalidMesh`] if a vertex is not finite, a triangle names a vertex that does not exist, or parry cannot build the
    /// mesh.
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

    /// A height field over the x–z plane, centred on the origin. `heights[row][column]` has rows along z and columns along x. `size` is
    /// its full size along x and z, m, and the factor on the heights along y.
    ///
    /// The field is one-sided. It stops bodies from above; bodies from below pass through.
    ///
    /// # Errors
    /// [`ColliderError::InvalidHeightField`] if it has fewer than two rows or columns, rows of different lengths, or a number that is not
    /// finite.
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

    /// The polyhedron of a convex hull.
    pub(crate) fn polyhedron(&self) -> Option<&Polyhedron> {
        match &self.solid {
            Solid::Hull(hull) => Some(hull),
            _ => None,
        }
    }

    /// The polyhedron of a part of a compound.
    pub(crate) fn part_polyhedron(&self, part: u32) -> Option<&Polyhedron> {
        match &self.solid {
            Solid::Parts(parts) => parts.get(part as usize)?.as_deref(),
            _ => None,
        }
    }

    /// Volume, centroid and inertia in double precision; zero for surfaces.
    pub(crate) fn moments(&self) -> Moments {
        let solid = self.solid.moments(&self.shape);
        solid.unwrap_or_else(|| solid::parry_moments(&self.shape))
    }

    /// Whether it can be a part of a compound: it has an inside and an end.
    pub(crate) fn has_volume(&self) -> bool {
        !self.is_surface()
            && !matches!(
                self.shape.shape_type(),
                ShapeType::HalfSpace | ShapeType::Triangle | ShapeType::Voxels
            )
    }

    /// Mass, centre of mass and moments of inertia at a density of 1 kg/m³. Hulls are computed in double precision, other shapes by
    /// parry.
    pub(crate) fn mass_properties(&self) -> parry3d::mass_properties::MassProperties {
        if let Some(hull) = self.polyhedron() {
            return hull.mass();
        }
        let solid = self.solid.moments(&self.shape);
        let found = solid.map_or_else(|| self.shape.mass_properties(1.0), solid::to_parry_mass);
        let bounds = self.shape.compute_local_aabb();
        // An open mesh encloses no volume. Its centre of mass from parry may lie anywhere, but contacts are computed relative to it.
        match self.is_surface() && !bounds.contains_local_point(found.local_com) {
            true => parry3d::mass_properties::MassProperties::new(bounds.center(), 0.0, Vec3::ZERO),
            false => found,
        }
    }

    /// Returns true if the shape cannot have contacts, because a size is zero, negative, not finite or beyond
    /// [`limits`](crate::body::limits).
    pub fn is_degenerate(&self) -> bool {
        !sizes::are_valid(&*self.shape)
    }

    /// Whether the other is certainly the same shape.
    pub(crate) fn is_same(&self, other: &Self) -> bool {
        std::sync::Arc::ptr_eq(&self.shape.0, &other.shape.0)
            || sizes::are_equal(&*self.shape, &*other.shape)
            || self.solid.is_same_hull(&other.solid)
    }

    /// Radius of the smallest known sphere around a local point that contains the shape, m. Infinite for a half-space.
    pub(crate) fn radius_about(&self, center: Vec3) -> f32 {
        if self.shape.as_halfspace().is_some() {
            return f32::INFINITY;
        }
        let sphere = self.shape.compute_local_bounding_sphere();
        (sphere.center - center).length() + sphere.radius
    }

    /// Half the edge lengths of the bounding box in the body's axes, m. Infinite for a half-space.
    pub fn half_extents(&self) -> Vec3 {
        if self.shape.as_halfspace().is_some() {
            return Vec3::INFINITY;
        }
        self.shape.compute_local_aabb().half_extents()
    }

    /// Whether it is a mesh or height field.
    pub(crate) fn is_surface(&self) -> bool {
        is_surface(&*self.shape)
    }

    /// Whether the surface is curved, so that the contact point moves over it as the body rolls.
    pub(crate) fn is_curved(&self) -> bool {
        use parry3d::shape::ShapeType as S;
        matches!(
            self.shape.shape_type(),
            S::Ball | S::Capsule | S::Cylinder | S::Cone | S::RoundCylinder | S::RoundCone
        )
    }
}

/// Whether a shape is a surface without an inside: a mesh or height field.
pub(crate) fn is_surface(shape: &dyn Shape) -> bool {
    matches!(
        shape.shape_type(),
        ShapeType::TriMesh | ShapeType::HeightField
    )
}
