//! The part of a shape that is in a fluid: how much it displaces, where, and how the fluid drags it.

use super::clip;
use super::revolved::{self, Revolved};
use crate::body::Velocity;
use crate::body::collider::{Collider, volume};
use glam::Vec3;
use parry3d::math::Pose as ParryPose;
use parry3d::shape::{Cuboid, SharedShape, TypedShape};
use std::f32::consts::PI;

/// The fluid around a part of a body, seen from the centre of mass of the body: positions are relative to that, in world axes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Around {
    /// Unit normal of the surface, out of the fluid.
    pub normal: Vec3,
    /// What is below this distance along the normal is wet, m.
    pub offset: f32,
    /// A point near the body: in the surface, if that cuts it.
    pub origin: Vec3,
    /// How the body moves in the fluid.
    pub velocity: Velocity,
    /// Half the density of the fluid times the drag coefficient, kg/m³.
    pub pressure: f32,
}

impl Around {
    /// How far a place is below the surface, m.
    #[inline]
    pub fn depth(&self, at: Vec3) -> f32 {
        self.offset - self.normal.dot(at)
    }

    /// The velocity of a place of the body in the fluid, m/s.
    #[inline]
    pub fn flow_at(&self, at: Vec3) -> Vec3 {
        self.velocity.at(at)
    }
}

/// What a fluid does to a body, about its centre of mass.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Wet {
    /// Volume in the fluid, m³.
    pub volume: f32,
    /// Volume times its centroid, m⁴.
    pub moment: Vec3,
    /// Force of the drag, N.
    pub force: Vec3,
    /// Its torque, N·m.
    pub torque: Vec3,
}

impl Wet {
    #[inline]
    pub fn add_volume(&mut self, volume: f32, centroid: Vec3) {
        self.volume += volume;
        self.moment += volume * centroid;
    }

    /// Adds a force, N.
    #[inline]
    pub fn add_force(&mut self, force: Vec3, at: Vec3) {
        self.force += force;
        self.torque += at.cross(force);
    }

    /// Adds another part of the body.
    fn add(&mut self, part: &Self) {
        self.volume += part.volume;
        self.moment += part.moment;
        self.force += part.force;
        self.torque += part.torque;
    }

    /// Adds a piece of a compound, or the only piece of another shape, which is number 0. `at` is the place of the whole shape. Surfaces
    /// without an inside displace nothing.
    pub fn add_piece(&mut self, collider: &Collider, piece: u32, at: &ParryPose, around: &Around) {
        let (at, shape, hull) = match collider.shape().as_compound() {
            None => (*at, collider.shape(), collider.polyhedron()),
            Some(compound) => {
                let (local, shape) = &compound.shapes()[piece as usize];
                (*at * *local, shape, collider.part_polyhedron(piece))
            }
        };
        match hull {
            Some(hull) => clip::add_hull(self, hull, &at, around),
            None => self.add_shape(shape, &at, around),
        }
    }

    fn add_shape(&mut self, shape: &SharedShape, at: &ParryPose, around: &Around) {
        let (center, axis) = (at.translation, at.rotation * Vec3::Y);
        match shape.as_typed_shape() {
            TypedShape::Ball(ball) => revolved::add_ball(self, center, ball.radius, around),
            TypedShape::Cuboid(cuboid) => clip::add_box(self, cuboid, at, around),
            TypedShape::Cylinder(cylinder) => {
                let shape = Revolved::cylinder(cylinder.radius, cylinder.half_height);
                shape.add(self, center, axis, around);
            }
            TypedShape::Cone(cone) => {
                Revolved::cone(cone.radius, cone.half_height).add(self, center, axis, around);
            }
            TypedShape::Capsule(capsule) => {
                let [a, b] = [capsule.segment.a, capsule.segment.b].map(|end| *at * end);
                let half = 0.5 * (b - a).length();
                let axis = (b - a).normalize_or(axis);
                let shape = Revolved::capsule(capsule.radius, half);
                shape.add(self, 0.5 * (a + b), axis, around);
            }
            TypedShape::TriMesh(mesh) => clip::add_mesh(self, mesh, at, around),
            TypedShape::HalfSpace(_)
            | TypedShape::HeightField(_)
            | TypedShape::Triangle(_)
            | TypedShape::Segment(_)
            | TypedShape::Polyline(_) => (),
            // Rounded shapes: a box of the same extents, whose volume is made that of the shape.
            _ => {
                let bounds = shape.compute_local_aabb();
                let volume = volume(shape);
                let cuboid = Cuboid::new(bounds.half_extents());
                let mut part = Self::default();
                let at = *at * ParryPose::from_translation(bounds.center());
                clip::add_box(&mut part, &cuboid, &at, around);
                let share = volume / bounds.volume().max(f32::MIN_POSITIVE);
                part.volume *= share;
                part.moment *= share;
                self.add(&part);
            }
        }
    }
}

/// Volume of a ball, m³.
pub(super) fn ball_volume(radius: f32) -> f32 {
    4.0 / 3.0 * PI * radius * radius * radius
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Quat;

    /// What is wet of a shape.
    fn wet(shape: &Collider, at: &ParryPose, around: &Around) -> Wet {
        let mut wet = Wet::default();
        let pieces = shape
            .shape()
            .as_compound()
            .map_or(1, |of| of.shapes().len());
        for piece in 0..pieces as u32 {
            wet.add_piece(shape, piece, at, around);
        }
        wet
    }

    /// Volume below the surface and its centroid, by a fine grid.
    fn counted(shape: &Collider, at: &ParryPose, around: &Around) -> (f32, Vec3) {
        const CELLS: u32 = 60;
        let bounds = shape.shape().compute_local_aabb();
        let size = bounds.extents() / CELLS as f32;
        let (mut count, mut sum) = (0u32, Vec3::ZERO);
        for i in 0..CELLS.pow(3) {
            let cell = [i % CELLS, i / CELLS % CELLS, i / CELLS / CELLS];
            let cell = Vec3::from_array(cell.map(|of| of as f32 + 0.5));
            let local = bounds.mins + cell * size;
            let place = *at * local;
            if around.depth(place) > 0.0 && shape.shape().contains_local_point(local) {
                count += 1;
                sum += place;
            }
        }
        let volume = count as f32 * size.element_product();
        (volume, sum / count.max(1) as f32)
    }

    #[test]
    fn volume_and_centroid_below_the_surface_are_those_that_a_grid_counts() {
        let prism = vec![
            Vec3::new(-0.3, 0.0, -0.4),
            Vec3::new(0.4, 0.0, -0.4),
            Vec3::new(0.0, 0.6, -0.4),
            Vec3::new(-0.3, 0.0, 0.4),
            Vec3::new(0.4, 0.0, 0.4),
            Vec3::new(0.0, 0.6, 0.4),
        ];
        let arm = (
            Vec3::new(0.5, 0.1, 0.0),
            Quat::from_rotation_z(0.4),
            Collider::cuboid(0.5, 0.2, 0.3),
        );
        let shapes = [
            ("box", Collider::cuboid(0.4, 0.7, 0.5)),
            ("ball", Collider::ball(0.4)),
            ("cylinder", Collider::cylinder(0.3, 0.9)),
            ("coin", Collider::cylinder(0.5, 0.1)),
            ("cone", Collider::cone(0.4, 0.8)),
            ("capsule", Collider::capsule(0.2, 0.5)),
            ("prism", Collider::convex_hull(&prism).unwrap()),
            (
                "compound",
                Collider::compound(vec![(Vec3::ZERO, Quat::IDENTITY, Collider::ball(0.3)), arm])
                    .unwrap(),
            ),
            ("rounded box", Collider::round_cuboid(0.6, 0.5, 0.4, 0.02)),
        ];
        let turns = [
            Quat::IDENTITY,
            Quat::from_rotation_z(std::f32::consts::FRAC_PI_2),
            Quat::from_rotation_x(0.7) * Quat::from_rotation_z(0.4),
            Quat::from_rotation_z(2.5),
        ];
        for (name, shape) in &shapes {
            let whole = shape.mass_properties().mass();
            for turn in turns {
                for offset in [-0.22, 0.01, 0.17, 3.0, -3.0] {
                    let at = ParryPose::from_parts(Vec3::new(0.1, 0.05, -0.2), turn);
                    let normal = Vec3::new(0.1, 1.0, -0.2).normalize();
                    let around = Around {
                        normal,
                        offset,
                        origin: if offset.abs() < 1.0 { offset } else { 0.0 } * normal,
                        velocity: Velocity::default(),
                        pressure: 0.0,
                    };
                    let wet = wet(shape, &at, &around);
                    let (volume, center) = counted(shape, &at, &around);
                    let case =
                        format!("{name} {turn:?} {offset}: {wet:?}, counted {volume} {center}");
                    assert!((wet.volume - volume).abs() < 0.008 * whole, "{case}");
                    if volume > 0.02 * whole {
                        let apart = (wet.moment / wet.volume - center).length();
                        assert!(apart < 0.006, "{apart} {case}");
                    }
                    if offset == 3.0 {
                        assert!(
                            (wet.volume - whole).abs() < 2e-4 * whole,
                            "{case}, all {whole}"
                        );
                    }
                }
            }
        }
    }

    /// A plate across the flow has the coefficient 1, a ball ½, a cylinder ⅔ across and 1 along.
    #[test]
    fn drag_coefficients_are_those_of_newton() {
        let dragged = |shape: &Collider, turn: Quat, flow: Vec3| {
            let around = Around {
                normal: Vec3::Y,
                offset: 10.0,
                origin: Vec3::ZERO,
                velocity: Velocity::linear(flow),
                pressure: 0.5,
            };
            wet(shape, &ParryPose::from_parts(Vec3::ZERO, turn), &around)
        };
        let turn = Quat::from_rotation_y(0.3);
        let close = |a: Vec3, b: Vec3| (a - b).length() < 1e-3 * b.length();
        let plate = dragged(&Collider::cuboid(0.1, 2.0, 3.0), turn, turn * Vec3::X * 2.0);
        assert!(
            close(plate.force, turn * Vec3::X * -0.5 * 4.0 * 6.0),
            "{plate:?}"
        );
        let ball = dragged(&Collider::ball(0.5), turn, Vec3::Z * 2.0);
        assert!(
            close(ball.force, Vec3::Z * -0.25 * 4.0 * PI * 0.25),
            "{ball:?}"
        );
        let roll = Collider::cylinder(0.5, 3.0);
        let across = dragged(&roll, turn, Vec3::X * 2.0);
        assert!(
            close(across.force, Vec3::X * -0.5 * 4.0 * 3.0 * 2.0 / 3.0),
            "{across:?}"
        );
        let along = dragged(&roll, turn, Vec3::Y * 2.0);
        assert!(
            close(along.force, Vec3::Y * -0.5 * 4.0 * PI * 0.25),
            "{along:?}"
        );
        // A fine mesh of a ball drags like the ball.
        let (points, triangles) = parry3d::shape::Ball::new(0.5).to_trimesh(64, 64);
        let mesh = Collider::trimesh(points, triangles).unwrap();
        let mesh = dragged(&mesh, turn, Vec3::Z * 2.0);
        assert!((mesh.force.z / ball.force.z - 1.0).abs() < 0.01, "{mesh:?}");
    }
}
