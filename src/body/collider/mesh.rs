//! Colliders from meshes of Bevy (feature `mesh`).

use super::{Collider, ColliderError};
use bevy_mesh::{Indices, Mesh, PrimitiveTopology, VertexAttributeValues};
use glam::Vec3;

/// The kind of collider that a mesh becomes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MeshShape {
    /// A surface without an inside, as [`Collider::trimesh`]: for static and kinematic bodies.
    #[default]
    Surface,
    /// The convex hull of the vertices, as [`Collider::convex_hull`]: for bodies of every kind.
    ConvexHull,
}

impl Collider {
    /// A collider with the vertices of a mesh. For a mesh with hollows that is to move, see [`Collider::convex_decomposition`] with
    /// [`mesh_triangles`].
    ///
    /// # Errors
    /// [`ColliderError::InvalidMesh`] if the mesh is not a list or strip of triangles, has no positions of three numbers, or is not kept in
    /// main memory; other errors as those of [`Collider::trimesh`] and [`Collider::convex_hull`].
    pub fn from_mesh(mesh: &Mesh, shape: MeshShape) -> Result<Self, ColliderError> {
        let (vertices, triangles) = mesh_triangles(mesh)?;
        match shape {
            MeshShape::Surface => Self::trimesh(vertices, triangles),
            MeshShape::ConvexHull => Self::convex_hull(&vertices),
        }
    }
}

/// The vertices (m) and triangles of a mesh.
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
    let triangles = match mesh.primitive_topology() {
        PrimitiveTopology::TriangleList => indices.as_chunks::<3>().0.to_vec(),
        PrimitiveTopology::TriangleStrip => indices
            .array_windows()
            .enumerate()
            .map(|(i, &[a, b, c])| if i % 2 == 0 { [a, b, c] } else { [b, a, c] })
            .collect(),
        _ => return Err(invalid("it does not consist of triangles")),
    };
    Ok((vertices, triangles))
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy_shape::Cuboid;

    #[test]
    fn a_mesh_becomes_a_surface_or_a_hull() {
        let mesh = Mesh::from(Cuboid::new(1.0, 2.0, 3.0));
        let surface = Collider::from_mesh(&mesh, MeshShape::Surface).unwrap();
        assert_eq!(surface.shape().as_trimesh().unwrap().indices().len(), 12);
        let hull = Collider::from_mesh(&mesh, MeshShape::ConvexHull).unwrap();
        assert!((hull.mass_properties().mass() - 6.0).abs() < 1e-4);
    }
}
