//! Which meshes may still become colliders. Observers note entities; nothing is searched while nothing is spawned.

use super::MeshColliders;
use super::shapes::Shapes;
use bevy_ecs::component::Components;
use bevy_ecs::entity::EntityHashSet;
use bevy_ecs::hierarchy::{ChildOf, Children};
use bevy_ecs::prelude::*;
use bevy_ecs::world::DeferredWorld;
use bevy_mesh::Mesh3d;

/// Meshes that may still become colliders.
#[derive(Resource, Debug, Default)]
#[doc(hidden)]
pub struct WaitingMeshes {
    /// Entities at and below which there may be meshes that nobody has looked at.
    pub(super) new: Vec<Entity>,
    /// Entities below a root of which some mesh is not loaded, or its shape is being computed, in the order in which they came.
    pub(super) meshes: Vec<Entity>,
    /// The shapes of these meshes.
    pub(super) shapes: Shapes,
}

impl WaitingMeshes {
    /// Adds the meshes at and below new entities to those that wait, each once.
    pub(super) fn look(&mut self, world: &World) {
        let mut seen = EntityHashSet::default();
        let mut known: EntityHashSet = self.meshes.iter().copied().collect();
        for root in std::mem::take(&mut self.new) {
            let mut stack = vec![root];
            while let Some(at) = stack.pop() {
                let Ok(entity) = world.get_entity(at) else {
                    continue;
                };
                if !seen.insert(at) {
                    continue;
                }
                if entity.contains::<Mesh3d>() && known.insert(at) {
                    self.meshes.push(at);
                }
                if let Some(children) = entity.get::<Children>() {
                    stack.extend(children.iter().rev());
                }
            }
        }
    }
}

/// Run condition: whether there is anything to do.
pub(super) fn any_waiting(waiting: Res<WaitingMeshes>) -> bool {
    !waiting.new.is_empty() || !waiting.meshes.is_empty()
}

/// Whether there is a `MeshColliders` below which an entity could be.
fn any_roots(world: &DeferredWorld) -> bool {
    let find = Components::component_id::<MeshColliders>;
    crate::components::any(world.components(), world.archetypes(), &[find])
}

fn note(world: &mut DeferredWorld, entity: Entity) {
    if let Some(mut waiting) = world.get_resource_mut::<WaitingMeshes>() {
        waiting.new.push(entity);
    }
}

/// Observer: an entity got [`MeshColliders`].
pub(super) fn root_added(added: On<Insert<MeshColliders>>, mut world: DeferredWorld) {
    note(&mut world, added.entity);
}

/// Observer: an entity got a mesh.
pub(super) fn mesh_added(added: On<Insert<Mesh3d>>, mut world: DeferredWorld) {
    if any_roots(&world) {
        note(&mut world, added.entity);
    }
}

/// Observer: an entity got a parent.
pub(super) fn child_added(added: On<Insert<ChildOf>>, mut world: DeferredWorld) {
    let may_have = world.get::<Mesh3d>(added.entity).is_some()
        || world.get::<Children>(added.entity).is_some();
    if may_have && any_roots(&world) {
        note(&mut world, added.entity);
    }
}
