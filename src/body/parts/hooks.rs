//! Hooks that note which bodies must be assembled anew, and that keep the mass of a body up to date when parts are inserted.

use super::{ColliderOf, CompoundCollider, ImplicitBody, Sensor, scale_of};
use crate::body::mass::{weigh, weigh_above};
use crate::body::{RigidBody, collider::Collider};
use crate::components::{holders_in, remove_later};
use bevy_ecs::component::Components;
use bevy_ecs::entity::{EntityMapper, MapEntities};
use bevy_ecs::hierarchy::{ChildOf, Children};
use bevy_ecs::lifecycle::HookContext;
use bevy_ecs::prelude::*;
use bevy_ecs::world::DeferredWorld;
use glam::Vec3;

/// Entities at or below which colliders may have changed their body since the last step.
#[derive(Resource, Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[component(clone_behavior = Ignore, map_entities)]
#[doc(hidden)]
pub struct Unassembled(Vec<Entity>);

impl Unassembled {
    fn push(&mut self, entity: Entity) {
        self.0.push(entity);
    }

    /// Takes the entities.
    pub(crate) fn take(&mut self) -> Vec<Entity> {
        std::mem::take(&mut self.0)
    }
}

/// Contains the colliders that were spawned before the plugins were added, when no hook noted them.
impl FromWorld for Unassembled {
    fn from_world(world: &mut World) -> Self {
        Self(holders_in(world, &[Components::component_id::<Collider>]))
    }
}

impl MapEntities for Unassembled {
    fn map_entities<M: EntityMapper>(&mut self, mapper: &mut M) {
        self.0.map_entities(mapper);
    }
}

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
