//! Scenes with joints: a chain, ragdolls.

use super::{Hand, Site};
use bevy_ecs::prelude::*;
use drystone::body::{Density, Mass, Pose, Velocity};
use drystone::collider::Collider;
use drystone::joint::{RevoluteJoint, SphericalJoint};
use glam::{Quat, Vec3};

/// Length of a link of a chain, m.
const LINK: f32 = 0.4;
/// The ball at the end of a chain, kg.
const BALL: f32 = 100.0;

/// Number of courses and of bricks in each of the heap under ragdolls.
const HEAP: [i32; 2] = [2, 3];

impl Site<'_> {
    /// A body of a certain mass.
    pub(super) fn weighing(
        &mut self,
        name: &str,
        collider: Collider,
        mass: f32,
        position: Vec3,
        rotation: Quat,
    ) -> Entity {
        let pose = Pose { position, rotation };
        let body = self.exactly(name, collider, Density::DEFAULT, pose, Velocity::default());
        self.world.entity_mut(body).insert(Mass(mass));
        body
    }

    /// Hangs straight down. The lowest point is 1 m above the ground.
    pub(super) fn chain(&mut self, n: u32) -> Option<Hand> {
        self.ground(0.0);
        let mut top = Vec3::Y * (1.5 + LINK * n as f32);
        let mut last = None;
        for _ in 0..n {
            let center = top - Vec3::Y * (0.5 * LINK);
            let link = Collider::capsule(0.05, LINK - 0.1);
            let link = self.weighing("link", link, 1.0, center, Quat::IDENTITY);
            self.world
                .spawn(SphericalJoint::new(last, link).with_anchor(top));
            last = Some(link);
            top.y -= LINK;
        }
        let ball = Collider::ball(0.25);
        let at = top - Vec3::Y * 0.25;
        let ball = self.weighing("ball", ball, BALL, at, Quat::IDENTITY);
        self.world
            .spawn(SphericalJoint::new(last, ball).with_anchor(top));
        None
    }

    /// In a square, two metres apart, 3 m above a heap of bricks.
    pub(super) fn ragdolls(&mut self, n: u32) -> Option<Hand> {
        self.ground(0.0);
        let side = (n as f32).sqrt().ceil() as u32;
        let reach = side as f32;
        let [courses, bricks] = HEAP;
        // The bricks are not counted: those to watch are the ragdolls.
        let watched = self.bodies.len();
        for course in 0..courses {
            for i in -bricks * side as i32..=bricks * side as i32 {
                let x = 0.6 * i as f32 + 0.3 * (course % 2) as f32;
                let at = Vec3::new(x, 0.125 + 0.25 * course as f32, 0.15 * (i % 3) as f32);
                if x.abs() < 2.0 * reach {
                    let brick = Collider::cuboid(0.5, 0.25, 0.3);
                    self.place("brick", brick, at, Quat::IDENTITY);
                }
            }
        }
        self.bodies.truncate(watched);
        for i in 0..n {
            let (column, row) = ((i % side) as f32, (i / side) as f32);
            let at = Vec3::new(2.0 * column - reach + 1.0, 2.0, 2.0 * row - reach + 1.0);
            let turn = Quat::from_rotation_y(0.7 * i as f32) * Quat::from_rotation_z(0.4);
            self.ragdoll(at, turn);
        }
        None
    }

    /// Fifteen bodies and fourteen joints, 75 kg.
    fn ragdoll(&mut self, at: Vec3, turn: Quat) {
        let place = |local: Vec3| at + turn * local;
        let part = |site: &mut Self, name: &str, half: Vec3, mass: f32, center: Vec3| {
            let size = 2.0 * half;
            let shape = Collider::cuboid(size.x, size.y, size.z);
            site.weighing(name, shape, mass, place(center), turn)
        };
        let pelvis = part(self, "pelvis", Vec3::new(0.16, 0.1, 0.1), 12.0, Vec3::Y);
        let chest = Vec3::new(0.17, 0.21, 0.1);
        let chest = part(self, "chest", chest, 26.0, Vec3::Y * 1.33);
        let head = part(self, "head", Vec3::new(0.09, 0.12, 0.1), 5.0, Vec3::Y * 1.7);
        let ball = |site: &mut Self, one, other, local: Vec3, swing: f32, twist: f32| {
            let joint = SphericalJoint::new(one, other)
                .with_anchor(place(local))
                .with_basis(turn)
                .with_swing_limits(-swing, swing)
                .with_twist_limits(-twist, twist)
                .with_friction(1.0);
            site.world.spawn(joint);
        };
        let hinge = |site: &mut Self, one, other, local: Vec3, min: f32, max: f32| {
            let joint = RevoluteJoint::new(one, other)
                .with_anchor(place(local))
                .with_basis(turn)
                .with_hinge_axis(Vec3::X)
                .with_angle_limits(min, max)
                .with_friction(1.0);
            site.world.spawn(joint);
        };
        ball(self, pelvis, chest, Vec3::Y * 1.11, 0.5, 0.5);
        ball(self, chest, head, Vec3::Y * 1.56, 0.5, 0.7);
        for side in [-1.0, 1.0] {
            let x = |x: f32, y: f32| Vec3::new(side * x, y, 0.0);
            let arm = Vec3::new(0.045, 0.14, 0.045);
            let upper = part(self, "upper arm", arm, 2.2, x(0.23, 1.36));
            let fore = part(self, "forearm", arm, 1.5, x(0.23, 1.06));
            let palm = Vec3::new(0.03, 0.08, 0.045);
            let palm = part(self, "hand", palm, 0.5, x(0.23, 0.82));
            ball(self, chest, upper, x(0.21, 1.5), 1.2, 0.8);
            hinge(self, upper, fore, x(0.23, 1.21), -2.3, 0.0);
            ball(self, fore, palm, x(0.23, 0.91), 0.5, 0.3);
            let leg = Vec3::new(0.065, 0.2, 0.065);
            let thigh = part(self, "thigh", leg, 7.0, x(0.1, 0.69));
            let shin = part(self, "shin", leg, 3.5, x(0.1, 0.27));
            let foot = Vec3::new(0.05, 0.035, 0.12);
            let center = x(0.1, 0.03) + Vec3::Z * 0.05;
            let foot = part(self, "foot", foot, 1.3, center);
            ball(self, pelvis, thigh, x(0.1, 0.9), 0.9, 0.4);
            hinge(self, thigh, shin, x(0.1, 0.48), 0.0, 2.3);
            ball(self, shin, foot, x(0.1, 0.06), 0.4, 0.2);
        }
    }
}
