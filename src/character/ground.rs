//! How a character goes with its ground, and when it leaves it.

use super::CharacterState;
use crate::body::{Pose, RigidBody};
use crate::query::{Ground, SpatialQuery};
use bevy_ecs::entity::Entity;
use glam::{Quat, Vec3};

/// How its ground carries a character in a step.
pub(super) struct Carried {
    pub ground: Entity,
    /// Velocity of the body where the character stands, m/s.
    pub velocity: Vec3,
    /// Rotation of the body.
    pub turn: Quat,
    /// Velocity of its surface relative to the body, m/s.
    pub belt: Vec3,
}

impl Carried {
    /// Velocity of the surface, m/s.
    pub fn surface(&self) -> Vec3 {
        self.velocity + self.belt
    }
}

impl CharacterState {
    /// How the ground carries a character at a position in a step of `dt` s. `None` if it stood on nothing, or its ground is gone.
    pub(super) fn carried(&self, world: &SpatialQuery, from: Vec3, dt: f32) -> Option<Carried> {
        /// A way that is so much longer than the body's velocity explains is none of a motion, m: the body was put elsewhere.
        const MAX_UNEXPLAINED_WAY: f32 = 0.1;
        let ground = self.ground?;
        let now = world.pose(ground.entity)?;
        let body = world.state(ground.entity)?;
        let Pose { position, rotation } = self.ground_pose;
        let mut turn = now.rotation * rotation.inverse();
        let mut way = turn * (from - position) + now.position - from;
        // Rounding must not move a character at rest, and a static body carries nothing along.
        if now == self.ground_pose || body.kind == RigidBody::Static {
            (turn, way) = (Quat::IDENTITY, Vec3::ZERO);
        }
        let most = 2.0 * dt * body.velocity_at(from).length() + MAX_UNEXPLAINED_WAY;
        (way.length() <= most).then(|| Carried {
            ground: ground.entity,
            velocity: way / dt,
            turn,
            belt: body.surface_velocity(),
        })
    }

    /// Whether the character leaves its ground, which falls away: it goes up at `now` (m/s) after a step of `dt` s, while gravity pulls the
    /// character down at `gravity` (m/s²). It stays on ground that drops for a moment, from which it would rise by no more than `reach`, m.
    pub(super) fn leaves(&mut self, up: Vec3, now: f32, gravity: f32, reach: f32, dt: f32) -> bool {
        /// A body that falls freely carries nothing, but rounding must not decide.
        const FREE_FALL_SHARE: f32 = 0.95;
        /// Time after which it leaves, s, and the number of steps.
        const LEAVING_TIME: f32 = 0.05;
        const LEAVING_STEPS: f32 = 2.0;
        let faster = self.carried.dot(up) - now - FREE_FALL_SHARE * gravity * dt;
        if faster <= 0.0 || gravity <= 0.0 {
            self.falling = 0.0;
            return false;
        }
        self.falling += dt;
        faster * faster > 2.0 * gravity * reach
            || self.falling >= LEAVING_TIME.max(LEAVING_STEPS * dt)
    }

    /// Writes down what the character stands on after a step of `dt` s, if it stands. `carried` is what has carried it, if it stood all the
    /// time.
    pub(super) fn stand_on(
        &mut self,
        ground: Option<Ground>,
        carried: Option<Carried>,
        world: &SpatialQuery,
        dt: f32,
    ) {
        let stood = carried.map(|by| (by.ground, by.velocity));
        self.ground = ground;
        let Some(ground) = ground else {
            self.airborne += dt;
            self.falling = 0.0;
            self.carried = Vec3::ZERO;
            return;
        };
        self.airborne = 0.0;
        self.fall = Vec3::ZERO;
        self.ground_pose = world.pose(ground.entity).unwrap_or_default();
        self.carried = match stood {
            Some((body, velocity)) if body == ground.entity => velocity,
            _ => world.went(ground.entity, ground.point),
        };
    }
}
