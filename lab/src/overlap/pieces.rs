//! The convex pieces of bodies that are not convex.

use super::Placed;
use drystone::body::Pose;
use glam::Vec3;
use parry3d::shape::{SharedShape, Triangle};

/// A surface is as deep as this below each of its triangles, m: what is deeper in it is found no deeper.
const SOLID: f32 = 0.5;

/// The convex pieces of a body: the parts of a compound, and of a mesh or height field what lies below each triangle. A body that is
/// convex, a half-space, and a surface that is flat are one piece.
pub fn pieces(pose: Pose, shape: &SharedShape) -> Vec<Placed> {
    let whole = Placed::new(pose, shape.clone());
    if let Some(compound) = shape.as_compound() {
        let place = |(at, part): &(parry3d::math::Pose, SharedShape)| {
            let at = Pose {
                position: pose.position + pose.rotation * at.translation,
                rotation: (pose.rotation * at.rotation).normalize(),
            };
            Placed::new(at, part.clone())
        };
        return compound.shapes().iter().map(place).collect();
    }
    if whole.upwards().is_some() {
        return vec![whole];
    }
    let below = |triangle| Some(Placed::new(pose, prism(&triangle)?));
    if let Some(mesh) = shape.as_trimesh() {
        return mesh.triangles().filter_map(below).collect();
    }
    if let Some(field) = shape.as_heightfield() {
        return field.triangles().filter_map(below).collect();
    }
    vec![whole]
}

/// What lies below a triangle; nothing if it has no area.
fn prism(triangle: &Triangle) -> Option<SharedShape> {
    let down = -SOLID * triangle.normal()?;
    let corners: [Vec3; 3] = [triangle.a, triangle.b, triangle.c];
    let all: Vec<Vec3> = corners
        .into_iter()
        .chain(corners.map(|at| at + down))
        .collect();
    SharedShape::convex_hull(&all)
}
