//! What a user can set: gravity, stabilization, solver. The defaults are what a Bevy user gets; [`Preset::Paper`]
//! is the setting of the paper's Table 1. All of it may be changed between any two steps; what cannot be is refused (`StepError::InvalidSettings`).

mod check;
mod columns;
mod narrowphase;
mod preset;
mod solver;
mod stabilization;
mod threads;
mod time;

pub use check::InForce;
pub(crate) use check::check;
pub use narrowphase::NarrowphaseSettings;
pub use preset::Preset;
pub(crate) use solver::Method;
pub use solver::{ContactSolver, SolverSettings, solves_points};
pub use stabilization::{
    AnchorRule, Classifier, FrictionStabilization, NormalStabilization, StabilizationSettings,
};
pub use threads::PhysicsThreads;
pub use time::{LENGTHS, StepTime};

use crate::body::Velocity;
use bevy_ecs::prelude::*;
use glam::Vec3;

/// Acceleration of free fall, m/s²; (0, −9.81, 0) by default.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
pub struct Gravity(pub Vec3);

impl Default for Gravity {
    fn default() -> Self {
        Self(Vec3::new(0.0, -9.81, 0.0))
    }
}

/// How fast a body may be. What forces and contacts make faster is slowed down to this, so that nothing gets lost in one step.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
pub struct SpeedLimits {
    /// m/s; 1000 by default.
    pub linear: f32,
    /// rad/s; 10 000 by default.
    pub angular: f32,
}

impl Default for SpeedLimits {
    fn default() -> Self {
        Self {
            linear: 1000.0,
            angular: 10_000.0,
        }
    }
}

impl SpeedLimits {
    /// True for a velocity that a body may have.
    pub fn allow(&self, velocity: &Velocity) -> bool {
        velocity.linear.length() <= self.linear && velocity.angular.length() <= self.angular
    }

    /// The velocity that a body has instead.
    pub(crate) fn cap(&self, velocity: &mut Velocity) {
        velocity.linear = velocity.linear.clamp_length_max(self.linear);
        velocity.angular = velocity.angular.clamp_length_max(self.angular);
    }
}

/// Bodies at rest stop costing time.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
pub struct SleepSettings {
    /// On or off.
    pub enabled: bool,
    /// A body slower than this counts as still, m/s.
    pub linear_speed: f32,
    /// A body that turns slower than this counts as still, rad/s.
    pub angular_speed: f32,
    /// An island sleeps when all of it has been still this long, s.
    pub delay: f32,
}

impl Default for SleepSettings {
    fn default() -> Self {
        Preset::Default.sleeping()
    }
}
