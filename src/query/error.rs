//! Errors of spatial queries.

use bevy_ecs::entity::Entity;
use std::fmt;

/// Why a query cannot be answered.
#[derive(Clone, Debug, PartialEq)]
pub enum QueryError {
    /// The named point, pose or direction is NaN or infinite, or its rotation has length zero.
    NotFinite(&'static str),
    /// The distance is negative or NaN, m.
    InvalidDistance(f32),
    /// The shape of the query has no volume, or a size out of [`limits`](crate::body::limits).
    DegenerateShape,
    /// The shape of the query is a half-space. Half-spaces can be hit, but cannot be cast or tested.
    Unbounded,
    /// The shape of the query cannot be compared with that of this body: both are surfaces, which have no inside, or parry does not
    /// support the pair.
    Unsupported(Entity),
}

impl fmt::Display for QueryError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotFinite(what) => write!(f, "{what} is not finite"),
            Self::InvalidDistance(distance) => {
                write!(f, "a distance of {distance} m: it must not be negative")
            }
            Self::DegenerateShape => {
                f.write_str("the shape to ask with has no volume, or a size out of bounds")
            }
            Self::Unsupported(body) => write!(
                f,
                "the shape to ask with cannot be compared with that of {body}: two surfaces have no inside; filter that body out, or ask \
                 with a solid"
            ),
            Self::Unbounded => f.write_str("a half-space has no end, and cannot be asked with"),
        }
    }
}

impl std::error::Error for QueryError {}
