//! Why a mesh has no collider.

use crate::body::collider::ColliderError;
use bevy_ecs::prelude::*;
use std::fmt;
use thiserror::Error;

/// A message: a mesh gets no collider. It is logged too.
#[derive(Message, Clone, Debug, PartialEq, Eq, Error)]
pub struct MeshColliderError {
    /// The entity with the mesh.
    pub entity: Entity,
    /// Its `Name`, or that of the nearest entity above that has one.
    pub name: Option<String>,
    /// The problem.
    pub problem: MeshProblem,
}

/// Why a mesh cannot become a collider.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum MeshProblem {
    /// The mesh cannot have the shape that was asked for.
    #[error("{0}")]
    Shape(#[from] ColliderError),
    /// The mesh was not loaded, for this reason.
    #[error("it was not loaded: {0}")]
    NotLoaded(String),
    /// The glTF extras of it or of an entity above it are invalid. This says what is wrong and what is right.
    #[error("{0}")]
    Extras(String),
}

impl fmt::Display for MeshColliderError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.name {
            Some(name) => write!(f, "mesh `{name}` ({})", self.entity)?,
            None => write!(f, "mesh {}", self.entity)?,
        }
        write!(f, " gets no collider: {}", self.problem)
    }
}
