//! How far a body moves in a step, where that is not its velocity at the end times Δt.

use super::Velocity;
use bevy_ecs::prelude::*;
use bevy_reflect::{Reflect, std_traits::ReflectDefault};
use glam::Vec3;

/// How a body moves over the step at hand: written by the stage *solve*, read by *integration*. A [`Velocity`] that is changed between
/// the two counts all the same.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Reflect)]
#[reflect(Component, Debug, Default)]
#[component(clone_behavior = Ignore)]
pub enum Motion {
    /// With its velocity.
    #[default]
    Steady,
    /// It flies: on a parabola, so that it comes down with the energy with which it went up.
    Flight {
        /// What gravity has added to its velocity in this step, m/s.
        gained: Vec3,
    },
    /// Its solver took substeps, and corrections move bodies that have no velocity of their own.
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
