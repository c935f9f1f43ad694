//! Errors of previews.

use bevy_ecs::entity::Entity;
use thiserror::Error;

/// Why an edit cannot be previewed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum PreviewError {
    /// The entity is not a body known to the simulation: it has no [`RigidBody`](crate::body::RigidBody), is quarantined, or was spawned
    /// after the last step.
    #[error("{}", crate::contact::NotABody(*.0))]
    NotABody(Entity),
    /// The edit removes no bodies.
    #[error("an edit that takes no body: there is nothing to try")]
    Nothing,
    /// A position or rotation is not finite, or a rotation has length zero.
    #[error("a pose of the edit is not finite, or its rotation has no length")]
    NotFinite,
    /// The shape to be placed has no volume or is unbounded.
    #[error(
        "what is placed has no volume or no end: a half-space, a surface, or a size that is not positive"
    )]
    InvalidShape,
    /// The step length is not valid, or another setting is negative or not finite.
    #[error(
        "the settings of a preview: `dt` must be a step's length, `max_time` and `movement_threshold` between 0 and 1e6"
    )]
    InvalidSettings,
}
