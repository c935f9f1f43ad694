//! In place of `extras` without the feature `gltf`: there are none.

use super::MeshColliders;
use super::error::MeshProblem;
use crate::body::collider::{Collider, MeshShape};
use crate::components::put;
use bevy_ecs::prelude::*;

#[derive(Debug, Default)]
pub(super) struct Found;

impl Found {
    pub(super) fn add(
        &mut self,
        _: &MeshColliders,
        _: &World,
        _: Entity,
    ) -> Result<Option<Option<MeshShape>>, MeshProblem> {
        Ok(None)
    }

    pub(super) fn insert(&self, world: &mut World, entity: Entity, collider: Collider) {
        put(world, entity, collider);
    }
}
