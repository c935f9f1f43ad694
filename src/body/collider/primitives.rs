//! Colliders from the primitive shapes of [`bevy_shape`], which meshes and gizmos are made from too.
//!
//! Shapes that always make a collider convert with `From`, the others with `TryFrom`. Lines and curves have no inside, and do not convert.

use super::{Collider, ColliderError};
use bevy_shape::{
    Capsule3d, Cone, ConicalFrustum, Cuboid, Cylinder, InfinitePlane3d, Plane3d, Sphere,
    Tetrahedron, Torus, Triangle3d,
};
use glam::{Quat, Vec3};
use std::f32::consts::TAU;

/// Number of corners of a circle that becomes part of a convex hull.
const CIRCLE_CORNERS: usize = 32;

/// Number of convex parts of a ring, and of corners of its tube.
const RING_PARTS: usize = 24;
const TUBE_CORNERS: usize = 12;

impl From<Sphere> for Collider {
    fn from(sphere: Sphere) -> Self {
        Self::ball(sphere.radius)
    }
}

impl From<Cuboid> for Collider {
    fn from(cuboid: Cuboid) -> Self {
        let size = 2.0 * cuboid.half_size;
        Self::cuboid(size.x, size.y, size.z)
    }
}

impl From<Cylinder> for Collider {
    fn from(cylinder: Cylinder) -> Self {
        Self::cylinder(cylinder.radius, 2.0 * cylinder.half_height)
    }
}

impl From<Capsule3d> for Collider {
    fn from(capsule: Capsule3d) -> Self {
        Self::capsule(capsule.radius, 2.0 * capsule.half_length)
    }
}

impl From<Cone> for Collider {
    fn from(cone: Cone) -> Self {
        Self::cone(cone.radius, cone.height)
    }
}

/// The half-space below the plane.
impl From<InfinitePlane3d> for Collider {
    fn from(plane: InfinitePlane3d) -> Self {
        Self::half_space(*plane.normal)
    }
}

/// One triangle, for static bodies.
impl From<Triangle3d> for Collider {
    fn from(triangle: Triangle3d) -> Self {
        let [a, b, c] = triangle.vertices;
        Self::triangle(a, b, c)
    }
}

/// A rectangle of two triangles, for static and kinematic bodies. It stops bodies from the side that its normal points to.
impl TryFrom<Plane3d> for Collider {
    type Error = ColliderError;

    fn try_from(plane: Plane3d) -> Result<Self, ColliderError> {
        let turn = Quat::from_rotation_arc(Vec3::Y, *plane.normal);
        let corner = |(x, z): (f32, f32)| {
            turn * Vec3::new(x * plane.half_size.x, 0.0, z * plane.half_size.y)
        };
        let corners = [(-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (1.0, -1.0)];
        Self::trimesh(corners.map(corner).to_vec(), vec![[0, 1, 2], [0, 2, 3]])
    }
}

impl TryFrom<Tetrahedron> for Collider {
    type Error = ColliderError;

    fn try_from(tetrahedron: Tetrahedron) -> Result<Self, ColliderError> {
        Self::convex_hull(&tetrahedron.vertices)
    }
}

/// A convex hull whose circles have 32 corners; a cone or cylinder if the radii allow it.
impl TryFrom<ConicalFrustum> for Collider {
    type Error = ColliderError;

    fn try_from(frustum: ConicalFrustum) -> Result<Self, ColliderError> {
        let (top, bottom, height) = (frustum.radius_top, frustum.radius_bottom, frustum.height);
        if top == bottom {
            return Ok(Self::cylinder(top, height));
        }
        if top == 0.0 {
            return Ok(Self::cone(bottom, height));
        }
        let mut points = Vec::with_capacity(2 * CIRCLE_CORNERS);
        for (radius, y) in [(bottom, -0.5 * height), (top, 0.5 * height)] {
            match radius == 0.0 {
                true => points.push(Vec3::Y * y),
                false => points.extend(
                    circle(CIRCLE_CORNERS).map(|(x, z)| Vec3::new(radius * x, y, radius * z)),
                ),
            }
        }
        Self::convex_hull(&points)
    }
}

/// A ring in the x–z plane: a compound of 24 convex parts with a hole in its middle.
impl TryFrom<Torus> for Collider {
    type Error = ColliderError;

    fn try_from(torus: Torus) -> Result<Self, ColliderError> {
        let (tube, ring) = (torus.minor_radius, torus.major_radius);
        // Without a hole the parts would not be convex.
        if !(0.0 < tube && tube < ring) {
            return Err(ColliderError::InvalidCompound);
        }
        let disc = |(along_x, along_z): (f32, f32)| {
            circle(TUBE_CORNERS).map(move |(out, up)| {
                let from_axis = ring + tube * out;
                Vec3::new(from_axis * along_x, tube * up, from_axis * along_z)
            })
        };
        let places: Vec<(f32, f32)> = circle(RING_PARTS).collect();
        let parts = (0..RING_PARTS).map(|i| {
            let ends = [places[i], places[(i + 1) % RING_PARTS]];
            let points: Vec<Vec3> = ends.into_iter().flat_map(disc).collect();
            Ok((Vec3::ZERO, Quat::IDENTITY, Self::convex_hull(&points)?))
        });
        Self::compound(parts.collect::<Result<_, ColliderError>>()?)
    }
}

/// The corners of a regular polygon in the unit circle.
fn circle(corners: usize) -> impl Iterator<Item = (f32, f32)> {
    (0..corners).map(move |i| {
        let angle = TAU * i as f32 / corners as f32;
        (bevy_math::ops::cos(angle), bevy_math::ops::sin(angle))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy_shape::Measured3d;

    fn check(collider: Collider, expected: impl Measured3d, least: f32) {
        let share = collider.mass_properties().mass() / expected.volume();
        assert!((least..1.0001).contains(&share), "{collider:?}: {share}");
        assert!(!collider.is_degenerate());
    }

    #[test]
    fn volumes_are_those_of_the_primitives() {
        check(Sphere::new(0.7).into(), Sphere::new(0.7), 0.9999);
        let cuboid = Cuboid::new(1.0, 2.0, 3.0);
        check(cuboid.into(), cuboid, 0.9999);
        let cylinder = Cylinder::new(0.4, 1.2);
        check(cylinder.into(), cylinder, 0.9999);
        let capsule = Capsule3d::new(0.4, 1.2);
        check(capsule.into(), capsule, 0.9999);
        let cone = Cone::new(0.4, 1.2);
        check(cone.into(), cone, 0.9999);
        let tetrahedron = Tetrahedron::default();
        check(tetrahedron.try_into().unwrap(), tetrahedron, 0.9999);
        let torus = Torus::new(0.5, 1.0);
        check(torus.try_into().unwrap(), torus, 0.93);
        let frustum = ConicalFrustum {
            radius_top: 0.3,
            radius_bottom: 0.6,
            height: 1.0,
        };
        let volume = std::f32::consts::PI / 3.0 * (0.09 + 0.18 + 0.36);
        let found = Collider::try_from(frustum).unwrap().mass_properties();
        assert!((0.99..1.0).contains(&(found.mass() / volume)));
        assert!(found.local_com.y < 0.0);
    }

    #[test]
    fn planes_face_along_their_normal() {
        let slope = Plane3d::new(Vec3::new(1.0, 1.0, 0.0), glam::Vec2::new(2.0, 3.0));
        let collider = Collider::try_from(slope).unwrap();
        let mesh = collider.shape().as_trimesh().unwrap();
        for triangle in mesh.triangles() {
            assert!(triangle.normal().unwrap().dot(*slope.normal) > 0.999);
        }
        let floor: Collider = InfinitePlane3d::new(Vec3::Z).into();
        assert_eq!(floor.shape().as_halfspace().unwrap().normal, Vec3::Z);
        let flat = Torus {
            minor_radius: 1.0,
            major_radius: 0.5,
        };
        assert!(Collider::try_from(flat).is_err());
    }
}
