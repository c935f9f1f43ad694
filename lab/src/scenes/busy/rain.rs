//! Ragdolls that fall on a field with a torus in each of its squares.

use crate::scenes::Site;
use bevy_ecs::name::Name;
use bevy_transform::components::Transform;
use drystone::body::{Density, Pose, RigidBody, Velocity};
use drystone::collider::{Collider, CollisionLayers};
use drystone::joint::{RevoluteJoint, SphericalJoint};
use glam::{Quat, Vec3};
use std::f32::consts::TAU;

/// Edge of a square of the field, m, and its cells along an edge.
const SQUARE: f32 = 15.0;
const CELLS: u32 = 8;
/// Ragdolls of a group, in a row over each square.
const GROUP: u32 = 3;
/// Of a torus, m: its ring and its tube.
const RING: f32 = 3.75;
const TUBE: f32 = 1.0;
const AROUND: u32 = 16;
/// Dry friction of a ragdoll's joints, N·m.
const FRICTION: f32 = 5.0;

/// Thighs and hip do not collide, as in Box3D: its filter is by group, so the same holds between ragdolls.
const LEGS: CollisionLayers = CollisionLayers {
    memberships: 2,
    filters: !2,
};

/// A grid of triangles in the plane y = 0: so many squares along x and along z, the first corner in the origin.
fn grid(columns: u32, rows: u32) -> Collider {
    let (x, z) = (columns * CELLS, rows * CELLS);
    let cell = SQUARE / CELLS as f32;
    let corner = |i: u32| cell * Vec3::new((i % (x + 1)) as f32, 0.0, (i / (x + 1)) as f32);
    let square = |i: u32| {
        let a = i / x * (x + 1) + i % x;
        let (b, c, d) = (a + 1, a + x + 1, a + x + 2);
        [[a, c, b], [b, c, d]]
    };
    let corners = (0..(x + 1) * (z + 1)).map(corner).collect();
    Collider::trimesh(corners, (0..x * z).flat_map(square).collect())
        .expect("triangles of corners that there are")
}

/// A torus about y, of sixteen by sixteen squares.
fn torus() -> Collider {
    let corner = |i: u32| {
        let turn = |i: u32| (TAU * (i % AROUND) as f32 / AROUND as f32).sin_cos();
        let ((s, c), (sin, cos)) = (turn(i / AROUND), turn(i));
        let out = RING + TUBE * cos;
        Vec3::new(out * c, TUBE * sin, out * s)
    };
    let square = |i: u32| {
        let (ring, tube) = (i / AROUND, i % AROUND);
        let at = |ring: u32, tube: u32| ring % AROUND * AROUND + tube % AROUND;
        let (a, b) = (at(ring, tube), at(ring, tube + 1));
        let (c, d) = (at(ring + 1, tube), at(ring + 1, tube + 1));
        [[a, b, c], [c, b, d]]
    };
    let corners = (0..AROUND * AROUND).map(corner).collect();
    Collider::trimesh(corners, (0..AROUND * AROUND).flat_map(square).collect())
        .expect("triangles of corners that there are")
}

impl Site<'_> {
    /// In groups of three over each square. Box3D lets a column of groups in every sixteen steps or more, from 20 m; here each column is
    /// 3 m higher than the one before, from 3 m.
    pub(super) fn rain(&mut self, n: u32) {
        let groups = n.div_ceil(GROUP);
        let rows = (groups as f32).sqrt().floor().max(1.0) as u32;
        let columns = groups.div_ceil(rows);
        let corner = -0.5 * SQUARE * Vec3::new(columns as f32, 0.0, rows as f32);
        self.still("field", grid(columns, rows), corner);
        let torus = torus();
        for group in 0..columns * rows {
            let (column, row) = (group / rows, group % rows);
            let middle = Vec3::new(column as f32 + 0.5, 0.0, row as f32 + 0.5);
            self.still("torus", torus.clone(), corner + SQUARE * middle);
        }
        for i in 0..n {
            let (column, row) = (i / GROUP / rows, i / GROUP % rows);
            let middle = Vec3::new(column as f32 + 0.5, 0.0, row as f32 + 0.5);
            let aside = 0.75 * (i % GROUP) as f32;
            let high = 3.0 + 3.0 * column as f32;
            self.human(corner + SQUARE * middle + Vec3::new(aside, high, 0.0));
        }
    }

    fn still(&mut self, name: &str, collider: Collider, at: Vec3) {
        self.world.spawn((
            Name::new(name.to_owned()),
            RigidBody::Static,
            collider,
            self.friction(),
            Transform::from_translation(at),
        ));
    }

    /// Eleven capsules and ten joints, with the sizes and limits of Box3D's human. Box3D's has three bodies more in its back and neck, a
    /// spring of 1 Hz in each joint, and rolling resistance.
    fn human(&mut self, at: Vec3) {
        let bone = |site: &mut Self, name: &str, ends: [Vec3; 2], radius: f32| {
            let along = ends[1] - ends[0];
            let pose = Pose {
                position: at + 0.5 * (ends[0] + ends[1]),
                rotation: Quat::from_rotation_arc(Vec3::Y, along.normalize()),
            };
            let capsule = Collider::capsule(radius, along.length());
            let still = Velocity::default();
            site.exactly(name, capsule, Density::DEFAULT, pose, still)
        };
        let ball = |one, other, local: Vec3, axis: Vec3, swing: f32, twist: [f32; 2]| {
            let (swing, [min, max]) = (swing.to_radians(), twist.map(f32::to_radians));
            SphericalJoint::new(one, other)
                .with_anchor(at + local)
                .with_basis(Quat::IDENTITY)
                .with_twist_axis(axis)
                .with_swing_limits(-swing, swing)
                .with_twist_limits(min, max)
                .with_friction(FRICTION)
        };
        let hinge = |one, other, local: Vec3, axis: Vec3, [min, max]: [f32; 2]| {
            RevoluteJoint::new(one, other)
                .with_anchor(at + local)
                .with_basis(Quat::IDENTITY)
                .with_hinge_axis(axis)
                .with_angle_limits(min.to_radians(), max.to_radians())
                .with_friction(FRICTION)
        };
        let upright = |y| Vec3::Y * y;
        let across = Vec3::new(0.07, 1.012, -0.05);
        let pelvis = bone(self, "pelvis", [across.with_x(-0.07), across], 0.13);
        let torso = bone(self, "torso", [upright(1.17), upright(1.42)], 0.145);
        let head = bone(self, "head", [upright(1.68), upright(1.77)], 0.0975);
        let back = ball(pelvis, torso, upright(1.113), Vec3::Y, 25.0, [-15.0, 15.0]);
        let neck = ball(torso, head, upright(1.575), Vec3::Y, 45.0, [-15.0, 15.0]);
        let mut legs = vec![pelvis];
        self.world.spawn(back);
        self.world.spawn(neck);
        for side in [1.0, -1.0] {
            let x = |x: f32, y: f32, z: f32| Vec3::new(side * x, y, z);
            let (hip, knee) = (x(0.09, 0.95, -0.035), x(0.101, 0.527, -0.037));
            let thigh = bone(self, "thigh", [hip, x(0.1, 0.56, -0.036)], 0.09);
            let calf = bone(self, "calf", [knee, x(0.11, 0.11, -0.04)], 0.075);
            let (shoulder, elbow) = (x(0.204, 1.484, -0.116), x(0.306, 1.243, -0.118));
            let hand = x(0.42, 0.966, -0.1);
            let upper = bone(self, "upper arm", [shoulder, elbow], 0.075);
            let lower = bone(self, "lower arm", [elbow, hand], 0.05);
            let arm = (elbow - shoulder).normalize();
            let joints = [
                ball(pelvis, thigh, hip, Vec3::X, 10.0, [-60.0, 40.0]),
                ball(torso, upper, shoulder, arm, 60.0, [-5.0, 5.0]),
            ];
            self.world.spawn_batch(joints);
            let knee = hinge(thigh, calf, knee, Vec3::X, [-5.0, 45.0]);
            let elbow = hinge(upper, lower, elbow, Vec3::NEG_X, [-5.0, 60.0]);
            self.world.spawn_batch([knee, elbow]);
            legs.push(thigh);
        }
        for part in legs {
            self.world.entity_mut(part).insert(LEGS);
        }
    }
}
