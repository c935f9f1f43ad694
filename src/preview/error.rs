//! Errors of previews.

use bevy_ecs::entity::Entity;
use std::fmt;

/// Why an edit cannot be previewed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PreviewError {
    /// The entity is not a body known to the simulation: it has no [`RigidBody`](crate::body::RigidBody), is quarantined, or was spawned
    /// after the last step.
    NotABody(Entity),
    /// The edit removes no bodies.
    Nothing,
    /// A position or rotation is not finite, or a rotation has length zero.
    NotFinite,
    /// The shape to be placed has no volume or is unbounded.
    InvalidShape,
    /// The step length is not valid, or another setting is negative or not finite.
    InvalidSettings,
}

impl fmt::Display for PreviewError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotABody(entity) => crate::contact::NotABody(*entity).fmt(f),
            Self::Nothing => f.write_str("an edit that takes no body: there is nothing to try"),
            Self::NotFinite => f.write_str("a pose of the edit is not finite, or its rotation has no length"),
            Self::InvalidShape => f.write_str(
                "what is placed has no volume or no end: a half-space, a surface, or a size that is not positive",
            ),
            Self::InvalidSettings => f.write_str(
                "the settings of a preview: `dt` must be a step's length, `max_time` and `movement_threshold` between 0 and 1e6",
            ),
        }
    }
}

impl std::error::Error for PreviewError {}
