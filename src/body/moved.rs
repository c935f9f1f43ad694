//! A body that has another pose than before.

use super::Pose;
use bevy_ecs::entity::Entity;

/// A body that moves from one pose to another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moved {
    /// The body.
    pub body: Entity,
    /// Its pose before.
    pub from: Pose,
    /// Its pose after.
    pub to: Pose,
}
