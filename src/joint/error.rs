//! Errors about joints.

use bevy_ecs::entity::{EntityMapper, MapEntities};
use bevy_ecs::prelude::*;
use bevy_reflect::Reflect;
use std::fmt;

/// A problem of a joint, which disables it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Reflect)]
pub enum JointProblem {
    /// An anchor is not finite or out of bounds.
    InvalidAnchor,
    /// A basis is not finite or of length zero.
    InvalidBasis,
    /// The axis of a hinge, a slider or a twist is zero or not finite.
    InvalidAxis,
    /// Limits are reversed, not numbers, or out of bounds.
    InvalidLimits,
    /// The maximum of a distance is not above zero.
    InvalidDistance,
    /// A motor or spring has a target that is not finite, or a stiffness, damping or maximum force that is negative or not a number.
    InvalidMotor,
    /// The friction is negative, not finite or out of bounds.
    InvalidFriction,
    /// The [`BreakForce`](super::BreakForce) is negative or not a number.
    InvalidBreakForce,
    /// The corners of a [`MortarJoint`](crate::mortar::MortarJoint) enclose no area, or a strength is negative or not a number.
    InvalidSection,
    /// An entity is not a body, or was despawned.
    NotABody {
        /// The entity.
        entity: Entity,
    },
    /// Body 1 and body 2 are the same.
    SameBody {
        /// That body.
        body: Entity,
    },
    /// Neither body is dynamic.
    NothingMoves,
    /// The entity has several joint components.
    SeveralJoints,
}

impl MapEntities for JointProblem {
    fn map_entities<M: EntityMapper>(&mut self, mapper: &mut M) {
        match self {
            Self::NotABody { entity: named } | Self::SameBody { body: named } => {
                named.map_entities(mapper);
            }
            _ => {}
        }
    }
}

impl fmt::Display for JointProblem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::InvalidAnchor => f.write_str("an anchor is not finite or too far away"),
            Self::InvalidBasis => f.write_str("a basis is not finite or has length zero"),
            Self::InvalidAxis => f.write_str("its axis is not finite or has length zero"),
            Self::InvalidLimits => {
                f.write_str("its limits are not numbers, or the minimum is above the maximum")
            }
            Self::InvalidDistance => f.write_str(
                "the maximum of its distance is not above zero; use a `SphericalJoint` to keep two points together",
            ),
            Self::InvalidMotor => f.write_str(
                "a motor or spring has a target that is not finite, or a stiffness, damping or maximum force that is negative or not a number",
            ),
            Self::InvalidFriction => f.write_str("its friction is negative or not finite"),
            Self::InvalidBreakForce => f.write_str(
                "its `BreakForce` has a force, torque or response that is negative or not a number",
            ),
            Self::InvalidSection => f.write_str(
                "the corners of its patch enclose no area, or a strength of its mortar is negative or not a number",
            ),
            Self::NotABody { entity } => write!(
                f,
                "{entity} is not a body, or was despawned; despawn the joint as well, or give it another body"
            ),
            Self::SameBody { body } => write!(f, "both of its bodies are {body}"),
            Self::NothingMoves => f.write_str(
                "neither of its bodies is dynamic; static and kinematic bodies and the world do not move each other",
            ),
            Self::SeveralJoints => f.write_str(
                "its entity has several joint components; give each joint an entity of its own",
            ),
        }
    }
}

/// A message: a joint is disabled because of its input. Its bodies and all others are simulated on.
#[derive(Message, Clone, Debug, PartialEq, Reflect)]
#[reflect(Message, Debug)]
pub struct JointError {
    /// The joint.
    pub joint: Entity,
    /// Its `Name`, if it has one.
    pub name: Option<String>,
    /// Its bodies; `None` is the world.
    pub bodies: [Option<Entity>; 2],
    /// The problem.
    pub problem: JointProblem,
}

impl fmt::Display for JointError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.name {
            Some(name) => write!(f, "joint `{name}` ({})", self.joint)?,
            None => write!(f, "joint {}", self.joint)?,
        }
        let name = |body: Option<Entity>| match body {
            Some(body) => body.to_string(),
            None => "the world".to_owned(),
        };
        let [one, other] = self.bodies.map(name);
        write!(
            f,
            " between {one} and {other} is disabled: {}; it comes back by itself when that is mended",
            self.problem
        )
    }
}

impl std::error::Error for JointError {}

/// Marks a joint that does nothing because of invalid input. Once the input is corrected, the next step removes the marker, and the joint works
/// again.
#[derive(Component, Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Component, Debug)]
#[component(clone_behavior = Ignore, map_entities)]
pub struct QuarantinedJoint {
    /// The problem.
    pub problem: JointProblem,
}

impl MapEntities for QuarantinedJoint {
    fn map_entities<M: EntityMapper>(&mut self, mapper: &mut M) {
        self.problem.map_entities(mapper);
    }
}
