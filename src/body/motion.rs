//! The motion of a body over a step, if it is not Δt times the velocity at the end of the step.

use super::Velocity;
use bevy_ecs::prelude::*;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::{Reflect, std_traits::ReflectDefault};
use glam::Vec3;

/// How a body moves over the current step. The stage *solve* writes it and *integration* reads it. A change of the [`Velocity`] between the
/// two is added.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq)]
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
#[component(clone_behavior = Ignore)]
pub enum Motion {
    /// The body moves with its velocity. The default.
    #[default]
    Steady,
    /// Free flight on a parabola, which conserves energy.
    Flight {
        /// The velocity that gravity has added in this step, m/s.
        gained: Vec3,
    },
    /// The body moves with a mean velocity, because its solver takes substeps and corrects positions without changing velocities.
    Mean {
        /// The mean velocity over the step.
        mean: Velocity,
        /// The velocity at the end of the step, as the solver computed it.
        end: Velocity,
    },
    /// As `Mean`, for a body with joints: the rotation is exactly that of the mean angular velocity, and the end velocity has the
    /// gyroscopic change. If *integration* changed either, joints would not close.
    Exact {
        /// The mean velocity over the step.
        mean: Velocity,
        /// The velocity at the end of the step, as the solver computed it.
        end: Velocity,
    },
}

impl Motion {
    /// The mean velocity over the step of a body whose velocity is now `velocity`. `None` if it is `velocity` itself, up to [`Self::lag`].
    #[inline]
    pub(crate) fn mean(&self, velocity: &Velocity) -> Option<Velocity> {
        match *self {
            Self::Steady | Self::Flight { .. } => None,
            Self::Mean { mean, end } | Self::Exact { mean, end } if end == *velocity => Some(mean),
            Self::Mean { mean, end } | Self::Exact { mean, end } => Some(Velocity {
                linear: mean.linear + (velocity.linear - end.linear),
                angular: mean.angular + (velocity.angular - end.angular),
            }),
        }
    }

    /// The difference between the velocity at the end of the step and the mean velocity in free flight, m/s.
    #[inline]
    pub(crate) fn lag(&self) -> Vec3 {
        match *self {
            Self::Flight { gained } => 0.5 * gained,
            _ => Vec3::ZERO,
        }
    }
}
