//! The system that makes colliders from meshes.

use super::error::{MeshColliderError, MeshProblem};
use super::resolve::{Decision, name_of, resolve};
use super::shapes::{Decompositions, Shapes};
use super::{MeshCollidersReady, WaitingMeshes};
use crate::body::collider::{Collider, MeshShape};
use bevy_asset::{AssetServer, Assets, LoadState};
use bevy_ecs::prelude::*;
use bevy_mesh::{Mesh, Mesh3d};
use std::collections::HashMap;
use std::mem;

/// Makes colliders from all meshes that are loaded and at or below a [`MeshColliders`](super::MeshColliders). The plugin runs it in
/// `PreUpdate`; an exclusive system may call it at any time.
pub fn make_mesh_colliders(world: &mut World) {
    let Some(mut waiting) = world.get_resource_mut::<WaitingMeshes>() else {
        return;
    };
    let mut waiting = mem::take(&mut *waiting);
    waiting.look(world);
    let mut shapes = Shapes {
        made: HashMap::new(),
        decompositions: &mut waiting.decompositions,
    };
    // The roots that are not ready.
    let mut held_up = Vec::new();
    for entity in mem::take(&mut waiting.meshes) {
        let Some(decision) = undecided(world, entity) else {
            continue;
        };
        let root = decision.root;
        let made = match shape(world, entity, &decision, &mut shapes) {
            Answer::Wait => {
                waiting.meshes.push(entity);
                held_up.push(root);
                continue;
            }
            Answer::Nothing => None,
            Answer::Error(problem) => {
                report(world, entity, problem);
                None
            }
            Answer::Collider(collider) => {
                decision.extras.insert(world, entity, collider);
                Some(entity)
            }
        };
        let known = waiting.unready.iter().position(|(of, _)| *of == root);
        let known = known.unwrap_or_else(|| {
            waiting.unready.push((root, Vec::new()));
            waiting.unready.len() - 1
        });
        waiting.unready[known].1.extend(made);
    }
    if waiting.meshes.is_empty() {
        // Nobody is left to take their results.
        waiting.decompositions = Decompositions::default();
    }
    let done = |(root, _): &mut (Entity, Vec<Entity>)| !held_up.contains(root);
    let ready: Vec<_> = waiting.unready.extract_if(.., done).collect();
    // Observers of what was inserted may have added some.
    let mut added = mem::replace(&mut *world.resource_mut::<WaitingMeshes>(), waiting);
    world
        .resource_mut::<WaitingMeshes>()
        .new
        .append(&mut added.new);
    for (root, colliders) in ready {
        if world.get_entity(root).is_ok() {
            let ready = MeshCollidersReady { root, colliders };
            world.write_message(ready.clone());
            world.trigger(ready);
        }
    }
}

/// What comes of a mesh.
enum Answer {
    /// It is not loaded, or its shape is being computed.
    Wait,
    Nothing,
    Error(MeshProblem),
    Collider(Collider),
}

/// What a mesh shall become, if it is still there and has no collider.
fn undecided(world: &World, entity: Entity) -> Option<Decision> {
    let known = world.get_entity(entity).ok()?;
    let is_open = known.contains::<Mesh3d>() && !known.contains::<Collider>();
    is_open.then(|| resolve(world, entity)).flatten()
}

fn shape(world: &World, entity: Entity, decision: &Decision, shapes: &mut Shapes) -> Answer {
    let shape: MeshShape = match &decision.shape {
        Ok(Some(shape)) => *shape,
        Ok(None) => return Answer::Nothing,
        Err(problem) => return Answer::Error(problem.clone()),
    };
    let Some(Mesh3d(handle)) = world.get::<Mesh3d>(entity) else {
        return Answer::Nothing;
    };
    let meshes = world.get_resource::<Assets<Mesh>>();
    let Some(mesh) = meshes.and_then(|meshes| meshes.get(handle)) else {
        let server = world.get_resource::<AssetServer>();
        let state = server.and_then(|server| server.get_load_state(handle.id()));
        return match state {
            Some(LoadState::Failed(why)) => Answer::Error(MeshProblem::NotLoaded(why.to_string())),
            _ => Answer::Wait,
        };
    };
    match shapes.get(handle.id(), mesh, shape) {
        None => Answer::Wait,
        Some(Ok(collider)) => Answer::Collider(collider),
        Some(Err(error)) => Answer::Error(error.into()),
    }
}

fn report(world: &mut World, entity: Entity, problem: MeshProblem) {
    let name = name_of(world, entity);
    let error = MeshColliderError {
        entity,
        name,
        problem,
    };
    tracing::error!("{error}");
    world.write_message(error);
}
