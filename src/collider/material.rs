//! Friction, restitution and rolling friction, and how those of two bodies are combined.

use crate::body::{KeptProperty, limits};
use crate::diagnosis::BodyProblem;
use bevy_ecs::prelude::*;
use bevy_reflect::{Reflect, std_traits::ReflectDefault};

/// How the coefficients of two surfaces become one. Where the two bodies ask for different rules, the later in this
/// list wins.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Reflect)]
pub enum CombineRule {
    /// (a + b) / 2
    #[default]
    Average,
    /// √(a b)
    GeometricMean,
    /// min(a, b)
    Min,
    /// a b
    Multiply,
    /// max(a, b)
    Max,
}

impl CombineRule {
    fn apply(self, a: f32, b: f32) -> f32 {
        match self {
            Self::Average => 0.5 * (a + b),
            Self::GeometricMean => (a * b).sqrt(),
            Self::Min => a.min(b),
            Self::Multiply => a * b,
            Self::Max => a.max(b),
        }
    }
}

/// Coulomb friction of a body's surface; 0.5 by default.
#[derive(Component, Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Component, Debug, Default)]
#[component(on_remove = crate::body::lost_description, summary_tick)]
pub struct Friction {
    /// μ, not negative and at most [`limits::FRICTION`](crate::body::limits::FRICTION).
    pub coefficient: f32,
    /// How it is combined with the other body's.
    pub rule: CombineRule,
}

/// Restitution of a body's surface; 0 by default.
#[derive(Component, Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Component, Debug, Default)]
#[component(on_remove = crate::body::lost_description, summary_tick)]
pub struct Restitution {
    /// e, from 0 to 1, which bounces without loss.
    pub coefficient: f32,
    /// How it is combined with the other body's.
    pub rule: CombineRule,
}

/// What resists the rolling and spinning of round bodies (balls, capsules, cylinders, cones on their curved sides); 0.05 by
/// default.
///
/// A moment of at most this coefficient times the body's radius times what the contact carries: a ball stays on slopes up to
/// this tangent. It is the friction of rest. What rolls or slips faster than some 0.1 m/s is let go, with the
/// fourth power of its speed, so that a ball that rolls goes on and one that only creeps stops. Spin about the normal is resisted at any speed.
///
/// For [`SoftStep`](crate::solver::SoftStep); solvers of points have none.
#[derive(Component, Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Component, Debug, Default)]
#[component(on_remove = crate::body::lost_description, summary_tick)]
pub struct RollingFriction {
    /// As a share of the radius, not negative.
    pub coefficient: f32,
    /// How it is combined with the other body's.
    pub rule: CombineRule,
}

macro_rules! surface {
    ($name:ident, $default:expr, $most:expr) => {
        impl Default for $name {
            fn default() -> Self {
                Self::new($default)
            }
        }

        impl KeptProperty for $name {
            fn check(&self) -> Result<(), BodyProblem> {
                match self.is_valid() {
                    true => Ok(()),
                    false => Err(BodyProblem::InvalidMaterial),
                }
            }
        }

        impl $name {
            /// With the rule [`CombineRule::Average`].
            pub const fn new(coefficient: f32) -> Self {
                Self {
                    coefficient,
                    rule: CombineRule::Average,
                }
            }

            /// This with another rule.
            pub const fn with_rule(mut self, rule: CombineRule) -> Self {
                self.rule = rule;
                self
            }

            /// The coefficient between two surfaces.
            pub fn combine(self, other: Self) -> f32 {
                self.rule
                    .max(other.rule)
                    .apply(self.coefficient, other.coefficient)
            }

            /// True for a coefficient that is not negative and not beyond what can be.
            pub fn is_valid(self) -> bool {
                limits::share_of(self.coefficient, $most)
            }
        }
    };
}

surface!(Friction, 0.5, limits::FRICTION);
surface!(Restitution, 0.0, limits::RESTITUTION);
surface!(RollingFriction, 0.05, limits::FRICTION);
