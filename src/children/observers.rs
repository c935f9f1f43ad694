//! Observers that note which bodies must be assembled anew when the hierarchy changes.

use crate::body::parts::{CompoundCollider, body_of, mark};
use crate::body::{RigidBody, collider::Collider, note_loss, weigh_with_parts};
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::hierarchy::{ChildOf, Children};
use bevy_ecs::prelude::*;
use bevy_ecs::world::DeferredWorld;

/// Whether there may be colliders at or below an entity.
fn may_carry(world: &DeferredWorld, entity: Entity) -> bool {
    world.get::<Collider>(entity).is_some() || world.get::<Children>(entity).is_some()
}

/// Observer: an entity got a parent.
pub(crate) fn child_joined(joined: On<Insert<ChildOf>>, mut world: DeferredWorld) {
    if may_carry(&world, joined.entity) {
        mark(&mut world, joined.entity);
        let above = world.get::<ChildOf>(joined.entity).map(ChildOf::parent);
        if let Some(body) = above.and_then(|above| body_of(&world, above)) {
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

/// Observer: an entity was enabled again. Changes while it was disabled have not been noticed.
pub(crate) fn child_enabled(enabled: On<Remove<Disabled>>, mut world: DeferredWorld) {
    let entity = world.entity(enabled.entity);
    let is_part = entity.contains::<Collider>() && !entity.contains::<RigidBody>();
    if is_part || entity.contains::<CompoundCollider>() {
        mark(&mut world, enabled.entity);
    }
}
