//! Shapes as Box3D has them, from those of parry.

use crate::scene::SLAB;
use drystone::prelude::{Pose, Quat, Vec3};
use rapier3d::parry::shape::{Shape as ParryShape, SharedShape};

/// A shape in its body's frame, m.
pub enum Shape {
    Box {
        half: Vec3,
        center: Vec3,
        rotation: Quat,
    },
    Sphere {
        center: Vec3,
        radius: f32,
    },
    Capsule {
        ends: [Vec3; 2],
        radius: f32,
    },
    Hull {
        corners: Vec<Vec3>,
    },
    Mesh {
        corners: Vec<Vec3>,
        triangles: Vec<[u32; 3]>,
    },
    /// Its first corner is in the origin of the body.
    Field {
        /// By rows along z.
        heights: Vec<f32>,
        /// Points along x and along z.
        counts: [usize; 2],
        /// Between them along x and z; 1 along y.
        scale: Vec3,
    },
}

/// The shapes of a body: several if it is a compound.
///
/// # Errors
/// If Box3D lacks one.
pub fn shapes(shape: &SharedShape) -> Result<Vec<Shape>, String> {
    let Some(compound) = shape.as_compound() else {
        return Ok(vec![one(&**shape, &Pose::default())?]);
    };
    let parts = compound.shapes().iter();
    let part = |(at, part): &(rapier3d::math::Pose, SharedShape)| {
        let at = Pose {
            position: at.translation,
            rotation: at.rotation,
        };
        one(&**part, &at)
    };
    parts.map(part).collect()
}

fn one(shape: &dyn ParryShape, at: &Pose) -> Result<Shape, String> {
    let place = |point: Vec3| at.position + at.rotation * point;
    Ok(if let Some(cuboid) = shape.as_cuboid() {
        Shape::Box {
            half: cuboid.half_extents,
            center: at.position,
            rotation: at.rotation.normalize(),
        }
    } else if let Some(half_space) = shape.as_halfspace() {
        // Box3D has none: as Rapier's slab, with its upper face where the surface was.
        let up = half_space.normal;
        Shape::Box {
            half: SLAB,
            center: -SLAB.y * up,
            rotation: Quat::from_rotation_arc(Vec3::Y, up),
        }
    } else if let Some(ball) = shape.as_ball() {
        Shape::Sphere {
            center: at.position,
            radius: ball.radius,
        }
    } else if let Some(capsule) = shape.as_capsule() {
        Shape::Capsule {
            ends: [capsule.segment.a, capsule.segment.b].map(place),
            radius: capsule.radius,
        }
    } else if let Some(hull) = shape.as_convex_polyhedron() {
        Shape::Hull {
            corners: hull.points().iter().copied().map(place).collect(),
        }
    } else if let Some(mesh) = shape.as_trimesh() {
        Shape::Mesh {
            corners: mesh.vertices().to_vec(),
            triangles: mesh.indices().to_vec(),
        }
    } else if let Some(field) = shape.as_heightfield() {
        let (rows, columns) = (field.nrows() + 1, field.ncols() + 1);
        let points = (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column)));
        let size = field.scale();
        Shape::Field {
            heights: points.map(|at| size.y * field.heights()[at]).collect(),
            counts: [columns, rows],
            scale: Vec3::new(
                size.x / (columns - 1) as f32,
                1.0,
                size.z / (rows - 1) as f32,
            ),
        }
    } else {
        let lacked = shape.shape_type();
        return Err(format!(
            "Box3D has no shape {lacked:?}, or not as drystone has it"
        ));
    })
}

impl Shape {
    /// From the middle of a field, where parry has its origin, to the corner where Box3D has it, m.
    pub fn offset(&self) -> Option<Vec3> {
        match self {
            Self::Field { counts, scale, .. } => {
                let [x, z] = counts.map(|count| -0.5 * (count - 1) as f32);
                Some(*scale * Vec3::new(x, 0.0, z))
            }
            _ => None,
        }
    }

    pub fn is_sound(&self) -> bool {
        let size = |x: f32| x > 0.0 && x.is_finite();
        let finite = |points: &[Vec3]| points.iter().all(|point| point.is_finite());
        match self {
            Self::Box {
                half,
                center,
                rotation,
            } => {
                half.to_array().into_iter().all(size)
                    && center.is_finite()
                    && rotation.is_normalized()
            }
            Self::Sphere { center, radius } => size(*radius) && center.is_finite(),
            Self::Capsule { ends, radius } => size(*radius) && finite(ends),
            Self::Hull { corners } => finite(corners),
            Self::Mesh { corners, triangles } => {
                let exists = |&i: &u32| (i as usize) < corners.len();
                finite(corners) && triangles.iter().flatten().all(exists)
            }
            Self::Field {
                heights,
                counts,
                scale,
            } => {
                heights.iter().all(|height| height.is_finite())
                    && counts.iter().all(|&count| count > 1)
                    && heights.len() == counts[0] * counts[1]
                    && scale.to_array().into_iter().all(size)
            }
        }
    }
}
