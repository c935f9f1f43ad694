//! Finds out what a mesh shall become: the shape by name, by extras or by default, and the body and surface that extras name.

use super::MeshColliders;
use super::error::MeshProblem;
use super::extras::Found;
use crate::body::collider::MeshShape;
use bevy_ecs::hierarchy::ChildOf;
use bevy_ecs::prelude::*;

/// What a mesh shall become.
pub(super) struct Decision {
    /// The entity with [`MeshColliders`].
    pub(super) root: Entity,
    /// `None`: no collider.
    pub(super) shape: Result<Option<MeshShape>, MeshProblem>,
    /// What glTF extras say beside the shape.
    pub(super) extras: Found,
}

/// Decides about a mesh. `None` if it is not at or below an entity with [`MeshColliders`].
pub(super) fn resolve(world: &World, entity: Entity) -> Option<Decision> {
    let mut chain = vec![entity];
    let (root, rules) = loop {
        let at = *chain.last()?;
        if let Some(rules) = world.get::<MeshColliders>(at) {
            break (at, rules);
        }
        chain.push(world.get::<ChildOf>(at)?.parent());
    };
    let (mut shape, mut problem) = (None, None);
    let mut extras = Found::default();
    for &at in &chain {
        if shape.is_none()
            && let Some(name) = world.get::<Name>(at)
        {
            shape = rules.by_name.get(name.as_str()).copied();
        }
        match extras.add(rules, world, at) {
            Ok(found) => shape = shape.or(found),
            Err(why) => problem = problem.or(Some(why)),
        }
    }
    Some(Decision {
        root,
        shape: match problem {
            Some(problem) => Err(problem),
            None => Ok(shape.unwrap_or(rules.shape)),
        },
        extras,
    })
}

/// The name of an entity, or of the nearest above it that has one.
pub(super) fn name_of(world: &World, mut entity: Entity) -> Option<String> {
    loop {
        if let Some(name) = world.get::<Name>(entity) {
            return Some(name.as_str().to_owned());
        }
        entity = world.get::<ChildOf>(entity)?.parent();
    }
}
