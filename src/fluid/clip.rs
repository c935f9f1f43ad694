//! Polyhedra and meshes that a surface cuts.

use super::wet::{Around, Wet};
use crate::body::collider::{BOX_FACES, Polyhedron, octant};
use glam::Vec3;
use parry3d::math::Pose as ParryPose;
use parry3d::shape::{Cuboid, TriMesh};

pub(super) fn add_box(wet: &mut Wet, cuboid: &Cuboid, at: &ParryPose, around: &Around) {
    let corners: [Vec3; 8] = std::array::from_fn(|i| *at * (cuboid.half_extents * octant(i)));
    for face in BOX_FACES {
        let [a, b, c, d] = face.map(|of| corners[of as usize]);
        add_triangle(wet, [a, b, c], around);
        add_triangle(wet, [a, c, d], around);
    }
}

pub(super) fn add_hull(wet: &mut Wet, hull: &Polyhedron, at: &ParryPose, around: &Around) {
    let place = |corner: u16| *at * hull.points[usize::from(corner)];
    for face in 0..hull.faces.len() {
        let corners = hull.corners_of(face);
        let first = place(corners[0]);
        let mut last = place(corners[1]);
        for &corner in &corners[2..] {
            let next = place(corner);
            add_triangle(wet, [first, last, next], around);
            last = next;
        }
    }
}

pub(super) fn add_mesh(wet: &mut Wet, mesh: &TriMesh, at: &ParryPose, around: &Around) {
    let points = mesh.vertices();
    for triangle in mesh.indices() {
        let corners = triangle.map(|corner| *at * points[corner as usize]);
        add_triangle(wet, corners, around);
    }
}

/// Adds what is wet of a triangle of a closed surface, counterclockwise as seen from outside.
///
/// The volume below the surface of the fluid is the signed sum of the tetrahedra from a point in that surface to the wet triangles. The
/// cut itself lies in the surface, so it would add nothing.
#[inline]
fn add_triangle(wet: &mut Wet, corners: [Vec3; 3], around: &Around) {
    let depths = corners.map(|corner| around.depth(corner));
    let is_wet = depths.map(|depth| depth > 0.0);
    match is_wet.iter().filter(|wet| **wet).count() {
        0 => (),
        3 => add_wet(wet, corners, around),
        1 => {
            let i = is_wet.iter().position(|wet| *wet).unwrap_or(0);
            let [j, k] = [(i + 1) % 3, (i + 2) % 3];
            let cut =
                |to: usize| corners[i].lerp(corners[to], depths[i] / (depths[i] - depths[to]));
            add_wet(wet, [corners[i], cut(j), cut(k)], around);
        }
        _ => {
            let i = is_wet.iter().position(|wet| !*wet).unwrap_or(0);
            let [j, k] = [(i + 1) % 3, (i + 2) % 3];
            let cut =
                |to: usize| corners[to].lerp(corners[i], depths[to] / (depths[to] - depths[i]));
            let [from, to] = [cut(j), cut(k)];
            add_wet(wet, [from, corners[j], corners[k]], around);
            add_wet(wet, [from, corners[k], to], around);
        }
    }
}

#[inline]
fn add_wet(wet: &mut Wet, [a, b, c]: [Vec3; 3], around: &Around) {
    let origin = around.origin;
    let area = 0.5 * (b - a).cross(c - a);
    let sum = a + b + c;
    let volume = (a - origin).dot(area) / 3.0;
    wet.add_volume(volume, 0.25 * (sum + origin));
    let center = sum / 3.0;
    // Volume that the face sweeps in a second, if it moves into the fluid.
    let swept = around.flow_at(center).dot(area);
    if swept > 0.0 {
        let force = -around.pressure * swept * swept / area.length_squared() * area;
        wet.add_force(force, center);
    }
}
