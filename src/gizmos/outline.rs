//! The outlines of shapes, in the frame of their body.

use crate::body::collider::Collider;
use glam::Vec3;
use parry3d::shape::{SharedShape, TypedShape};

/// Number of points around a round shape.
const ROUND: u32 = 24;

/// Extent and spacing of the lines that show a half-space, m.
const FIELD: i32 = 10;

/// The lines of a collider.
pub fn lines(collider: &Collider, mut line: impl FnMut([Vec3; 2])) {
    match collider.polyhedron() {
        Some(hull) => {
            for edge in &hull.edges {
                line(edge.ends.map(|end| hull.points[end as usize]));
            }
        }
        None => of_shape(collider.shape(), &mut line),
    }
}

/// The edges of a box.
pub fn box_lines(mins: Vec3, maxs: Vec3, mut line: impl FnMut([Vec3; 2])) {
    let corner = |i: usize| {
        let side = |bit: usize| i >> bit & 1 == 1;
        Vec3::new(
            if side(0) { maxs.x } else { mins.x },
            if side(1) { maxs.y } else { mins.y },
            if side(2) { maxs.z } else { mins.z },
        )
    };
    for i in 0..8 {
        for bit in (0..3).filter(|bit| i >> bit & 1 == 0) {
            line([corner(i), corner(i | 1 << bit)]);
        }
    }
}

fn of_shape(shape: &SharedShape, line: &mut dyn FnMut([Vec3; 2])) {
    let mut outline = |(points, edges): (Vec<Vec3>, Vec<[u32; 2]>)| {
        for ends in edges {
            line(ends.map(|end| points[end as usize]));
        }
    };
    match shape.as_typed_shape() {
        TypedShape::Cuboid(cuboid) => box_lines(-cuboid.half_extents, cuboid.half_extents, line),
        TypedShape::Ball(ball) => outline(ball.to_outline(ROUND)),
        TypedShape::Capsule(capsule) => outline(capsule.to_outline(ROUND)),
        TypedShape::Cylinder(cylinder) => outline(cylinder.to_outline(ROUND)),
        TypedShape::Cone(cone) => outline(cone.to_outline(ROUND)),
        TypedShape::Triangle(triangle) => sides([triangle.a, triangle.b, triangle.c], line),
        TypedShape::TriMesh(mesh) => {
            for triangle in mesh.triangles() {
                sides([triangle.a, triangle.b, triangle.c], line);
            }
        }
        TypedShape::HeightField(field) => {
            for triangle in field.triangles() {
                sides([triangle.a, triangle.b, triangle.c], line);
            }
        }
        TypedShape::HalfSpace(half_space) => {
            let (one, other) = half_space.normal.any_orthonormal_pair();
            let far = FIELD as f32;
            for i in -FIELD..=FIELD {
                for (along, across) in [(one, other), (other, one)] {
                    let middle = i as f32 * across;
                    line([middle - far * along, middle + far * along]);
                }
            }
        }
        TypedShape::Compound(compound) => {
            for (pose, part) in compound.shapes() {
                of_shape(part, &mut |ends| {
                    line(ends.map(|end| pose.transform_point(end)));
                });
            }
        }
        // Other shapes are shown by their boxes.
        _ => {
            let aabb = shape.compute_local_aabb();
            box_lines(aabb.mins, aabb.maxs, line);
        }
    }
}

fn sides([a, b, c]: [Vec3; 3], line: &mut dyn FnMut([Vec3; 2])) {
    for ends in [[a, b], [b, c], [c, a]] {
        line(ends);
    }
}
