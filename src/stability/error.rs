//! Errors of the stability analysis.

use bevy_ecs::entity::Entity;
use std::fmt;

/// The reason why a margin cannot be computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StabilityError {
    /// The structure has no bodies.
    Nothing,
    /// The entity is not a body known to the simulation: it has no [`RigidBody`](crate::body::RigidBody), is quarantined, or was spawned
    /// after the last step.
    NotABody(Entity),
    /// The body is static or kinematic, and cannot fail.
    Fixed(Entity),
    /// The body has a [joint](crate::joint), whose force the analysis does not know.
    Jointed(Entity),
    /// The body that is pulled does not belong to the structure.
    NotOfStructure(Entity),
    /// A direction is zero or not finite, or the direction of a tilt is parallel to gravity.
    NoDirection,
    /// A tilt has no effect without gravity.
    NoGravity,
    /// A point is not finite.
    NotFinite,
    /// The structure does not stand without the load: no joint forces balance its weight.
    Falls,
    /// The structure has this many bodies, more than [`MAX_BODIES`](super::MAX_BODIES).
    TooMany(usize),
    /// The cone program was not solved: it is too large or too badly scaled.
    Unsolved,
}

impl fmt::Display for StabilityError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Nothing => f.write_str("the structure has no bodies: name at least one"),
            Self::NotABody(entity) => crate::contact::NotABody(*entity).fmt(f),
            Self::Fixed(entity) => write!(
                f,
                "{entity} is static or kinematic: name only the dynamic bodies of a structure"
            ),
            Self::Jointed(entity) => write!(
                f,
                "{entity} has a joint: only structures that stand by contact have a margin"
            ),
            Self::NotOfStructure(entity) => {
                write!(
                    f,
                    "{entity} is pulled but does not belong to the structure: name it too"
                )
            }
            Self::NoDirection => {
                f.write_str("the direction is zero, not finite, or, for a tilt, parallel to gravity")
            }
            Self::NoGravity => f.write_str("a tilt has no effect, because gravity is zero"),
            Self::NotFinite => f.write_str("the point at which the body is pulled is not finite"),
            Self::Falls => f.write_str(
                "the structure does not stand as it is: no forces in its joints balance its weight",
            ),
            Self::TooMany(count) => write!(
                f,
                "the structure has {count} bodies, and at most {} are possible: name only those near the load; bodies that are not named are \
                 assumed not to move",
                super::MAX_BODIES
            ),
            Self::Unsolved => f.write_str(
                "the cone program of the structure was not solved: it is too large or too badly scaled",
            ),
        }
    }
}

impl std::error::Error for StabilityError {}
