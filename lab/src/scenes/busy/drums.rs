//! Drums that turn: a hollow box, and a ring with fins.

use super::Drive;
use crate::scenes::Site;
use bevy_ecs::name::Name;
use bevy_transform::components::Transform;
use drystone::body::{Density, Pose, RigidBody, Velocity};
use drystone::collider::Collider;
use drystone::joint::{JointMotor, RevoluteJoint};
use glam::{Quat, Vec3};
use std::f32::consts::{PI, TAU};

/// 25 °/s, in rad/s: tumbler and washer.
const TURNS: f32 = 25.0 * PI / 180.0;

/// Inner width of the hollow box and thickness of its sides, m. Box2D's is 20 m wide, with sides of 1 m that are 50 times as dense as the
/// boxes in it. Here all have one density.
const HOLLOW: f32 = 6.0;
const THICK: f32 = 0.5;
/// N·m
const MOTOR: f32 = 1e8;

/// Radii of the washer, m: the tips of its fins, and the inner and the outer side of its wall. Box3D's is 2.5 times as large.
const RADII: [f32; 3] = [5.6, 6.4, 7.2];
/// Half its depth, m. It is open in front and behind.
const DEEP: f32 = 4.0;
const SEGMENTS: u32 = 36;

/// Six plates around a hollow cube.
fn hollow() -> Collider {
    let (length, off) = (HOLLOW + 2.0 * THICK, 0.5 * (HOLLOW + THICK));
    let plate = |size: Vec3, at: Vec3| {
        let shape = Collider::cuboid(size.x, size.y, size.z);
        (at, Quat::IDENTITY, shape)
    };
    let pair = |axis: Vec3| {
        let size = length * (Vec3::ONE - axis) + THICK * axis;
        [-1.0, 1.0].map(|side| plate(size, side * off * axis))
    };
    let plates = [Vec3::X, Vec3::Y, Vec3::Z].map(pair);
    Collider::compound(plates.into_iter().flatten().collect()).expect("boxes are convex")
}

/// A segment of a ring about z between two radii, m, and two angles, rad.
fn segment(radii: [f32; 2], angles: [f32; 2]) -> Collider {
    let corner = |i: usize| {
        let (sin, cos) = angles[i & 1].sin_cos();
        let radius = radii[i >> 1 & 1];
        let z = if i < 4 { -DEEP } else { DEEP };
        Vec3::new(radius * cos, radius * sin, z)
    };
    let corners: Vec<Vec3> = (0..8).map(corner).collect();
    Collider::convex_hull(&corners).expect("a segment is a hull")
}

/// Its segments reach a tenth of their angle into each other, as in Box3D.
fn ring_with_fins() -> Collider {
    let [tip, inner, outer] = RADII;
    let angle = TAU / SEGMENTS as f32;
    let mut parts = Vec::new();
    for i in 0..SEGMENTS {
        let [from, to] = [i, i + 1].map(|i| angle * i as f32);
        let slack = 0.1 * angle;
        parts.push(segment([inner, outer], [from - slack, to + slack]));
        if i % (SEGMENTS / 4) == 0 {
            parts.push(segment([tip, inner], [from, to]));
        }
    }
    let place = |part| (Vec3::ZERO, Quat::IDENTITY, part);
    Collider::compound(parts.into_iter().map(place).collect()).expect("segments are convex")
}

impl Site<'_> {
    /// A kinematic body that turns about z.
    fn turning(&mut self, name: &str, collider: Collider, at: Vec3) {
        self.world.spawn((
            Name::new(name.to_owned()),
            RigidBody::Kinematic,
            collider,
            self.friction(),
            Velocity {
                linear: Vec3::ZERO,
                angular: TURNS * Vec3::Z,
            },
            Transform::from_translation(at),
        ));
    }

    pub(super) fn tumbler(&mut self, drive: Drive, n: u32) {
        let middle = 6.0 * Vec3::Y;
        match drive {
            Drive::Kinematic => self.turning("hollow box", hollow(), middle),
            Drive::Hinge => {
                let pose = Pose {
                    position: middle,
                    rotation: Quat::IDENTITY,
                };
                let still = Velocity::default();
                let hollow = self.exactly("hollow box", hollow(), Density::DEFAULT, pose, still);
                let motor = JointMotor::velocity(TURNS, MOTOR);
                let hinge = RevoluteJoint::new(None, hollow)
                    .with_anchor(middle)
                    .with_motor(motor);
                self.world.spawn(hinge);
            }
        }
        self.filling(n, 0.5, 0.55, middle, HOLLOW);
    }

    /// Box3D's drum also drifts by some millimetres a second.
    pub(super) fn washer(&mut self, n: u32) {
        let middle = 8.4 * Vec3::Y;
        self.ground(0.0);
        self.turning("drum", ring_with_fins(), middle);
        self.filling(n, 0.4, 0.8, middle, 9.0);
    }

    /// Cubes of an edge (m) in a lattice of a pitch (m) about a point, at most as wide as its room (m), from below.
    fn filling(&mut self, n: u32, edge: f32, pitch: f32, middle: Vec3, room: f32) {
        let most = (room / pitch) as u32;
        let side = ((n as f32).cbrt().ceil() as u32).clamp(1, most);
        let half = 0.5 * (side - 1) as f32;
        for i in 0..n {
            let cell = [i % side, i / (side * side), i / side % side].map(|x| x as f32 - half);
            let at = middle + pitch * Vec3::from(cell);
            self.put(
                "cube",
                Collider::cuboid(edge, edge, edge),
                at,
                Quat::IDENTITY,
            );
        }
    }
}
