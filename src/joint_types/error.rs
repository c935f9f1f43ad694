//! Errors about joints.

use crate::solver::Both;
use bevy_ecs::entity::{EntityMapper, MapEntities};
use bevy_ecs::prelude::*;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::Reflect;
use std::fmt;
use thiserror::Error;

/// A problem of a joint, which disables it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum JointProblem {
    /// An anchor is not finite or out of bounds.
    #[error("an anchor is not finite or too far away")]
    InvalidAnchor,
    /// A basis is not finite or of length zero.
    #[error("a basis is not finite or has length zero")]
    InvalidBasis,
    /// The axis of a hinge, a slider or a twist is zero or not finite.
    #[error("its axis is not finite or has length zero")]
    InvalidAxis,
    /// Limits are reversed, not numbers, or out of bounds.
    #[error("its limits are not numbers, or the minimum is above the maximum")]
    InvalidLimits,
    /// The angle of a swing cone is not above zero, or above π.
    #[error(
        "the angle of its swing cone is not between 0 and π; use a `RevoluteJoint` if it shall not swing"
    )]
    InvalidCone,
    /// The maximum of a distance is not above zero.
    #[error(
        "the maximum of its distance is not above zero; use a `SphericalJoint` to keep two points together"
    )]
    InvalidDistance,
    /// A motor or spring has a target that is not finite, or a stiffness, damping or maximum force that is negative or not a number.
    #[error(
        "a motor or spring has a target that is not finite, or a stiffness, damping or maximum force that is negative or not a number"
    )]
    InvalidMotor,
    /// The friction is negative, not finite or out of bounds.
    #[error("its friction is negative or not finite")]
    InvalidFriction,
    /// The [`BreakForce`](super::BreakForce) is negative or not a number.
    #[error("its `BreakForce` has a force, torque or response that is negative or not a number")]
    InvalidBreakForce,
    /// The corners of a [`MortarJoint`](crate::mortar::MortarJoint) enclose no area, or a strength is negative or not a number.
    #[error(
        "the corners of its patch enclose no area, or a strength of its mortar is negative or not a number"
    )]
    InvalidSection,
    /// An entity is not a body, or was despawned.
    #[error(
        "{entity} is not a body, or was despawned; despawn the joint as well, or give it another body"
    )]
    NotABody {
        /// The entity.
        entity: Entity,
    },
    /// Body 1 and body 2 are the same.
    #[error("both of its bodies are {body}")]
    SameBody {
        /// That body.
        body: Entity,
    },
    /// Neither body is dynamic.
    #[error(
        "neither of its bodies is dynamic; static and kinematic bodies and the world do not move each other"
    )]
    NothingMoves,
    /// The entity has several joint components.
    #[error("its entity has several joint components; give each joint an entity of its own")]
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

/// A message: a joint is disabled because of its input. Its bodies and all others are simulated on.
#[derive(Message, Clone, Debug, PartialEq, Error)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect), reflect(Message, Debug))]
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
        let [one, other] = self.bodies.both(name);
        write!(
            f,
            " between {one} and {other} is disabled: {}; it comes back by itself when that is mended",
            self.problem
        )
    }
}

/// Marks a joint that does nothing because of invalid input. Once the input is corrected, the next step removes the marker, and the joint
/// works again.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect), reflect(Component, Debug))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
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
