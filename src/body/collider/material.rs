//! Surface materials: friction, restitution and rolling friction, and how those of two bodies are combined.

use crate::body::{KeptProperty, limits};
use crate::diagnosis::BodyProblem;
use bevy_ecs::prelude::*;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::{Reflect, std_traits::ReflectDefault};

/// The rule that combines the coefficients a and b of two surfaces. If the two bodies have different rules, the later one in this list is
/// used.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect))]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
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

/// Coulomb friction of a body's surface. Default: a coefficient of 0.5.
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
pub struct Friction {
    /// Coefficient of friction μ, without unit: not negative, and at most [`limits::FRICTION`](crate::body::limits::FRICTION).
    pub coefficient: f32,
    /// How it is combined with that of the other body. Default: [`CombineRule::Average`].
    pub rule: CombineRule,
}

/// Restitution (bounciness) of a body's surface. Default: a coefficient of 0.
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
pub struct Restitution {
    /// Coefficient of restitution e, without unit, from 0 (no bounce) to 1 (no loss).
    pub coefficient: f32,
    /// How it is combined with that of the other body. Default: [`CombineRule::Average`].
    pub rule: CombineRule,
}

/// Resistance of round bodies (balls, capsules, and cylinders and cones on their curved sides) to rolling and spinning. Default: a
/// coefficient of 0.05.
///
/// The resisting moment is at most the coefficient times the body's radius times the normal force, so a ball stays at rest on slopes up
/// to this tangent. It is static friction: above about 0.1 m/s of rolling or slipping it decreases with the fourth power of the speed, so
/// a rolling ball keeps rolling and a creeping one stops. Spin about the normal is resisted at any speed.
///
/// Only [`SoftStep`](crate::solver::SoftStep) has rolling friction; point solvers ignore it.
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
pub struct RollingFriction {
    /// Coefficient as a share of the radius, without unit; not negative.
    pub coefficient: f32,
    /// How it is combined with that of the other body. Default: [`CombineRule::Average`].
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
            /// A surface with this coefficient and [`CombineRule::Average`].
            pub const fn new(coefficient: f32) -> Self {
                Self {
                    coefficient,
                    rule: CombineRule::Average,
                }
            }

            /// The same coefficient with another rule.
            #[must_use]
            pub const fn with_rule(mut self, rule: CombineRule) -> Self {
                self.rule = rule;
                self
            }

            /// The combined coefficient of two surfaces.
            pub fn combine(self, other: Self) -> f32 {
                self.rule
                    .max(other.rule)
                    .apply(self.coefficient, other.coefficient)
            }

            /// Returns true if the coefficient is not negative and within [`limits`].
            pub fn is_valid(self) -> bool {
                limits::share_of(self.coefficient, $most)
            }
        }
    };
}

surface!(Friction, 0.5, limits::FRICTION);
surface!(Restitution, 0.0, limits::RESTITUTION);
surface!(RollingFriction, 0.05, limits::FRICTION);
