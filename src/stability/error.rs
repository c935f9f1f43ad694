//! Errors of the stability analysis.

use bevy_ecs::entity::Entity;
use thiserror::Error;

/// The reason why a margin cannot be computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum StabilityError {
    /// The structure has no bodies.
    #[error("the structure has no bodies: name at least one")]
    Nothing,
    /// The entity is not a body known to the simulation: it has no [`RigidBody`](crate::body::RigidBody), is quarantined, or was spawned
    /// after the last step.
    #[error("{}", crate::contact::NotABody(*.0))]
    NotABody(Entity),
    /// The body is static or kinematic, and cannot fail.
    #[error("{0} is static or kinematic: name only the dynamic bodies of a structure")]
    Fixed(Entity),
    /// The body has a [joint](crate::joint), whose force the analysis does not know.
    #[error("{0} has a joint: only structures that stand by contact have a margin")]
    Jointed(Entity),
    /// The body that is pulled does not belong to the structure.
    #[error("{0} is pulled but does not belong to the structure: name it too")]
    NotOfStructure(Entity),
    /// A direction is zero or not finite, or the direction of a tilt is parallel to gravity.
    #[error("the direction is zero, not finite, or, for a tilt, parallel to gravity")]
    NoDirection,
    /// A tilt has no effect without gravity.
    #[error("a tilt has no effect, because gravity is zero")]
    NoGravity,
    /// A point is not finite.
    #[error("the point at which the body is pulled is not finite")]
    NotFinite,
    /// The structure does not stand without the load: no joint forces balance its weight.
    #[error("the structure does not stand as it is: no forces in its joints balance its weight")]
    Falls,
    /// The structure has this many bodies, more than [`MAX_BODIES`](super::MAX_BODIES).
    #[error(
        "the structure has {0} bodies, and at most {max} are possible: name only those near the load; bodies that are not named are \
                 assumed not to move",
        max = super::MAX_BODIES
    )]
    TooMany(usize),
    /// The cone program was not solved: it is too large or too badly scaled.
    #[error(
        "the cone program of the structure was not solved: it is too large or too badly scaled"
    )]
    Unsolved,
}
