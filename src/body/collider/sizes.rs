//! Whether a shape has a size that contacts can be computed with.

use crate::limits;
use glam::Vec3;
use parry3d::shape::{Shape, TypedShape};

/// A length from the smallest to the largest that there may be.
fn length(x: f32) -> bool {
    (limits::SMALLEST..=limits::LARGEST).contains(&x)
}

fn lengths(v: Vec3) -> bool {
    v.to_array().into_iter().all(length)
}

/// All sizes are within [`limits`]. A surface may be flat in one direction, never in two.
pub(super) fn are_valid(shape: &dyn Shape) -> bool {
    match shape.as_typed_shape() {
        TypedShape::Ball(ball) => length(ball.radius),
        TypedShape::Cuboid(cuboid) => lengths(cuboid.half_extents),
        TypedShape::Capsule(capsule) => {
            let ends = [capsule.segment.a, capsule.segment.b];
            length(capsule.radius) && ends.iter().all(|v| limits::within(*v, limits::LARGEST))
        }
        TypedShape::Cylinder(cylinder) => length(cylinder.radius) && length(cylinder.half_height),
        TypedShape::Cone(cone) => length(cone.radius) && length(cone.half_height),
        TypedShape::HalfSpace(plane) => plane.normal.is_normalized(),
        TypedShape::Compound(compound) => compound.shapes().iter().all(|(at, part)| {
            limits::within(at.translation, limits::LARGEST) && are_valid(&**part)
        }),
        TypedShape::RoundCuboid(round) => {
            length(round.border_radius) && lengths(round.inner_shape.half_extents)
        }
        TypedShape::RoundCylinder(round) => {
            let inner = &round.inner_shape;
            [round.border_radius, inner.radius, inner.half_height]
                .into_iter()
                .all(length)
        }
        TypedShape::RoundCone(round) => {
            let inner = &round.inner_shape;
            [round.border_radius, inner.radius, inner.half_height]
                .into_iter()
                .all(length)
        }
        TypedShape::RoundTriangle(round) => {
            length(round.border_radius) && is_extended(&round.inner_shape)
        }
        TypedShape::RoundConvexPolyhedron(round) => {
            length(round.border_radius) && is_extended(&round.inner_shape)
        }
        // Parry divides by the size of a cell.
        TypedShape::HeightField(field) => {
            length(field.cell_width()) && length(field.cell_height()) && is_extended(shape)
        }
        _ => is_extended(shape),
    }
}

fn is_extended(shape: &dyn Shape) -> bool {
    let aabb = shape.compute_local_aabb();
    let size = aabb.maxs - aabb.mins;
    let sizes = size.to_array();
    limits::within(aabb.mins, limits::LARGEST)
        && limits::within(aabb.maxs, limits::LARGEST)
        && sizes.iter().all(|size| *size >= 0.0)
        && sizes.iter().filter(|size| length(**size)).count() >= 2
}

/// True for two shapes of a simple kind with the same numbers.
pub(super) fn are_equal(a: &dyn Shape, b: &dyn Shape) -> bool {
    match (a.as_typed_shape(), b.as_typed_shape()) {
        (TypedShape::Ball(a), TypedShape::Ball(b)) => a.radius == b.radius,
        (TypedShape::Cuboid(a), TypedShape::Cuboid(b)) => a.half_extents == b.half_extents,
        (TypedShape::HalfSpace(a), TypedShape::HalfSpace(b)) => a.normal == b.normal,
        (TypedShape::Capsule(a), TypedShape::Capsule(b)) => {
            (a.segment, a.radius) == (b.segment, b.radius)
        }
        (TypedShape::Cylinder(a), TypedShape::Cylinder(b)) => {
            (a.radius, a.half_height) == (b.radius, b.half_height)
        }
        _ => false,
    }
}
