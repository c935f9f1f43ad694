//! How a body moves over a step, where that is not Δt times its velocity at the end.

use super::Velocity;
use bevy_ecs::prelude::*;
use bevy_reflect::{Reflect, std_traits::ReflectDefault};
use glam::Vec3;

/// How a body moves over the current step. The stage *solve* writes it and *integration* reads it. A [`Velocity`] that is changed between
/// the two is added.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Reflect)]
#[reflect(Component, Debug, Default)]
#[component(clone_behavior = Ignore)]
pub enum Motion {
    /// With its velocity.
    #[default]
    Steady,
    /// On a parabola, in free flight: the body comes down with the energy with which it went up.
    Flight {
        /// What gravity has added to its velocity in this step, m/s.
        gained: Vec3,
    },
    /// With a mean velocity, since its solver takes substeps, and corrections move bodies without giving them a velocity.
    Mean {
        /// Over the step.
        mean: Velocity,
        /// At its end, as the solver found it.
        end: Velocity,
    },
}

impl Motion {
    /// The mean velocity over the step of a body that now has this one, if that is another.
    #[inline]
    pub(crate) fn mean(&self, velocity: &Velocity) -> Option<Velocity> {
        match *self {
            Self::Steady | Self::Flight { .. } => None,
            Self::Mean { mean, end } if end == *velocity => Some(mean),
            Self::Mean { mean, end } => Some(Velocity {
                linear: mean.linear + (velocity.linear - end.linear),
                angular: mean.angular + (velocity.angular - end.angular),
            }),
        }
    }

    /// How much slower than its velocity it moves on the whole, m/s.
    #[inline]
    pub(crate) fn lag(&self) -> Vec3 {
        match *self {
            Self::Flight { gained } => 0.5 * gained,
            _ => Vec3::ZERO,
        }
    }
}
