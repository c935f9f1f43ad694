//! Colliders from meshes of Bevy (feature `mesh`).

use super::fit::Bounds;
use super::{Collider, ColliderError, DecompositionSettings};
use bevy_mesh::{Indices, Mesh, PrimitiveTopology, VertexAttributeValues};
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::{Reflect, std_traits::ReflectDefault};
use glam::Vec3;

/// The kind of collider that a mesh becomes.
///
/// | variant | for | cost in a step |
/// |---|---|---|
/// | [`Cuboid`](Self::Cuboid), [`Ball`](Self::Ball) | bodies of every kind: crates, balls | lowest |
/// | [`Capsule`](Self::Capsule), [`Cylinder`](Self::Cylinder) | bodies of every kind: people, barrels | low |
/// | [`ConvexHull`](Self::ConvexHull) | bodies of every kind: stones, bricks | low, grows with the corners |
/// | [`Decomposition`](Self::Decomposition) | bodies of every kind that have hollows: a bowl, an arch in one piece | grows with the parts |
/// | [`Surface`](Self::Surface) | static and kinematic bodies: terrain, houses | grows with the triangles that something touches |
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "bevy_reflect",
    derive(Reflect),
    reflect(Debug, Default, PartialEq)
)]
pub enum MeshShape {
    /// A surface without an inside, as [`Collider::trimesh`]: for static and kinematic bodies.
    #[default]
    Surface,
    /// The convex hull of the vertices, as [`Collider::convex_hull`]: for bodies of every kind.
    ConvexHull,
    /// Several convex hulls that fill a closed mesh, as [`Collider::convex_decomposition`]: for bodies of every kind.
    Decomposition(DecompositionSettings),
    /// The box of the vertices along the axes of the mesh.
    Cuboid,
    /// The smallest ball about the middle of that box that holds all vertices.
    Ball,
    /// A capsule as long as the box along its longest axis, and as wide as its second longest.
    Capsule,
    /// A cylinder about the axis across which the box is nearest to a square, as wide as the wider side.
    Cylinder,
}

impl Collider {
    /// A collider with the vertices of a mesh.
    ///
    /// # Errors
    /// [`ColliderError::InvalidMesh`] if the mesh is not a list or strip of triangles, has no triangles, has no positions of three numbers,
    /// has one that is not finite, or is not kept in main memory, or if it is flat and the shape needs a volume; other errors as those of
    /// [`Collider::trimesh`], [`Collider::convex_hull`] and [`Collider::convex_decomposition`].
    pub fn from_mesh(mesh: &Mesh, shape: MeshShape) -> Result<Self, ColliderError> {
        let (vertices, triangles) = mesh_triangles(mesh)?;
        Self::of_triangles(vertices, triangles, shape)
    }

    /// A collider of at least one vertex.
    pub(crate) fn of_triangles(
        vertices: Vec<Vec3>,
        triangles: Vec<[u32; 3]>,
        shape: MeshShape,
    ) -> Result<Self, ColliderError> {
        if !vertices.iter().all(|vertex| vertex.is_finite()) {
            return Err(ColliderError::InvalidMesh("a vertex is not finite".into()));
        }
        match shape {
            MeshShape::Surface => Self::trimesh(vertices, triangles),
            MeshShape::ConvexHull => Self::convex_hull(&vertices),
            MeshShape::Decomposition(settings) => {
                Self::convex_decomposition(&vertices, &triangles, &settings)
            }
            MeshShape::Cuboid => Bounds::of(&vertices).cuboid(),
            MeshShape::Ball => Bounds::of(&vertices).ball(&vertices),
            MeshShape::Capsule => Bounds::of(&vertices).capsule(),
            MeshShape::Cylinder => Bounds::of(&vertices).cylinder(),
        }
    }
}

/// The vertices (m) and triangles of a mesh. There is at least one of each.
///
/// # Errors
/// [`ColliderError::InvalidMesh`] as for [`Collider::from_mesh`].
pub fn mesh_triangles(mesh: &Mesh) -> Result<(Vec<Vec3>, Vec<[u32; 3]>), ColliderError> {
    let invalid = |why: &str| ColliderError::InvalidMesh(why.into());
    let no_positions = || invalid("it has no positions of three numbers in main memory");
    let positions = mesh
        .try_attribute(Mesh::ATTRIBUTE_POSITION)
        .map_err(|_| no_positions())?;
    let VertexAttributeValues::Float32x3(positions) = positions else {
        return Err(no_positions());
    };
    let vertices: Vec<Vec3> = positions.iter().copied().map(Vec3::from_array).collect();
    let indices = mesh
        .try_indices_option()
        .map_err(|_| invalid("its indices are not in main memory"))?;
    let indices: Vec<u32> = match indices {
        Some(Indices::U16(indices)) => indices.iter().copied().map(u32::from).collect(),
        Some(Indices::U32(indices)) => indices.clone(),
        None => (0..vertices.len() as u32).collect(),
    };
    let triangles: Vec<[u32; 3]> = match mesh.primitive_topology() {
        PrimitiveTopology::TriangleList => indices.as_chunks::<3>().0.to_vec(),
        PrimitiveTopology::TriangleStrip => indices
            .array_windows()
            .enumerate()
            .map(|(i, &[a, b, c])| if i % 2 == 0 { [a, b, c] } else { [b, a, c] })
            .collect(),
        _ => return Err(invalid("it does not consist of triangles")),
    };
    match triangles.is_empty() || vertices.is_empty() {
        true => Err(invalid("it has no triangles")),
        false => Ok((vertices, triangles)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy_mesh::PrimitiveTopology;
    use bevy_shape::{Capsule3d, Cuboid, Cylinder, Sphere};
    use glam::Quat;

    fn volume(mesh: &Mesh, shape: MeshShape) -> f32 {
        let collider = Collider::from_mesh(mesh, shape).unwrap();
        assert!(!collider.is_degenerate());
        collider.mass_properties().mass()
    }

    #[test]
    fn a_mesh_becomes_a_surface_or_a_hull() {
        let mesh = Mesh::from(Cuboid::new(1.0, 2.0, 3.0));
        let surface = Collider::from_mesh(&mesh, MeshShape::Surface).unwrap();
        assert_eq!(surface.shape().as_trimesh().unwrap().indices().len(), 12);
        for shape in [MeshShape::ConvexHull, MeshShape::Cuboid] {
            assert!((volume(&mesh, shape) - 6.0).abs() < 1e-4);
        }
    }

    #[test]
    fn simple_shapes_fit_meshes_at_any_place_and_along_any_axis() {
        let turns = [
            Quat::IDENTITY,
            Quat::from_rotation_x(1.570_796_4),
            Quat::from_rotation_z(1.570_796_4),
        ];
        for (turn, at) in turns
            .into_iter()
            .flat_map(|turn| [Vec3::ZERO, Vec3::new(2.0, -1.0, 0.5)].map(|at| (turn, at)))
        {
            let placed = |mesh: Mesh| mesh.rotated_by(turn).translated_by(at);
            let check = |mesh: Mesh, shape: MeshShape, expected: f32| {
                let collider = Collider::from_mesh(&placed(mesh), shape).unwrap();
                let mass = collider.mass_properties();
                assert!(
                    (mass.mass() / expected - 1.0).abs() < 0.03,
                    "{shape:?}: {} {expected}",
                    mass.mass()
                );
                assert!(mass.local_com.distance(at) < 1e-3, "{shape:?} at {at}");
            };
            check(Cuboid::new(0.5, 1.0, 2.0).into(), MeshShape::Cuboid, 1.0);
            check(Sphere::new(0.6).into(), MeshShape::Ball, 0.9048);
            check(Capsule3d::new(0.3, 1.0).into(), MeshShape::Capsule, 0.3958);
            check(Cylinder::new(0.4, 1.5).into(), MeshShape::Cylinder, 0.754);
            // A coin.
            check(Cylinder::new(0.4, 0.1).into(), MeshShape::Cylinder, 0.0503);
        }
    }

    #[test]
    fn meshes_without_what_a_shape_needs_are_errors() {
        let positions = |points: Vec<[f32; 3]>| {
            Mesh::new(PrimitiveTopology::TriangleList, Default::default())
                .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, points)
        };
        let flat = positions(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]);
        let error = |mesh: &Mesh, shape| Collider::from_mesh(mesh, shape).unwrap_err().to_string();
        for shape in [MeshShape::Cuboid, MeshShape::Capsule, MeshShape::Cylinder] {
            assert!(
                error(&flat, shape).contains("no extent along y"),
                "{shape:?}"
            );
        }
        assert!(error(&flat, MeshShape::ConvexHull).contains("not in one plane"));
        let decomposition = MeshShape::Decomposition(DecompositionSettings::default());
        assert!(error(&flat, decomposition).contains("encloses no volume"));
        assert!(Collider::from_mesh(&flat, MeshShape::Surface).is_ok());
        let all = [
            MeshShape::Surface,
            MeshShape::ConvexHull,
            decomposition,
            MeshShape::Cuboid,
            MeshShape::Ball,
            MeshShape::Capsule,
            MeshShape::Cylinder,
        ];
        for shape in all {
            assert!(error(&positions(Vec::new()), shape).contains("no triangles"));
            let point = positions(vec![[f32::NAN, 0.0, 0.0]; 3]);
            assert!(error(&point, shape).contains("not finite"), "{shape:?}");
            let lines = Mesh::new(PrimitiveTopology::LineList, Default::default())
                .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, vec![[0.0; 3]; 2]);
            assert!(error(&lines, shape).contains("does not consist of triangles"));
        }
        let point = positions(vec![[1.0; 3]; 3]);
        assert!(error(&point, MeshShape::Ball).contains("one point"));
    }
}
