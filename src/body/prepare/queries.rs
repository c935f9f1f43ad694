//! Queries of bodies. Stages share them, because Bevy compiles some thousands of lines for each query that differs from others.

use crate::body::{
    BodyIndex, Damping, ExternalForce, ExternalImpulse, GravityScale, Inactive, MassProperties,
    Motion, Pose, RigidBody, Simulated, Sleeping, SpawnOrder, Velocity,
};
use bevy_ecs::hierarchy::ChildOf;
use bevy_ecs::prelude::*;
use bevy_ecs::query::QueryData;
use bevy_transform::components::Transform;

/// The components of a body that the stages after *prepare* read and write.
#[derive(QueryData)]
#[query_data(mutable)]
pub struct ActiveBody {
    pub entity: Entity,
    pub index: &'static BodyIndex,
    pub mass: &'static MassProperties,
    pub velocity: &'static mut Velocity,
    pub motion: &'static mut Motion,
    pub pose: &'static mut Pose,
    pub transform: &'static mut Transform,
    pub sleeping: &'static mut Sleeping,
    pub force: Option<&'static ExternalForce>,
    pub impulse: Option<&'static mut ExternalImpulse>,
    pub damping: Option<&'static Damping>,
    pub gravity_scale: Option<&'static GravityScale>,
    pub is_child: Has<ChildOf>,
}

/// The bodies that stages compute.
pub type ActiveBodies<'w, 's> = Query<'w, 's, ActiveBody, (Simulated, Without<Inactive>)>;

/// The components of a body that tell where it is, and where its user put it.
pub(crate) type Placing<'w> = (
    (
        Entity,
        &'w SpawnOrder,
        &'w BodyIndex,
        &'w Pose,
        &'w Velocity,
    ),
    (&'w Transform, Option<&'w ChildOf>),
);

/// Filter for bodies that are not taken out of the simulation.
type Sound = (With<RigidBody>, Simulated);

/// All bodies in the simulation, for reading.
pub(crate) type PlacedBodies<'w, 's> = Query<'w, 's, Placing<'static>, Sound>;

/// Those of them that are active.
pub(crate) type PlacedActive<'w, 's> = Query<'w, 's, Placing<'static>, (Sound, Without<Inactive>)>;
