//! Errors about bodies and steps. Each has a message that says what is wrong and how to fix it.
//!
//! A body with invalid input is disabled ([`Quarantined`](crate::body::Quarantined)) and reported as a [`BodyError`]; other bodies are
//! not affected. It comes back by itself when the input is valid again.

use crate::limits::{self, STEP_LENGTHS};
use bevy_ecs::entity::{EntityHashSet, EntityMapper, MapEntities};
use bevy_ecs::prelude::*;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::Reflect;
use std::fmt;
use thiserror::Error;

/// A problem of a body. The bounds of valid input are in [`limits`].
#[derive(Clone, Debug, PartialEq, Error)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum BodyProblem {
    /// The `Transform` or `Pose` is NaN or infinite, its position is out of bounds, or its rotation has length zero.
    #[error(
        "its pose is not finite or farther than {:.0e} m from the origin, or its rotation has length zero",
        limits::POSITION
    )]
    NonFinitePose,
    /// The `Velocity` is NaN, infinite or out of bounds.
    #[error(
        "its velocity is not finite or above {:.0e} m/s or rad/s",
        limits::SPEED
    )]
    NonFiniteVelocity,
    /// The external force or impulse is NaN, infinite or out of bounds, or would make the body faster than the limit.
    #[error(
        "its external force or impulse is not finite, above {:.0e} N, or makes it faster than {:.0e} m/s",
        limits::FORCE,
        limits::SPEED
    )]
    NonFiniteForce,
    /// The damping is negative, not finite or out of bounds.
    #[error("its damping is not between 0 and {:.0e} 1/s", limits::DAMPING)]
    InvalidDamping,
    /// The gravity scale is not finite or out of bounds.
    #[error(
        "its gravity scale is not finite or above {:.0e}",
        limits::GRAVITY_SCALE
    )]
    InvalidGravityScale,
    /// The `Grab` has a point or rotation that is not finite, or a response, speed, force or torque that is negative or not a number.
    #[error(
        "its `Grab` has a point, rotation or response that is not finite, a rotation of length zero, or a speed, force or torque that is \
         negative"
    )]
    InvalidGrab,
    /// The mass or a moment of inertia of a dynamic body is zero, negative, not finite or out of bounds.
    #[error(
        "its mass or inertia is zero, negative, not finite or not between {:.0e} and {:.0e} kg; a body without mass must be static or \
         kinematic",
        limits::LIGHTEST,
        limits::HEAVIEST
    )]
    InvalidMass,
    /// The shape has no extent in some direction, or a size that is not finite or out of bounds.
    #[error(
        "its shape has no volume, or a size that is not between {:.0e} and {:.0e} m",
        limits::SMALLEST,
        limits::LARGEST
    )]
    DegenerateShape,
    /// The scale of its `Transform`, multiplied with those of the entities above it, is zero along some axis or not finite, makes its shape
    /// too small or too large, or mirrors a height field. Negative scales mirror other shapes.
    #[error(
        "the scale of its `Transform`, with those of the entities above it, is zero along some axis, not finite, negative for a height \
         field, or makes the size of its shape not between {:.0e} and {:.0e} m",
        limits::SMALLEST,
        limits::LARGEST
    )]
    InvalidScale,
    /// The friction, rolling friction or restitution is negative, not finite or out of bounds.
    #[error(
        "its friction or rolling friction is not between 0 and {:.0e}, or its restitution not between 0 and 1",
        limits::FRICTION
    )]
    InvalidMaterial,
    /// The surface velocity is NaN, infinite or out of bounds.
    #[error(
        "its surface velocity is not finite or above {:.0e} m/s",
        limits::SPEED
    )]
    InvalidSurfaceVelocity,
    /// The [`Fluid`](crate::fluid::Fluid) has a number that is negative, not finite or out of bounds. It does nothing until that is mended.
    #[error(
        "its `Fluid` has a number that is negative, not finite or out of bounds, and does nothing until that is mended"
    )]
    InvalidFluid,
    /// The [`Wheel`](crate::vehicle::Wheel) has a number that is not finite, out of bounds, or negative or zero where that makes no sense.
    /// It does nothing until that is mended.
    #[error(
        "its `Wheel` has a number that is not finite, out of bounds, or negative or zero where that makes no sense, and does nothing \
         until that is mended"
    )]
    InvalidWheel,
    /// The maximum linear or angular speed is NaN or negative.
    #[error(
        "its `MaxLinearSpeed` or `MaxAngularSpeed` is negative or not a number; an infinite one is no limit"
    )]
    InvalidMaxSpeed,
    /// The [`SolverEffort`](crate::body::SolverEffort) is not a number from 1 to its maximum.
    #[error("its `SolverEffort` is not between 1 and {}", limits::SOLVER_EFFORT)]
    InvalidSolverEffort,
    /// The solve of its island gave an invalid velocity. The island keeps its velocities and poses from before the step, and starts
    /// without impulses.
    #[error(
        "the solve of its island went wrong, and was taken back; look for extreme forces, masses or sizes"
    )]
    Diverged,
    /// It touches a body more than [`EXTREME_MASS_RATIO`] times as heavy or light. The solver converges slowly.
    #[error(
        "it touches {other}, whose mass differs by more than {EXTREME_MASS_RATIO:.0} times: expect slow convergence"
    )]
    ExtremeMassRatio {
        /// The other body.
        other: Entity,
    },
    /// A joint connects it to a body more than [`EXTREME_JOINT_RATIO`] times as light. If the light body bears it, the joint yields.
    #[error(
        "a joint connects it to {other}, whose mass is more than {EXTREME_JOINT_RATIO:.0e} times smaller: if the lighter body bears the \
         heavier one, the joint yields; give the lighter one more mass"
    )]
    ExtremeJointRatio {
        /// The lighter body.
        other: Entity,
    },
    /// Its centre lies exactly at that of another body, so that no direction separates them. They are pushed apart upwards.
    #[error("it lies exactly where {other} lies; they are parted along one axis")]
    Coincident {
        /// The other body.
        other: Entity,
    },
    /// It lies in a crowd of bodies that overlap so many others that only the deepest contacts of each are solved. The others wait until
    /// those bodies have been separated. Reported once for each crowd.
    #[error(
        "it lies in a crowd of bodies that overlap too many others: they are parted by the deepest contacts of each first"
    )]
    Crowded,
    /// The entity has a collider that cannot be a part of the body above it in the hierarchy. The body goes on without it.
    #[error(
        "its `Collider` is left out of {body}: {problem}; it takes part as soon as that is corrected"
    )]
    PartLeftOut {
        /// The body above.
        body: Entity,
        /// The reason.
        problem: PartProblem,
    },
}

/// Why a collider cannot be a part of the body above it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum PartProblem {
    /// Its `Transform` in the frame of the body is not finite, or too far away.
    #[error("its `Transform` is not finite or too far from the body")]
    InvalidTransform,
    /// Its shape has no extent in some direction, also after it was scaled, or a size that is not finite or out of bounds.
    #[error("its shape has no volume, or a size out of bounds, at the scale that it has there")]
    DegenerateShape,
    /// Its density or mass is zero, negative or not finite, or its mass is out of bounds.
    #[error(
        "its density or mass is not positive and finite, or its mass is above {:.0e} kg",
        limits::HEAVIEST
    )]
    InvalidMass,
    /// Its friction, rolling friction or restitution is negative, not finite or out of bounds.
    #[error("its friction, rolling friction or restitution is negative or out of bounds")]
    InvalidMaterial,
    /// It is a mesh, height field, triangle or half-space, or the body's own collider is one, and the body is dynamic.
    #[error(
        "a surface or half-space has no volume: use `Collider::convex_hull` or `Collider::convex_decomposition`, or make the body static \
         or kinematic"
    )]
    Surface,
    /// The body has 4095 other parts already.
    #[error("the body has 4095 other parts: join some with `Collider::compound`")]
    TooMany,
}

impl MapEntities for BodyProblem {
    fn map_entities<M: EntityMapper>(&mut self, mapper: &mut M) {
        match self {
            Self::ExtremeMassRatio { other: named }
            | Self::ExtremeJointRatio { other: named }
            | Self::Coincident { other: named }
            | Self::PartLeftOut { body: named, .. } => named.map_entities(mapper),
            _ => {}
        }
    }
}

/// Mass ratio of two touching bodies from which on it is reported, because an iterative solver converges slowly.
pub const EXTREME_MASS_RATIO: f32 = 5e3;

/// Mass ratio of two jointed bodies from which on it is reported. A load of as many times the mass of a bracket of 1 m that carries it
/// bends the bracket by 14 mm, and one of ten times as many breaks away.
pub const EXTREME_JOINT_RATIO: f32 = 1e5;

impl BodyProblem {
    /// Returns true if the body cannot be simulated and is quarantined.
    pub fn is_fatal(&self) -> bool {
        !matches!(
            self,
            Self::Diverged
                | Self::ExtremeMassRatio { .. }
                | Self::ExtremeJointRatio { .. }
                | Self::Coincident { .. }
                | Self::Crowded
                | Self::InvalidFluid
                | Self::InvalidWheel
                | Self::PartLeftOut { .. }
        )
    }
}

/// A message: a body is quarantined, or may behave badly.
#[derive(Message, Clone, Debug, PartialEq, Error)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect), reflect(Message, Debug))]
pub struct BodyError {
    /// The body.
    pub entity: Entity,
    /// Its `Name`, if it has one.
    pub name: Option<String>,
    /// The problem.
    pub problem: BodyProblem,
}

impl fmt::Display for BodyError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.name {
            Some(name) => write!(f, "body `{name}` ({})", self.entity)?,
            None => write!(f, "body {}", self.entity)?,
        }
        match self.problem.is_fatal() {
            true => write!(
                f,
                " is quarantined: {}; it comes back by itself when that is mended",
                self.problem
            ),
            false => write!(f, ": {}", self.problem),
        }
    }
}

/// Why a step was not taken, or not with the settings asked for. Sent as a message unless stated otherwise.
#[derive(Message, Clone, Debug, PartialEq, Error)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect), reflect(Message, Debug))]
pub enum StepError {
    /// The step length Δt is negative, not finite or not in [`STEP_LENGTHS`]. No step was taken. A length of zero is not an error: it is
    /// a pause.
    #[error("no step taken: Δt is {0} s, but must be between {min:e} and {max} s", min = STEP_LENGTHS.start(), max = STEP_LENGTHS.end())]
    InvalidTimeStep(f32),
    /// The world has no resources for a step, because this plugin was not added. No step was taken. This error is logged, but not sent as a
    /// message: the message queue is missing as well.
    #[error("no step taken: `{0}` is missing; add `DrystonePlugins` to the app")]
    MissingPlugin(&'static str),
    /// A settings resource was invalid. It has been set back to its last valid value, and the step was taken with that.
    #[error("`{resource}` is set back to what it was before: {why}")]
    InvalidSettings {
        /// Name of the resource.
        resource: &'static str,
        /// The problem, as a sentence.
        why: String,
    },
}

/// Problems found in this step, which *quarantine* will report.
#[doc(hidden)]
#[derive(Resource, Clone, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[component(clone_behavior = Ignore, map_entities)]
pub struct FoundProblems(pub(crate) Vec<(Entity, BodyProblem)>);

impl MapEntities for FoundProblems {
    fn map_entities<M: EntityMapper>(&mut self, mapper: &mut M) {
        for (entity, problem) in &mut self.0 {
            entity.map_entities(mapper);
            problem.map_entities(mapper);
        }
    }
}

/// Warnings that were sent. They are not repeated while their cause lasts.
#[derive(Resource, Clone, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[component(clone_behavior = Ignore, map_entities)]
pub struct ReportedProblems {
    /// The first bodies of islands whose solve went wrong in the last step.
    pub(crate) diverged: Vec<Entity>,
    /// There is a [crowd](crate::narrowphase::crowd()).
    pub(crate) crowded: bool,
    /// Hands whose numbers are invalid, so that their grabs stay as they were.
    #[cfg_attr(
        feature = "serde",
        serde(serialize_with = "crate::stored::written::sorted_set")
    )]
    pub(crate) hands: EntityHashSet,
    /// Characters that cannot move.
    #[cfg_attr(
        feature = "serde",
        serde(serialize_with = "crate::stored::written::sorted_set")
    )]
    pub(crate) characters: EntityHashSet,
    /// Colliders that were left out of the body above them.
    #[cfg_attr(
        feature = "serde",
        serde(serialize_with = "crate::stored::written::sorted_set")
    )]
    pub(crate) strays: EntityHashSet,
}

impl MapEntities for ReportedProblems {
    fn map_entities<M: EntityMapper>(&mut self, mapper: &mut M) {
        self.diverged.map_entities(mapper);
        for set in [&mut self.hands, &mut self.characters, &mut self.strays] {
            *set = set.iter().map(|&of| mapper.get_mapped(of)).collect();
        }
    }
}
