//! A net of balls on joints.

use super::Hang;
use crate::scenes::Site;
use bevy_ecs::name::Name;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::body::{Density, Pose, RigidBody, Velocity};
use drystone::collider::{Collider, CollisionLayers};
use drystone::joint::SphericalJoint;
use glam::{Quat, Vec3};

/// m; neighbours are 1 m apart.
const RADIUS: f32 = 0.4;

/// Balls of a net do not collide with each other.
const LAYERS: CollisionLayers = CollisionLayers {
    memberships: 2,
    filters: !2,
};

impl Hang {
    /// How many balls do not move.
    pub(super) fn fixed(self, n: u32) -> u32 {
        match self {
            Self::Row => n,
            Self::Seven => n.min(7),
            Self::Corner => 1,
        }
    }

    fn holds(self, column: u32, row: u32, n: u32) -> bool {
        let first = (n - self.fixed(n)) / 2;
        match self {
            Self::Row => row == 0,
            Self::Seven => row == 0 && (first..first + self.fixed(n)).contains(&column),
            Self::Corner => row == 0 && column == 0,
        }
    }
}

impl Site<'_> {
    /// In the plane z = 0, high enough that it swings without touching y = 0, where there is nothing.
    pub(super) fn joint_grid(&mut self, hang: Hang, n: u32) {
        let top = 1.5 * n as f32 + 1.0;
        let mut balls: Vec<Entity> = Vec::new();
        for i in 0..n * n {
            let (column, row) = (i / n, i % n);
            let at = Vec3::new(column as f32, top - row as f32, 0.0);
            let ball = match hang.holds(column, row, n) {
                true => self.hook(at),
                false => {
                    let pose = Pose {
                        position: at,
                        rotation: Quat::IDENTITY,
                    };
                    let shape = Collider::ball(RADIUS);
                    self.exactly("ball", shape, Density::DEFAULT, pose, Velocity::default())
                }
            };
            self.world.entity_mut(ball).insert(LAYERS);
            let above = (row > 0).then(|| (balls[i as usize - 1], Vec3::Y));
            let beside = (column > 0).then(|| (balls[(i - n) as usize], Vec3::NEG_X));
            for (other, way) in above.into_iter().chain(beside) {
                let joint = SphericalJoint::new(other, ball).with_anchor(at + 0.5 * way);
                self.world.spawn(joint);
            }
            balls.push(ball);
        }
    }

    /// A ball that nothing moves.
    fn hook(&mut self, at: Vec3) -> Entity {
        let body = (
            Name::new("hook"),
            RigidBody::Static,
            Collider::ball(RADIUS),
            self.friction(),
            Transform::from_translation(at),
        );
        self.world.spawn(body).id()
    }
}
