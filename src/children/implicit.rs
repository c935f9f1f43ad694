//! Makes bodies of colliders that cannot be parts of a body: alone, or without volume.

use crate::body::{
    BodyIndex, MassProperties, Motion, Pose, Quarantined, RigidBody, Sleeping, Teleport, Velocity,
    parts::ImplicitBody,
};
use crate::components::{FindId, remove};
use bevy_ecs::component::Components;
use bevy_ecs::prelude::*;

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
