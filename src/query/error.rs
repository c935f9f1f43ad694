//! Errors of spatial queries.

use bevy_ecs::entity::Entity;
use thiserror::Error;

/// Why a query cannot be answered.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum QueryError {
    /// The named point, pose or direction is NaN or infinite, or its rotation has length zero.
    #[error("{0} is not finite")]
    NotFinite(&'static str),
    /// The distance is negative or NaN, m.
    #[error("a distance of {0} m: it must not be negative")]
    InvalidDistance(f32),
    /// The shape of the query has no volume, or a size out of [`limits`](crate::body::limits).
    #[error("the shape to ask with has no volume, or a size out of bounds")]
    DegenerateShape,
    /// The shape of the query is a half-space. Half-spaces can be hit, but cannot be cast or tested.
    #[error("a half-space has no end, and cannot be asked with")]
    Unbounded,
    /// The shape of the query cannot be compared with that of this body: both are surfaces, which have no inside, or parry does not
    /// support the pair.
    #[error(
        "the shape to ask with cannot be compared with that of {0}: two surfaces have no inside; filter that body out, or ask \
                 with a solid"
    )]
    Unsupported(Entity),
}
