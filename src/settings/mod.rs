//! Settings: gravity, solver, stabilization, narrowphase, sleeping, speed limits and threads, each a resource.
//!
//! The defaults suit a Bevy game at 60 Hz. [`Preset::Paper`] holds the settings of Table 1 of the paper. Settings may change between any
//! two steps. A step checks them first: a setting that is out of bounds is set back to its last valid value and reported as
//! [`StepError::InvalidSettings`](crate::diagnosis::StepError::InvalidSettings).

mod check;
mod columns;
mod narrowphase;
mod physics_time;
mod preset;
#[cfg(feature = "serde")]
mod saved_solver;
mod solver;
mod stabilization;
mod threads;
mod time;

pub use check::ActiveSettings;
pub(crate) use check::check;
pub(crate) use columns::Columns;
pub use narrowphase::NarrowphaseSettings;
pub use physics_time::PhysicsTime;
pub use preset::Preset;
pub(crate) use solver::Method;
pub use solver::{ContactSolver, SolverSettings, uses_point_solver};
pub use stabilization::{
    AnchorRule, Classifier, FrictionStabilization, NormalStabilization, StabilizationSettings,
};
pub use threads::PhysicsThreads;
pub use time::StepTime;
pub(crate) use time::is_last;

pub use crate::limits::STEP_LENGTHS;

use crate::solver::{Both, Settling};
use bevy_ecs::prelude::*;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::{Reflect, std_traits::ReflectDefault};
use glam::Vec3;

/// Acceleration of gravity, m/s². Default: (0, −9.81, 0).
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "bevy_reflect",
    derive(Reflect),
    reflect(Resource, Debug, Default)
)]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[component(clone_behavior = Ignore)]
pub struct Gravity(pub Vec3);

impl Default for Gravity {
    fn default() -> Self {
        Self(Vec3::new(0.0, -9.81, 0.0))
    }
}

/// Maximum speeds of a body. Bodies that forces or contacts make faster are slowed down to these limits.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "bevy_reflect",
    derive(Reflect),
    reflect(Resource, Debug, Default)
)]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[component(clone_behavior = Ignore)]
pub struct SpeedLimits {
    /// Maximum linear speed, m/s. Default: 1000.
    pub linear: f32,
    /// Maximum angular speed, rad/s. Default: 10 000.
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

/// Structures settle below this many times the speeds at which bodies count as still.
const SETTLING_SPEED_FACTOR: f32 = 10.0;

/// When bodies fall asleep. Sleeping bodies are not simulated until something wakes them.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "bevy_reflect",
    derive(Reflect),
    reflect(Resource, Debug, Default)
)]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[component(clone_behavior = Ignore)]
pub struct SleepSettings {
    /// Whether bodies may fall asleep. Default: true.
    pub enabled: bool,
    /// A body counts as still below this speed, m/s. It is at rest if it moves by less than a hundredth of that in the mean. Default: 0.01.
    pub linear_speed: f32,
    /// A body counts as still below this angular speed, rad/s. Default: 0.02.
    pub angular_speed: f32,
    /// An island falls asleep when all its bodies have been still for this time, s, and are [at
    /// rest](crate::body::Sleeping#when-bodies-fall-asleep). If it is infinite, none does. Default: 0.5.
    pub delay: f32,
    /// Rate at which the bodies of a tall structure lose speed, 1/s, once all are slower than ten times `linear_speed` and `angular_speed`.
    /// Without it, a wall that was hit sways for long. It does not act on structures of fewer than twelve courses or with joints, on bodies
    /// that roll, slide or tip, or under a point solver. 0 turns it off. Default: 1.
    pub settling: f32,
    /// Which sleeping bodies wake when awake ones touch them. Default: by need.
    pub waking: Waking,
}

/// Which sleeping bodies wake when awake ones touch them.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect), reflect(Debug))]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Waking {
    /// All bodies that are connected with them by contacts and joints. Touching a body costs as much as all bodies that it is connected
    /// with.
    Islands,
    /// Those that the awake bodies hit, and those on which the forces change. Touching a body costs as much as the bodies that have to
    /// move: a brick that is laid on a wall wakes a few bricks below it.
    ByNeed {
        /// A body wakes when the force on it, or the moment divided by its radius, changes by more than this share of the sum of the normal
        /// forces on it, without unit; and by less where little or nothing resists, as on hinges, on ice and on edges. Default: 0.02.
        share: f32,
    },
}

impl SleepSettings {
    /// Returns true if no body ever falls asleep. The delay of a shadow is infinite if its world does not let bodies sleep.
    pub(crate) fn is_off(&self) -> bool {
        !self.enabled || self.delay == f32::INFINITY
    }

    /// How tall structures come to rest, if bodies may fall asleep.
    pub(crate) fn settling(&self) -> Option<Settling> {
        let settles = !self.is_off() && self.settling > 0.0;
        settles.then(|| Settling {
            rate: self.settling,
            below: [self.linear_speed, self.angular_speed]
                .both(|speed| SETTLING_SPEED_FACTOR * speed),
        })
    }
}

impl Default for SleepSettings {
    fn default() -> Self {
        Preset::Default.sleeping()
    }
}
