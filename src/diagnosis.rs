//! Bad input, as values with a sentence a user can act on.

use bevy_ecs::prelude::*;
use bevy_reflect::Reflect;
use std::fmt;

/// What is wrong with a body or about to go wrong.
#[derive(Clone, Debug, PartialEq, Reflect)]
pub enum BodyProblem {
    /// Its `Transform` or `Pose` holds NaN or infinity, or a rotation of length zero.
    NonFinitePose,
    /// Its `Velocity` holds NaN or infinity.
    NonFiniteVelocity,
    /// Its external force or impulse holds NaN or infinity.
    NonFiniteForce,
    /// Mass or moments of inertia of a dynamic body are zero, negative or not finite.
    InvalidMass,
    /// The shape has no size in some direction, or a size that is not finite.
    DegenerateShape,
    /// Friction, rolling friction or restitution is negative or not finite.
    InvalidMaterial,
    /// The solve gave it a velocity that is not finite; the one before is kept.
    Diverged,
    /// It touches a body more than [`EXTREME_MASS_RATIO`] times as heavy or light: the solve converges slowly.
    ExtremeMassRatio {
        /// The other body.
        other: Entity,
    },
    /// It lies exactly where another body lies, so that no direction leads apart; they are parted upwards.
    Coincident {
        /// The other body.
        other: Entity,
    },
}

/// Ratios from here on are reported, since an iterative solver spreads impulses over them very slowly.
pub const EXTREME_MASS_RATIO: f32 = 1e5;

impl BodyProblem {
    /// True where the body cannot be simulated at all.
    pub fn is_fatal(&self) -> bool {
        !matches!(
            self,
            Self::ExtremeMassRatio { .. } | Self::Coincident { .. }
        )
    }
}

impl fmt::Display for BodyProblem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NonFinitePose => {
                f.write_str("its pose is not finite, or its rotation has length zero")
            }
            Self::NonFiniteVelocity => f.write_str("its velocity is not finite"),
            Self::NonFiniteForce => f.write_str("its external force or impulse is not finite"),
            Self::InvalidMass => f.write_str(
                "its mass or inertia is zero, negative or not finite; a body without mass must be static or kinematic",
            ),
            Self::DegenerateShape => {
                f.write_str("its shape has no volume, or a size that is not finite")
            }
            Self::InvalidMaterial => f.write_str("its friction, rolling friction or restitution is negative or not finite"),
            Self::Diverged => f.write_str(
                "the solve gave it a velocity that is not finite; look for extreme forces, masses or sizes",
            ),
            Self::ExtremeMassRatio { other } => write!(
                f,
                "it touches {other}, whose mass differs by more than {EXTREME_MASS_RATIO:.0} times: expect slow convergence"
            ),
            Self::Coincident { other } => {
                write!(f, "it lies exactly where {other} lies; they are parted along one axis")
            }
        }
    }
}

/// Sent when a body is quarantined, or may behave badly.
#[derive(Message, Clone, Debug, PartialEq)]
pub struct BodyError {
    /// The body.
    pub entity: Entity,
    /// Its `Name`, where it has one.
    pub name: Option<String>,
    /// What is wrong.
    pub problem: BodyProblem,
}

impl fmt::Display for BodyError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.name {
            Some(name) => write!(f, "body `{name}` ({})", self.entity)?,
            None => write!(f, "body {}", self.entity)?,
        }
        let fate = if self.problem.is_fatal() {
            " is quarantined"
        } else {
            ""
        };
        write!(f, "{fate}: {}", self.problem)
    }
}

impl std::error::Error for BodyError {}

/// Sent when a step cannot be taken at all.
#[derive(Message, Clone, Copy, Debug, PartialEq)]
pub enum StepError {
    /// Δt is negative, NaN or infinite. (Zero is a pause, and takes no step either.)
    InvalidTimeStep(f32),
}

impl fmt::Display for StepError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self::InvalidTimeStep(dt) = self;
        write!(
            f,
            "no step taken: Δt is {dt} s, but must be positive and finite"
        )
    }
}

impl std::error::Error for StepError {}

/// Problems found in this step, on their way to the stage *quarantine*.
#[derive(Resource, Default)]
pub struct Suspects(pub(crate) Vec<(Entity, BodyProblem)>);
