//! Why a region cannot be taken out.

use bevy_ecs::entity::Entity;
use thiserror::Error;

/// The reason why a region was not taken out. Nothing has changed then.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum StreamingError {
    /// The world has no resources for a step, because this plugin was not added.
    #[error("`{0}` is missing; add `DrystonePlugins` to the app")]
    MissingPlugin(&'static str),
    /// The entity is not a body known to the simulation: it has no [`RigidBody`](crate::body::RigidBody), is disabled, quarantined or out
    /// already, or was spawned after the last step.
    #[error("{}", crate::contact::NotABody(*.0))]
    NotABody(Entity),
    /// The body is awake, or moves, or came to rest in one of the last two steps.
    #[error(
        "{0} is not at rest: take it out two steps after it fell asleep, or leave it in the world"
    )]
    NotAtRest(Entity),
    /// The body is a half-space, which is near everything.
    #[error("{0} is a half-space, which belongs to the whole world: leave it there")]
    Unbounded(Entity),
    /// A hand or a [`Grab`](crate::grab::Grab) holds the body.
    #[error("{0} is held: let go of it first, or leave it in the world")]
    Held(Entity),
    /// The body has a joint or a bond of mortar.
    #[error(
        "{body} has the joint {joint}: despawn the joint first, or leave the body in the world"
    )]
    Joined {
        /// The body.
        body: Entity,
        /// The joint.
        joint: Entity,
    },
    /// An awake body touches the body. It would fall.
    #[error(
        "{other} is awake and touches {body}: wait until it sleeps or is elsewhere, or take it out later"
    )]
    BesideAwake {
        /// The body of the region.
        body: Entity,
        /// The awake one.
        other: Entity,
    },
}
