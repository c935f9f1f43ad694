//! Speed limits, of single bodies and of all.

use crate::body::{BodyProperties, KeptProperty, Velocity};
use crate::diagnosis::BodyProblem;
use crate::settings::SpeedLimits;
use bevy_ecs::prelude::*;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::{Reflect, std_traits::ReflectDefault};

/// Maximum linear speed of a body, m/s. Forces and contacts do not make it faster. Default: infinite, so that only
/// [`SpeedLimits`](crate::settings::SpeedLimits) counts. NaN and negative values are an error ([`BodyProblem::InvalidMaxSpeed`]).
///
/// ```
/// use drystone::prelude::*;
///
/// # let mut app = bevy_app::App::new();
/// # app.add_plugins(DrystonePlugins::default());
/// # let world = app.world_mut();
/// let parachute = world.spawn((RigidBody::Dynamic, Collider::ball(0.5), MaxLinearSpeed(5.0))).id();
/// for _ in 0..120 {
///     drystone::step(world, 1.0 / 60.0).unwrap();
/// }
/// assert!((world.get::<Velocity>(parachute).unwrap().linear.length() - 5.0).abs() < 1e-4);
/// ```
#[derive(Component, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "bevy_reflect",
    derive(Reflect),
    reflect(Component, Debug, Default)
)]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[component(on_remove = crate::body::lost_description, summary_tick)]
pub struct MaxLinearSpeed(pub f32);

/// Maximum angular speed of a body, rad/s. Forces and contacts do not make it faster. Default: infinite, so that only
/// [`SpeedLimits`](crate::settings::SpeedLimits) counts. NaN and negative values are an error ([`BodyProblem::InvalidMaxSpeed`]).
#[derive(Component, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "bevy_reflect",
    derive(Reflect),
    reflect(Component, Debug, Default)
)]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[component(on_remove = crate::body::lost_description, summary_tick)]
pub struct MaxAngularSpeed(pub f32);

impl Default for MaxLinearSpeed {
    fn default() -> Self {
        Self(f32::INFINITY)
    }
}

impl Default for MaxAngularSpeed {
    fn default() -> Self {
        Self(f32::INFINITY)
    }
}

impl KeptProperty for MaxLinearSpeed {
    fn check(&self) -> Result<(), BodyProblem> {
        check(self.0)
    }
}

impl KeptProperty for MaxAngularSpeed {
    fn check(&self) -> Result<(), BodyProblem> {
        check(self.0)
    }
}

fn check(limit: f32) -> Result<(), BodyProblem> {
    match limit >= 0.0 {
        true => Ok(()),
        false => Err(BodyProblem::InvalidMaxSpeed),
    }
}

impl BodyProperties {
    /// Clamps a velocity to the limits of this body.
    #[inline]
    pub(crate) fn cap(&self, velocity: &mut Velocity) {
        if self.max_linear_speed.0 < f32::INFINITY {
            velocity.linear = velocity.linear.clamp_length_max(self.max_linear_speed.0);
        }
        if self.max_angular_speed.0 < f32::INFINITY {
            velocity.angular = velocity.angular.clamp_length_max(self.max_angular_speed.0);
        }
    }

    /// Returns true if some axis is locked or a speed is limited.
    #[inline]
    pub(crate) fn restrains(&self) -> bool {
        !self.locked_axes.is_unlocked()
            || self.max_linear_speed.0 < f32::INFINITY
            || self.max_angular_speed.0 < f32::INFINITY
    }

    /// Applies locked axes and speed limits to the velocity of a dynamic body.
    #[inline]
    pub(crate) fn restrain(&self, velocity: &mut Velocity) {
        if self.restrains() {
            self.locked_axes.stop(velocity);
            self.cap(velocity);
        }
    }
}

impl SpeedLimits {
    /// Returns true if the velocity is within the limits.
    pub fn allow(&self, velocity: &Velocity) -> bool {
        velocity.linear.length() <= self.linear && velocity.angular.length() <= self.angular
    }

    /// Clamps a velocity to the limits.
    pub(crate) fn cap(&self, velocity: &mut Velocity) {
        velocity.linear = velocity.linear.clamp_length_max(self.linear);
        velocity.angular = velocity.angular.clamp_length_max(self.angular);
    }
}
