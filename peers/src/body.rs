//! A body of a drystone scene, for all engines.

use bevy_ecs::entity::Entity;
use drystone::prelude::{
    Collider, CollisionLayers, Friction, Pose, Restitution, RigidBody, Velocity,
};

/// A body before the first step.
pub struct Body {
    pub entity: Entity,
    pub kind: RigidBody,
    pub collider: Collider,
    pub pose: Pose,
    pub velocity: Velocity,
    pub density: f32,
    pub friction: Friction,
    pub restitution: Restitution,
    pub layers: CollisionLayers,
}
