//! The system that makes colliders from meshes.

use super::error::{MeshColliderError, MeshProblem};
use super::resolve::{Decision, name_of, resolve};
use super::shapes::Shapes;
use super::{MeshCollidersReady, WaitingMeshes};
use crate::body::collider::{Collider, MeshShape};
use bevy_asset::{AssetServer, Assets, LoadState};
use bevy_ecs::entity::EntityHashSet;
use bevy_ecs::prelude::*;
use bevy_mesh::{Mesh, Mesh3d};
use std::mem;

/// Makes colliders from the meshes at and below each [`MeshColliders`](super::MeshColliders) of which none is waited for: those of a scene
/// come all at once. The plugin runs it in `PreUpdate`; an exclusive system may call it at any time.
pub fn make_mesh_colliders(world: &mut World) {
    let Some(mut waiting) = world.get_resource_mut::<WaitingMeshes>() else {
        return;
    };
    let mut waiting = mem::take(&mut *waiting);
    waiting.look(world);
    let mut answers = Vec::new();
    for entity in mem::take(&mut waiting.meshes) {
        if let Some(decision) = undecided(world, entity) {
            let answer = shape(world, entity, &decision, &mut waiting.shapes);
            answers.push((entity, decision, answer));
        }
    }
    let waits = answers
        .iter()
        .filter(|(_, _, answer)| matches!(answer, Answer::Wait));
    let held_up: EntityHashSet = waits.map(|(_, decision, _)| decision.root).collect();
    let mut ready: Vec<MeshCollidersReady> = Vec::new();
    for (entity, decision, answer) in answers {
        let root = decision.root;
        if held_up.contains(&root) {
            waiting.meshes.push(entity);
            continue;
        }
        let known = ready.iter().position(|of| of.root == root);
        let known = known.unwrap_or_else(|| {
            let colliders = Vec::new();
            ready.push(MeshCollidersReady { root, colliders });
            ready.len() - 1
        });
        match answer {
            Answer::Wait | Answer::Nothing => (),
            Answer::Error(problem) => report(world, entity, problem),
            Answer::Collider(collider) => {
                decision.extras.insert(world, entity, collider);
                ready[known].colliders.push(entity);
            }
        }
    }
    if waiting.meshes.is_empty() {
        waiting.shapes = Shapes::default();
    }
    // Observers of what was inserted may have added some.
    let mut added = mem::replace(&mut *world.resource_mut::<WaitingMeshes>(), waiting);
    world
        .resource_mut::<WaitingMeshes>()
        .new
        .append(&mut added.new);
    for ready in ready {
        if world.get_entity(ready.root).is_ok() {
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
