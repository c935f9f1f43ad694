//! Meshes of shapes: flat faces with bevelled edges, which catch the light.

use crate::pieces::Shape;
use bevy::asset::RenderAssetUsages;
use bevy::mesh::{Indices, PrimitiveTopology};
use bevy::platform::collections::HashMap;
use bevy::prelude::*;
use drystone::collider::Polyhedron;

/// How far a bevel reaches into a face, m, at most, and as a share of the shape.
const BEVEL: f32 = 0.02;
const BEVEL_SHARE: f32 = 0.12;

/// The mesh of a shape. One that has no size has none either.
pub fn mesh_of(shape: &Shape) -> Mesh {
    match shape {
        Shape::Ball(radius) => Sphere::new(*radius).mesh().uv(32, 18),
        Shape::Hull(points) => bevelled(points),
        Shape::Box(size) => {
            let half = 0.5 * *size;
            let corner = |i: u32| {
                let side = |bit: u32| if i >> bit & 1 == 0 { -1.0 } else { 1.0 };
                half * Vec3::new(side(0), side(1), side(2))
            };
            let corners: Vec<Vec3> = (0..8).map(corner).collect();
            bevelled(&corners)
        }
    }
}

/// Vertices of a mesh and its triangles.
#[derive(Default)]
struct Sketch {
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
    triangles: Vec<u32>,
}

impl Sketch {
    /// A convex polygon, counterclockwise, by its vertices' numbers.
    fn polygon(&mut self, corners: &[u32]) {
        for pair in corners[1..].windows(2) {
            self.triangles.extend([corners[0], pair[0], pair[1]]);
        }
    }
}

/// Each face is drawn in a little; strips between neighbours and caps at corners, whose normals are those of the faces, look rounded.
fn bevelled(points: &[Vec3]) -> Mesh {
    let mut sketch = Sketch::default();
    if let Ok(hull) = Polyhedron::new(points) {
        let bevel = BEVEL.min(BEVEL_SHARE * 2.0 * hull.inner);
        // The vertex of a face at a corner.
        let mut vertices: HashMap<(usize, u16), u32> = HashMap::default();
        for (number, face) in hull.faces.iter().enumerate() {
            let corners = hull.corners_of(number);
            let count = corners.len();
            let at = |i: usize| hull.points[corners[i % count] as usize];
            let first = sketch.positions.len() as u32;
            for (i, &corner) in corners.iter().enumerate() {
                let (here, next) = (at(i), at(i + 1));
                let back = (at(i + count - 1) - here).normalize_or_zero();
                let on = (next - here).normalize_or_zero();
                let sine = back.cross(on).length().max(0.2);
                sketch.positions.push(here + (back + on) * (bevel / sine));
                sketch.normals.push(face.normal);
                vertices.insert((number, corner), first + i as u32);
            }
            let polygon: Vec<u32> = (first..first + count as u32).collect();
            sketch.polygon(&polygon);
        }
        // Each edge is in one face from a to b, and in another from b to a.
        let mut sides: HashMap<(u16, u16), usize> = HashMap::default();
        for number in 0..hull.faces.len() {
            let corners = hull.corners_of(number);
            for i in 0..corners.len() {
                let [a, b] = [i, i + 1].map(|i| corners[i % corners.len()]);
                sides.insert((a, b), number);
            }
        }
        for (&(a, b), &face) in &sides {
            let Some(&other) = sides.get(&(b, a)).filter(|&&other| face < other) else {
                continue;
            };
            sketch.polygon(&[
                vertices[&(face, b)],
                vertices[&(face, a)],
                vertices[&(other, a)],
                vertices[&(other, b)],
            ]);
        }
        // Around a corner, from each face over the edge that leaves it to the next.
        for corner in 0..hull.points.len() as u16 {
            let leaves = |face: usize| {
                let corners = hull.corners_of(face);
                let i = corners.iter().position(|&of| of == corner)?;
                Some(corners[(i + corners.len() - 1) % corners.len()])
            };
            let around = hull.faces_around(corner as usize);
            let Some(&first) = around.first() else {
                continue;
            };
            let (mut face, mut cap) = (first as usize, Vec::new());
            for _ in 0..around.len() {
                cap.push(vertices[&(face, corner)]);
                let next = leaves(face).and_then(|to| sides.get(&(corner, to)));
                let Some(&next) = next else {
                    break;
                };
                face = next;
            }
            if cap.len() > 2 {
                sketch.polygon(&cap);
            }
        }
    }
    Mesh::new(
        PrimitiveTopology::TriangleList,
        RenderAssetUsages::default(),
    )
    .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, sketch.positions)
    .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, sketch.normals)
    .with_inserted_indices(Indices::U32(sketch.triangles))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every triangle faces outwards, and every edge of the mesh is in two triangles.
    #[test]
    fn a_bevelled_hull_is_closed() {
        let wedge: Vec<Vec3> = [
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, 0.0, 1.0],
            [1.0, 0.0, 1.0],
            [0.0, 1.0, 1.0],
        ]
        .map(Vec3::from)
        .into();
        let middle = Vec3::splat(0.4);
        let wedge: Vec<Vec3> = wedge.iter().map(|point| *point - middle).collect();
        for mesh in [
            bevelled(&wedge),
            mesh_of(&Shape::Box(Vec3::new(1.0, 0.5, 0.3))),
        ] {
            let positions = mesh.attribute(Mesh::ATTRIBUTE_POSITION).unwrap();
            let positions = positions.as_float3().unwrap();
            let Some(Indices::U32(triangles)) = mesh.indices() else {
                panic!("it has indices");
            };
            let mut edges: HashMap<(u32, u32), i32> = HashMap::default();
            for triangle in triangles.chunks(3) {
                let [a, b, c] = [0, 1, 2].map(|i| Vec3::from(positions[triangle[i] as usize]));
                let out = (b - a).cross(c - a);
                assert!(out.dot(a + b + c) > 0.0, "{triangle:?} faces inwards");
                for i in 0..3 {
                    let (from, to) = (triangle[i], triangle[(i + 1) % 3]);
                    *edges.entry((from, to)).or_default() += 1;
                    *edges.entry((to, from)).or_default() -= 1;
                }
            }
            assert!(edges.values().all(|&balance| balance == 0));
        }
    }
}
