//! Scaled, mirrored and sheared shapes, for the scale of a `Transform` and of those above it.
//!
//! A shape stays what it is where it can: a cuboid is scaled along each axis, a cylinder along its axis and evenly across it, a ball
//! evenly. Otherwise a convex shape becomes the convex hull of points on its scaled surface. Meshes are scaled vertex by vertex.

use super::solid::Solid;
use super::{Collider, ColliderError};
use glam::{Mat3, Quat, Vec3};
use parry3d::math::Pose as ParryPose;
use parry3d::shape::{Cone, Cylinder, Shape, SharedShape, TriMesh, TypedShape};
use std::f32::consts::TAU;

/// Numbers of directions in which the surface of a round shape is sampled: around the y axis, and from pole to pole.
const DIRECTIONS_AROUND: usize = 24;
const DIRECTIONS_ACROSS: usize = 9;

/// Cosines and lengths that differ by less than this count as equal.
const EQUAL_DIFFERENCE: f32 = 1e-5;

impl Collider {
    /// The shape scaled along the axes of its frame; negative factors mirror it.
    ///
    /// Cuboids, hulls, triangles, meshes, half-spaces and compounds follow any scale. Balls, capsules and rounded shapes stay round if all
    /// factors are equal, cylinders and cones if those of x and z are; otherwise they become convex hulls with some 200 corners.
    ///
    /// ```
    /// use drystone::prelude::*;
    ///
    /// let plank = Collider::cuboid(1.0, 1.0, 1.0).scaled(Vec3::new(2.0, 0.05, 0.3)).unwrap();
    /// assert_eq!(plank.half_extents(), Vec3::new(1.0, 0.025, 0.15));
    /// let egg = Collider::ball(0.5).scaled(Vec3::new(1.0, 1.5, 1.0)).unwrap();
    /// assert!((egg.half_extents().y - 0.75).abs() < 1e-3);
    /// ```
    ///
    /// # Errors
    /// [`ColliderError::InvalidScale`] if a factor is zero or not finite, or if a height field is to be mirrored. Errors of hulls and
    /// meshes if the scaled one is degenerate.
    pub fn scaled(&self, scale: Vec3) -> Result<Self, ColliderError> {
        if scale == Vec3::ONE {
            return Ok(self.clone());
        }
        let (rotation, mapped) = self.mapped(Mat3::from_diagonal(scale))?;
        match rotation == Quat::IDENTITY {
            true => Ok(mapped),
            // A mirrored shape that is not symmetric.
            false => self.hull_of_mapped(Mat3::from_diagonal(scale)),
        }
    }

    /// The convex parts of the shape after a linear map and a translation (m), each with its pose. Other shapes are one part.
    pub(crate) fn pieces(
        &self,
        map: Mat3,
        translation: Vec3,
    ) -> Result<Vec<(ParryPose, Self)>, ColliderError> {
        let Some(compound) = self.shape.as_compound() else {
            let (rotation, mapped) = self.mapped(map)?;
            return Ok(vec![(ParryPose::from_parts(translation, rotation), mapped)]);
        };
        let parts = compound.shapes().iter().zip(self.part_solids());
        let parts = parts.map(|((at, shape), solid)| {
            let part = Self {
                shape: shape.clone(),
                solid,
            };
            let (rotation, mapped) = part.mapped(map * Mat3::from_quat(at.rotation))?;
            let translation = translation + map * at.translation;
            Ok((ParryPose::from_parts(translation, rotation), mapped))
        });
        parts.collect()
    }

    fn part_solids(&self) -> Vec<Solid> {
        match &self.solid {
            Solid::Parts(parts) => parts
                .iter()
                .map(|part| part.clone().map_or(Solid::Other, Solid::Hull))
                .collect(),
            _ => Vec::new(),
        }
    }

    /// A compound of pieces, or the piece itself if there is only one and it is at the origin.
    pub(crate) fn of_pieces(mut pieces: Vec<(ParryPose, Self)>) -> Self {
        if pieces.len() == 1 && pieces[0].0 == ParryPose::IDENTITY {
            return pieces.remove(0).1;
        }
        let solid = Solid::Parts(pieces.iter().map(|(_, piece)| piece.solid.hull()).collect());
        let shapes = pieces.into_iter().map(|(at, piece)| (at, piece.shape));
        let shape = SharedShape::compound(shapes.collect());
        Self { shape, solid }
    }

    /// The shape after a linear map, as a rotation of a shape.
    fn mapped(&self, map: Mat3) -> Result<(Quat, Self), ColliderError> {
        if !map.is_finite() || map.determinant() == 0.0 {
            return Err(ColliderError::InvalidScale);
        }
        if self.shape.as_compound().is_some() {
            return Ok((
                Quat::IDENTITY,
                Self::of_pieces(self.pieces(map, Vec3::ZERO)?),
            ));
        }
        // Columns are the images of the axes. The map is a scale and then a rotation if they are perpendicular.
        let mut scale = Vec3::new(
            map.x_axis.length(),
            map.y_axis.length(),
            map.z_axis.length(),
        );
        let mut axes = Mat3::from_cols(
            map.x_axis / scale.x,
            map.y_axis / scale.y,
            map.z_axis / scale.z,
        );
        let skew = [
            axes.x_axis.dot(axes.y_axis),
            axes.y_axis.dot(axes.z_axis),
            axes.z_axis.dot(axes.x_axis),
        ];
        if skew.iter().any(|cosine| cosine.abs() > EQUAL_DIFFERENCE) {
            return Ok((Quat::IDENTITY, self.hull_of_mapped(map)?));
        }
        let diagonal = Vec3::new(map.x_axis.x, map.y_axis.y, map.z_axis.z);
        let rotation = match map == Mat3::from_diagonal(diagonal) {
            true => {
                scale = diagonal;
                Quat::IDENTITY
            }
            false => {
                if axes.determinant() < 0.0 {
                    axes.x_axis = -axes.x_axis;
                    scale.x = -scale.x;
                }
                Quat::from_mat3(&axes).normalize()
            }
        };
        let is_one = |s: &f32| (s - 1.0).abs() <= f32::EPSILON * 4.0;
        let scaled = match scale.to_array().iter().all(is_one) {
            true => self.clone(),
            false => self.stretched(scale)?,
        };
        Ok((rotation, scaled))
    }

    /// The shape after a scale along its axes.
    fn stretched(&self, scale: Vec3) -> Result<Self, ColliderError> {
        let even = |a: f32, b: f32| (a.abs() - b.abs()).abs() <= EQUAL_DIFFERENCE * a.abs();
        let uniform = even(scale.x, scale.y) && even(scale.x, scale.z);
        let size = scale.abs();
        let shape = match self.shape.as_typed_shape() {
            TypedShape::Ball(ball) if uniform => SharedShape::ball(ball.radius * size.x),
            TypedShape::Cuboid(cuboid) => {
                let half = cuboid.half_extents * size;
                SharedShape::cuboid(half.x, half.y, half.z)
            }
            TypedShape::RoundCuboid(round) if uniform => {
                let half = round.inner_shape.half_extents * size;
                SharedShape::round_cuboid(half.x, half.y, half.z, round.border_radius * size.x)
            }
            TypedShape::Capsule(capsule) if uniform => SharedShape::capsule(
                capsule.segment.a * scale,
                capsule.segment.b * scale,
                capsule.radius * size.x,
            ),
            TypedShape::Cylinder(cylinder) if even(scale.x, scale.z) => {
                SharedShape::new(Cylinder {
                    half_height: cylinder.half_height * size.y,
                    radius: cylinder.radius * size.x,
                })
            }
            TypedShape::Cone(cone) if even(scale.x, scale.z) && scale.y > 0.0 => {
                SharedShape::new(Cone {
                    half_height: cone.half_height * size.y,
                    radius: cone.radius * size.x,
                })
            }
            TypedShape::HalfSpace(plane) => return Ok(Self::half_space(plane.normal / scale)),
            TypedShape::HeightField(field) if scale.min_element() > 0.0 => {
                SharedShape::new(field.clone().scaled(scale))
            }
            TypedShape::HeightField(_) => return Err(ColliderError::InvalidScale),
            _ => return self.hull_of_mapped(Mat3::from_diagonal(scale)),
        };
        Ok(shape.into())
    }

    /// The hull of points on the mapped surface of a convex shape; a mapped mesh.
    fn hull_of_mapped(&self, map: Mat3) -> Result<Self, ColliderError> {
        let mesh = |mesh: &TriMesh| {
            let vertices = mesh.vertices().iter().map(|v| map * *v).collect();
            let mirrored = map.determinant() < 0.0;
            let triangles = mesh.indices().iter().map(|&[a, b, c]| match mirrored {
                true => [a, c, b],
                false => [a, b, c],
            });
            Self::trimesh(vertices, triangles.collect())
        };
        match self.shape.as_typed_shape() {
            TypedShape::TriMesh(found) => mesh(found),
            TypedShape::HeightField(field) => {
                let (vertices, triangles) = field.to_trimesh();
                let found = TriMesh::new(vertices, triangles);
                mesh(&found.map_err(|e| ColliderError::InvalidMesh(e.to_string()))?)
            }
            TypedShape::Triangle(triangle) => {
                let [a, mut b, mut c] = [triangle.a, triangle.b, triangle.c].map(|p| map * p);
                if map.determinant() < 0.0 {
                    std::mem::swap(&mut b, &mut c);
                }
                Ok(Self::triangle(a, b, c))
            }
            TypedShape::HalfSpace(plane) => {
                Ok(Self::half_space(map.inverse().transpose() * plane.normal))
            }
            _ => {
                let points = match &self.solid {
                    Solid::Hull(hull) => hull.points.to_vec(),
                    _ => surface_points(&*self.shape),
                };
                let points: Vec<Vec3> = points.into_iter().map(|p| map * p).collect();
                Self::convex_hull(&points)
            }
        }
    }
}

/// Points on the surface of a convex shape: its corners, or points in many directions.
fn surface_points(shape: &dyn Shape) -> Vec<Vec3> {
    if let Some(cuboid) = shape.as_cuboid() {
        let sign = |i: u8, axis: u8| if i >> axis & 1 == 0 { -1.0 } else { 1.0 };
        let corners = (0..8).map(|i| Vec3::new(sign(i, 0), sign(i, 1), sign(i, 2)));
        return corners.map(|corner| corner * cuboid.half_extents).collect();
    }
    let Some(surface) = shape.as_support_map() else {
        return Vec::new();
    };
    let turn = |share: f32| (bevy_math::ops::sin(share), bevy_math::ops::cos(share));
    let mut directions = vec![Vec3::Y, Vec3::NEG_Y];
    for ring in 1..DIRECTIONS_ACROSS {
        let (across, up) = turn(0.5 * TAU * ring as f32 / DIRECTIONS_ACROSS as f32);
        for i in 0..DIRECTIONS_AROUND {
            let (z, x) = turn(TAU * i as f32 / DIRECTIONS_AROUND as f32);
            directions.push(Vec3::new(across * x, up, across * z));
        }
    }
    let mut points: Vec<Vec3> = Vec::with_capacity(directions.len());
    for direction in directions {
        let point = surface.local_support_point(direction);
        if !points.contains(&point) {
            points.push(point);
        }
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn volumes_follow_the_determinant() {
        let shapes = [
            Collider::ball(0.5),
            Collider::cuboid(1.0, 0.5, 0.25),
            Collider::cylinder(0.3, 1.0),
            Collider::cone(0.3, 1.0),
            Collider::capsule(0.3, 1.0),
            Collider::wedge(1.0, 0.5, 2.0).unwrap(),
            Collider::round_cuboid(0.8, 0.3, 0.5, 0.1),
        ];
        let turn = Mat3::from_quat(Quat::from_rotation_z(0.7));
        let maps = [
            Mat3::from_diagonal(Vec3::splat(2.0)),
            Mat3::from_diagonal(Vec3::new(1.0, 2.0, 3.0)),
            Mat3::from_diagonal(Vec3::new(-2.0, 1.0, 2.0)),
            turn * Mat3::from_diagonal(Vec3::new(1.0, 2.0, 1.0)),
            Mat3::from_diagonal(Vec3::new(1.0, 2.0, 1.0)) * turn,
        ];
        for shape in shapes {
            let volume = shape.mass_properties().mass();
            for map in maps {
                let pieces = shape.pieces(map, Vec3::X).unwrap();
                let whole = Collider::of_pieces(pieces);
                let found = whole.mass_properties();
                let expected = volume * map.determinant().abs();
                // A hull is inside the shape that it stands for.
                let error = found.mass() / expected - 1.0;
                assert!((-0.06..1e-4).contains(&error), "{shape:?} {map:?}: {error}");
                assert!(whole.shape().is_convex() || whole.shape().as_compound().is_some());
            }
        }
    }

    #[test]
    fn a_mirrored_mesh_keeps_its_outside() {
        let floor = [Vec3::ZERO, Vec3::Z, Vec3::X];
        let mesh = Collider::trimesh(floor.to_vec(), vec![[0, 1, 2]]).unwrap();
        for scale in [Vec3::new(-1.0, 1.0, 1.0), Vec3::new(2.0, 1.0, 3.0)] {
            let scaled = mesh.scaled(scale).unwrap();
            let triangle = scaled.shape().as_trimesh().unwrap().triangle(0);
            assert!(triangle.normal().unwrap().y > 0.99, "{scale}");
        }
        let flat = Collider::ball(1.0).scaled(Vec3::new(1.0, 0.0, 1.0));
        assert_eq!(flat.unwrap_err(), ColliderError::InvalidScale);
    }
}
