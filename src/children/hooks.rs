//! Hooks and observers that note which bodies must be assembled anew, and that keep the mass of a body up to date when parts are inserted.

use super::assemble::Unassembled;
use super::compound::CompoundCollider;
use super::gather::{ColliderOf, scale_of};
use super::implicit::ImplicitBody;
use crate::body::{RigidBody, note_loss, weigh, weigh_above, weigh_with_parts};
use crate::collider::Collider;
use crate::components::remove_later;
use crate::sensor::Sensor;
use bevy_ecs::component::Components;
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::hierarchy::{ChildOf, Children};
use bevy_ecs::lifecycle::HookContext;
use bevy_ecs::prelude::*;
use bevy_ecs::world::DeferredWorld;
use glam::Vec3;

/// Notes that the colliders at or below an entity may belong to another body, or have changed.
pub(crate) fn mark(world: &mut DeferredWorld, entity: Entity) {
    if let Some(mut unassembled) = world.get_resource_mut::<Unassembled>() {
        unassembled.push(entity);
    }
}

/// Whether a body with this entity may need more than its own collider.
fn is_composite(world: &DeferredWorld, entity: Entity) -> bool {
    let body = world.entity(entity);
    body.contains::<Children>()
        || body.contains::<ChildOf>()
        || body.contains::<Sensor>()
        || body.contains::<CompoundCollider>()
        || scale_of(world, entity) != Vec3::ONE
}

/// Hook of [`Collider`].
pub(crate) fn collider_inserted(mut world: DeferredWorld, context: HookContext) {
    let is_body = world.get::<RigidBody>(context.entity).is_some();
    if !is_body || is_composite(&world, context.entity) {
        mark(&mut world, context.entity);
    }
    weigh(world, context);
}

/// Part of the hook of components whose removal counts as a change.
pub(crate) fn mark_if_part(world: &mut DeferredWorld, entity: Entity) {
    let is_part = world
        .get_entity(entity)
        .is_ok_and(|known| known.contains::<ColliderOf>() || known.contains::<CompoundCollider>());
    if is_part {
        mark(world, entity);
    }
}

/// Hook of [`RigidBody`], on insertion. A body that a user inserts replaces an implicit one.
pub(crate) fn changed_kind(mut world: DeferredWorld, context: HookContext) {
    let entity = context.entity;
    if world.get::<ImplicitBody>(entity).is_some() {
        remove_later(
            &mut world.commands(),
            entity,
            Components::component_id::<ImplicitBody>,
        );
        mark(&mut world, entity);
    } else if world.get::<ColliderOf>(entity).is_some() || is_composite(&world, entity) {
        mark(&mut world, entity);
    }
}

/// Hook of [`RigidBody`], on removal.
pub(crate) fn lost_kind(mut world: DeferredWorld, context: HookContext) {
    mark(&mut world, context.entity);
}

/// Hook of [`Sensor`].
pub(crate) fn sensor_changed(mut world: DeferredWorld, context: HookContext) {
    mark(&mut world, context.entity);
    weigh_above(&mut world, context.entity);
}

/// Whether there may be colliders at or below an entity.
fn may_carry(world: &DeferredWorld, entity: Entity) -> bool {
    world.get::<Collider>(entity).is_some() || world.get::<Children>(entity).is_some()
}

/// Observer: an entity got a parent.
pub(crate) fn child_joined(joined: On<Insert<ChildOf>>, mut world: DeferredWorld) {
    if may_carry(&world, joined.entity) {
        mark(&mut world, joined.entity);
        let above = world.get::<ChildOf>(joined.entity).map(ChildOf::parent);
        if let Some(body) = above.and_then(|above| super::body_of(&world, above)) {
            // A first child is added to its parent's list only by a command.
            world.commands().queue(move |world: &mut World| {
                if world.get::<RigidBody>(body).is_some() {
                    weigh_with_parts(&mut DeferredWorld::from(world), body);
                }
            });
        }
    }
}

/// Observer: an entity lost its parent. The `Transform` of a body now means another pose, so *prepare* reads the body again.
pub(crate) fn child_left(left: On<Remove<ChildOf>>, mut world: DeferredWorld) {
    note_loss(&mut world, left.entity);
    if may_carry(&world, left.entity) {
        mark(&mut world, left.entity);
    }
}

/// Observer: an entity was enabled again. What was written while it was disabled has not been noticed.
pub(crate) fn child_enabled(enabled: On<Remove<Disabled>>, mut world: DeferredWorld) {
    let entity = world.entity(enabled.entity);
    let is_part = entity.contains::<Collider>() && !entity.contains::<RigidBody>();
    if is_part || entity.contains::<CompoundCollider>() {
        mark(&mut world, enabled.entity);
    }
}
