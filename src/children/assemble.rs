//! Part of the stage *prepare* and of a refresh: makes the shapes of bodies whose parts have changed.

use super::carry::carry;
use super::implicit::{make_body, take_body};
use crate::body::collider::{Collider, CollisionLayers, Friction, Restitution, RollingFriction};
use crate::body::parts::{
    ColliderOf, CompoundCollider, ImplicitBody, Part, Unassembled, body_of, gather, is_real_body,
    is_separate, scale_of,
};
use crate::body::{Density, Mass, RigidBody, WrittenTransforms, weigh_body};
use crate::components::{FindId, holders_in, remove};
use crate::diagnosis::{BodyProblem, FoundProblems, PartProblem, ReportedProblems};
use bevy_ecs::component::Components;
use bevy_ecs::entity::EntityHashSet;
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::hierarchy::{ChildOf, Children};
use bevy_ecs::prelude::*;
use bevy_ecs::world::DeferredWorld;
use bevy_transform::components::Transform;
use glam::Vec3;

/// Filter for parts that were written. Values that are the same as before change nothing.
type Written = (
    Or<(With<ColliderOf>, With<ImplicitBody>)>,
    Or<(
        Changed<Collider>,
        Changed<Transform>,
        Changed<Density>,
        Changed<Mass>,
        Changed<Friction>,
        Changed<Restitution>,
        Changed<RollingFriction>,
        Changed<CollisionLayers>,
    )>,
);

/// Filter for bodies whose compound depends on components that were written.
type Redefined = (
    With<CompoundCollider>,
    Or<(Changed<Collider>, Changed<RigidBody>)>,
);

/// Entities that are no bodies and may have bodies or colliders below them.
type MovedNodes = (With<Children>, Without<RigidBody>, Changed<Transform>);

/// The searches for entities that may have changed.
#[derive(Debug, FromWorld)]
pub struct Searches {
    written: QueryState<Entity, Written>,
    redefined: QueryState<Entity, Redefined>,
    nodes: QueryState<Entity, MovedNodes>,
}

/// The components that mark a part.
const PART_MARKERS: &[FindId] = &[Components::component_id::<ColliderOf>];

/// Finds the bodies whose parts or scale have changed, and makes their [`CompoundCollider`] anew. Makes colliders without a body static.
pub fn assemble(world: &mut World, mut searches: Local<Option<Searches>>) {
    let searches = searches.get_or_insert_with(|| Searches::from_world(world));
    carry(world);
    let mut roots = world.resource_mut::<Unassembled>().take();
    roots.extend(searches.written.iter(world));
    let mut bodies: Vec<Entity> = searches.redefined.iter(world).collect();
    bodies.append(&mut world.resource_mut::<WrittenTransforms>().rescaled);
    let mut nodes = searches.nodes.iter(world).peekable();
    if nodes.peek().is_some() {
        bodies.extend(nodes.filter_map(|node| body_of(world, node)));
        let all = [
            Components::component_id::<ChildOf>,
            Components::component_id::<RigidBody>,
        ];
        let carried = holders_in(world, &all).into_iter().filter(|&body| {
            let known = world.get::<CompoundCollider>(body);
            let has_shape = known.is_some() || world.get::<Collider>(body).is_some();
            has_shape && scale_of(world, body) != known_scale(known)
        });
        bodies.extend(carried);
    }
    if roots.is_empty() && bodies.is_empty() {
        return;
    }
    let mut lone = Vec::new();
    let mut seen = EntityHashSet::default();
    for root in roots {
        visit(world, root, &mut seen, (&mut bodies, &mut lone));
    }
    let mut seen = EntityHashSet::default();
    for collider in lone {
        if seen.insert(collider) {
            make_body(world, collider, RigidBody::Static);
            remove(world, collider, PART_MARKERS);
            bodies.push(collider);
        }
    }
    let mut seen = EntityHashSet::default();
    for body in bodies {
        if seen.insert(body) {
            rebuild(world, body);
        }
    }
    // The hooks have noted what was changed here.
    world.resource_mut::<Unassembled>().take();
}

/// The scale with which a shape was made.
fn known_scale(known: Option<&CompoundCollider>) -> Vec3 {
    known.map_or(Vec3::ONE, CompoundCollider::scale)
}

/// Finds the bodies that the colliders at and below an entity belonged to and belong to, and those that belong to none. Entities that
/// were visited already are left out: a body is marked once for each of its parts.
fn visit(
    world: &World,
    root: Entity,
    seen: &mut EntityHashSet,
    (bodies, lone): (&mut Vec<Entity>, &mut Vec<Entity>),
) {
    if !world.entities().contains(root) {
        return;
    }
    bodies.extend(body_of(world, root));
    let mut stack = vec![root];
    while let Some(at) = stack.pop() {
        let Ok(entity) = world.get_entity(at) else {
            continue;
        };
        if !seen.insert(at) {
            continue;
        }
        bodies.extend(entity.get::<ColliderOf>().map(|part| part.body));
        if is_real_body(entity) {
            bodies.push(at);
        } else if entity.contains::<Collider>() && !entity.contains::<Disabled>() {
            match body_of(world, at) {
                None => lone.push(at),
                // It may be a body of its own, with a scale.
                Some(_) if entity.contains::<ImplicitBody>() => bodies.push(at),
                Some(_) => (),
            }
        } else if entity.contains::<ImplicitBody>() || entity.contains::<CompoundCollider>() {
            bodies.push(at);
        }
        if let Some(children) = entity.get::<Children>() {
            stack.extend(children.iter().rev());
        }
    }
}

/// Makes the shape of a body, if it is not what it was.
fn rebuild(world: &mut World, body: Entity) {
    let Ok(known) = world.get_entity(body) else {
        return;
    };
    let compound = known.get::<CompoundCollider>();
    if compound.is_some_and(|compound| compound.is_copy) {
        return;
    }
    let has_compound = compound.is_some();
    if known.contains::<ImplicitBody>() && !known.contains::<Collider>() {
        take_body(world, body);
    }
    let kind = world.get::<RigidBody>(body).copied();
    let parts = kind.and_then(|_| gather(world, body));
    let (Some(kind), Some(parts)) = (kind, parts) else {
        if has_compound {
            disown(world, body, &[]);
            remove(world, body, &[Components::component_id::<CompoundCollider>]);
        }
        // A part that was here only between two steps has been weighed with it.
        weigh_body(&mut DeferredWorld::from(world), body);
        return;
    };
    let compound = world.get::<CompoundCollider>(body);
    if compound.is_some_and(|known| known.kind == kind && *known.sources == *parts) {
        own(world, body, kind, &parts);
        weigh_body(&mut DeferredWorld::from(world), body);
        return;
    }
    disown(world, body, &parts);
    own(world, body, kind, &parts);
    let colliders: Vec<Entity> = parts.iter().map(|part| part.entity).collect();
    let (mut compound, problems) = CompoundCollider::build(body, kind, parts);
    compound.scale = scale_of(world, body);
    report(world, body, &colliders, problems);
    if let Ok(mut body) = world.get_entity_mut(body) {
        body.insert(compound);
    }
}

/// Takes the mark of a part from the colliders that are no parts of the body any more.
fn disown(world: &mut World, body: Entity, parts: &[Part]) {
    let Some(known) = world.get::<CompoundCollider>(body) else {
        return;
    };
    let kept: EntityHashSet = parts.iter().map(|part| part.entity).collect();
    let gone: Vec<Entity> = known.parts().filter(|part| !kept.contains(part)).collect();
    for part in gone {
        if world.get::<ColliderOf>(part) == Some(&ColliderOf { body }) {
            remove(world, part, PART_MARKERS);
        }
    }
}

/// Marks the parts of a body, and makes bodies of those that cannot be in its compound.
fn own(world: &mut World, body: Entity, kind: RigidBody, parts: &[Part]) {
    let first = parts.first().filter(|part| part.entity == body);
    for part in parts.iter().filter(|part| part.entity != body) {
        if is_separate(part, body, first) && kind != RigidBody::Dynamic {
            make_body(world, part.entity, kind);
            remove(world, part.entity, PART_MARKERS);
            if world.get::<Transform>(part.entity).is_some() {
                rebuild(world, part.entity);
            }
            continue;
        }
        take_body(world, part.entity);
        if world.get::<ColliderOf>(part.entity) != Some(&ColliderOf { body })
            && let Ok(mut part) = world.get_entity_mut(part.entity)
        {
            part.insert(ColliderOf { body });
        }
    }
}

/// Reports the parts that are left out, each once.
fn report(
    world: &mut World,
    body: Entity,
    colliders: &[Entity],
    problems: Vec<(Entity, PartProblem)>,
) {
    let mut told = std::mem::take(&mut world.resource_mut::<ReportedProblems>().strays);
    told.retain(|part| world.entities().contains(*part));
    let bad: EntityHashSet = problems.iter().map(|&(part, _)| part).collect();
    for part in colliders {
        if !bad.contains(part) {
            told.remove(part);
        }
    }
    let new = problems.into_iter().filter(|(part, _)| told.insert(*part));
    let new: Vec<_> = new
        .map(|(part, problem)| (part, BodyProblem::PartLeftOut { body, problem }))
        .collect();
    world.resource_mut::<ReportedProblems>().strays = told;
    world.resource_mut::<FoundProblems>().0.extend(new);
}
