//! A bar that a motor turns stirs bodies in a round pen.

use crate::scenes::{SceneOptions, Site};
use bevy_ecs::name::Name;
use bevy_transform::components::Transform;
use drystone::body::{Density, Pose, RigidBody, Velocity};
use drystone::collider::{Collider, Friction};
use drystone::joint::{JointMotor, RevoluteJoint};
use glam::{Quat, Vec3};
use std::f32::consts::TAU;

/// Radius of the pen, m. Box2D's is 40.
const PEN: f32 = 6.0;
/// Height of its sides, m, and their number.
const HIGH: f32 = 10.0;
const SIDES: u32 = 24;
/// The bar, m. Its middle is on the floor's axis.
const BAR: Vec3 = Vec3::new(11.0, 0.6, 0.6);
/// rad/s; N·m
const SPEED: f32 = 5.0;
const TORQUE: f32 = 1e6;
/// kg/m³; a quarter of the bar's, as in Box2D.
const LIGHT: f32 = 250.0;
/// Coefficient of all surfaces; that of the bar is 0 in Box2D.
const SLIPPERY: f32 = 0.1;

impl Site<'_> {
    /// Balls, capsules and cubes in turn. Box2D's have a restitution of 0.1, here 0.
    pub(super) fn spinner(&mut self, n: u32) {
        let friction = self.options.friction;
        let options = SceneOptions {
            friction: friction.min(SLIPPERY),
            ..*self.options
        };
        let mut site = Site {
            world: &mut *self.world,
            options: &options,
            rng: self.rng.clone(),
            bodies: Vec::new(),
        };
        site.stirred(n);
        self.bodies = site.bodies;
    }

    fn stirred(&mut self, n: u32) {
        self.ground(0.0);
        let wide = TAU * PEN / SIDES as f32 + 0.5;
        for i in 0..SIDES {
            let turn = Quat::from_rotation_y(TAU * i as f32 / SIDES as f32);
            let at = turn * ((PEN + 0.5) * Vec3::X) + 0.5 * HIGH * Vec3::Y;
            self.world.spawn((
                Name::new("side"),
                RigidBody::Static,
                Collider::cuboid(1.0, HIGH, wide),
                Friction::new(self.options.friction),
                Transform::from_translation(at).with_rotation(turn),
            ));
        }
        let middle = Vec3::Y;
        let pose = Pose {
            position: middle,
            rotation: Quat::IDENTITY,
        };
        let still = Velocity::default();
        let bar = Collider::cuboid(BAR.x, BAR.y, BAR.z);
        let bar = self.exactly("bar", bar, Density::DEFAULT, pose, still);
        let motor = JointMotor::velocity(SPEED, TORQUE);
        let hinge = RevoluteJoint::new(None, bar)
            .with_anchor(middle)
            .with_hinge_axis(Vec3::Y)
            .with_motor(motor);
        self.world.spawn(hinge);
        // As many in a layer as fit into the pen with a metre between their middles.
        let cells = (0..81).map(|i| Vec3::new((i % 9) as f32 - 4.0, 0.0, (i / 9) as f32 - 4.0));
        let cells: Vec<Vec3> = cells.filter(|cell| cell.length() < PEN - 1.0).collect();
        for i in 0..n as usize {
            let shape = match i % 3 {
                0 => Collider::ball(0.35),
                1 => Collider::capsule(0.25, 0.5),
                _ => Collider::cuboid(0.7, 0.7, 0.7),
            };
            let layer = (i / cells.len()) as f32;
            let at = cells[i % cells.len()] + (2.0 + 1.05 * layer) * Vec3::Y;
            let pose = Pose {
                position: at,
                rotation: Quat::IDENTITY,
            };
            self.exactly("body", shape, LIGHT, pose, still);
        }
    }
}
