//! Questions that have no answer.

use bevy_ecs::entity::Entity;
use std::fmt;

/// Why a question has no answer.
#[derive(Clone, Debug, PartialEq)]
pub enum QueryError {
    /// A point, a pose or a distance is NaN or infinite, as named; a rotation may have no length.
    NotFinite(&'static str),
    /// A distance is negative or NaN, m.
    InvalidDistance(f32),
    /// The shape that is asked with has no volume, or a size that is not within [`limits`](crate::body::limits).
    DegenerateShape,
    /// The shape that is asked with has no end: a half-space may be hit, but not be moved.
    Unbounded,
    /// The shape that is asked with cannot be compared with that of this body: both are surfaces, which have no inside, or one is of a kind
    /// that parry does not know.
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
