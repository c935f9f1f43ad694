//! Bodies that were made of colliders that cannot be parts of a body: alone, or without volume.

use crate::body::{
    BodyIndex, MassProperties, Motion, Pose, Quarantined, RigidBody, Sleeping, Teleport, Velocity,
};
use crate::components::{FindId, remove};
use bevy_ecs::component::Components;
use bevy_ecs::prelude::*;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::{Reflect, std_traits::ReflectDefault};

/// Marks a collider that has no body above it, and was made a static body for that reason. Also a mesh, height field, triangle or
/// half-space below a static or kinematic body, which was made a body of that kind.
///
/// If the entity gets a body above it that it can be a part of, it loses its [`RigidBody`] again. Insert a `RigidBody` to make it a body of
/// its own.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "bevy_reflect",
    derive(Reflect),
    reflect(Component, Debug, Default)
)]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[component(clone_behavior = Ignore)]
pub struct ImplicitBody;

/// Makes a collider a body of this kind.
pub(super) fn make_body(world: &mut World, entity: Entity, kind: RigidBody) {
    let Ok(mut entity) = world.get_entity_mut(entity) else {
        return;
    };
    if entity.contains::<ImplicitBody>() {
        let known = entity.get_mut::<RigidBody>();
        if known.is_some_and(|mut known| known.set_if_neq(kind)) {
            // It has come below another body. That is a new place, not a motion that would throw what it meets.
            entity.insert(Teleport);
        }
        return;
    }
    // The marker comes second: a `RigidBody` that is inserted where it is counts as a user's.
    let id = entity.insert(kind).id();
    if let Ok(mut entity) = world.get_entity_mut(id) {
        entity.insert(ImplicitBody);
    }
}

/// Takes the body from a collider that has become a part of another body.
pub(super) fn take_body(world: &mut World, entity: Entity) {
    if world.get::<ImplicitBody>(entity).is_none() {
        return;
    }
    let all: &[FindId] = &[
        Components::component_id::<RigidBody>,
        Components::component_id::<ImplicitBody>,
        Components::component_id::<BodyIndex>,
        Components::component_id::<Quarantined>,
        Components::component_id::<Pose>,
        Components::component_id::<Velocity>,
        Components::component_id::<Motion>,
        Components::component_id::<Sleeping>,
        Components::component_id::<MassProperties>,
    ];
    remove(world, entity, all);
}
