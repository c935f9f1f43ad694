//! The parts of a body, as the hierarchy has them.

use super::{ImplicitBody, Sensor};
use crate::body::collider::{Collider, CollisionLayers, Friction, Restitution, RollingFriction};
use crate::body::{Density, Mass, RigidBody, SpawnOrder};
use crate::solver::sort;
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::hierarchy::{ChildOf, Children};
use bevy_ecs::lifecycle::HookContext;
use bevy_ecs::prelude::*;
use bevy_ecs::world::DeferredWorld;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::Reflect;
use bevy_transform::components::Transform;
use glam::{Affine3A, Vec3};

/// Marks a collider that is a part of a body above it in the hierarchy. This component is computed.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect), reflect(Component, Debug))]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[component(on_remove = left, clone_behavior = Ignore)]
pub struct ColliderOf {
    /// The body.
    #[entities]
    pub body: Entity,
}

/// Hook of [`ColliderOf`]: the body has lost a part.
fn left(mut world: DeferredWorld, context: HookContext) {
    if let Some(&ColliderOf { body }) = world.get::<ColliderOf>(context.entity) {
        super::mark(&mut world, body);
    }
}

/// A collider of a body, and the components that describe it.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Part {
    pub entity: Entity,
    pub spawn_order: SpawnOrder,
    /// From the frame of the collider to that of the body, which has no scale.
    pub map: Affine3A,
    pub collider: Collider,
    pub density: Option<Density>,
    pub mass: Option<Mass>,
    pub friction: Option<Friction>,
    pub restitution: Option<Restitution>,
    pub rolling: Option<RollingFriction>,
    pub layers: Option<CollisionLayers>,
    pub is_sensor: bool,
}

impl PartialEq for Part {
    fn eq(&self, other: &Self) -> bool {
        let properties = |part: &Self| {
            (
                (part.entity, part.map, part.density, part.mass),
                (part.friction, part.restitution, part.rolling),
                (part.layers, part.is_sensor),
            )
        };
        properties(self) == properties(other) && self.collider.is_same(&other.collider)
    }
}

impl Part {
    fn of(part: EntityRef, map: Affine3A, is_child: bool) -> Option<Self> {
        let collider = part.get::<Collider>()?.clone();
        // The components of the body itself apply to all of its parts.
        Some(Self {
            entity: part.id(),
            spawn_order: part.get().copied().unwrap_or_default(),
            map,
            collider,
            density: part.get().copied().filter(|_| is_child),
            mass: part.get().copied().filter(|_| is_child),
            friction: part.get().copied().filter(|_| is_child),
            restitution: part.get().copied().filter(|_| is_child),
            rolling: part.get().copied().filter(|_| is_child),
            layers: part.get().copied().filter(|_| is_child),
            is_sensor: part.contains::<Sensor>(),
        })
    }
}

/// Returns true for a body that a user has made, and that colliders below it are parts of.
pub(crate) fn is_real_body(entity: EntityRef) -> bool {
    entity.contains::<RigidBody>() && !entity.contains::<ImplicitBody>()
}

/// The nearest body at or above an entity.
pub(crate) fn body_of(world: &World, entity: Entity) -> Option<Entity> {
    let mut next = Some(entity);
    while let Some(at) = next {
        let entity = world.get_entity(at).ok()?;
        if is_real_body(entity) {
            return Some(at);
        }
        next = entity.get::<ChildOf>().map(ChildOf::parent);
    }
    None
}

/// The scale of an entity in the world: the product of the scales of its `Transform` and of those above it.
pub(crate) fn scale_of(world: &World, entity: Entity) -> Vec3 {
    let mut scale = Vec3::ONE;
    let mut next = Some(entity);
    while let Some(at) = next
        && let Ok(entity) = world.get_entity(at)
        && let Some(transform) = entity.get::<Transform>()
    {
        scale *= transform.scale;
        next = entity.get::<ChildOf>().map(ChildOf::parent);
    }
    scale
}

/// The colliders of a body: its own first, then its parts in the order in which they were spawned. `None` if its shape is simply its own
/// collider.
pub(crate) fn gather(world: &World, body: Entity) -> Option<Vec<Part>> {
    let root = world.get_entity(body).ok()?;
    let scale = scale_of(world, body);
    if scale == Vec3::ONE && !root.contains::<Children>() && !root.contains::<Sensor>() {
        return None;
    }
    let map = Affine3A::from_scale(scale);
    let mut parts: Vec<Part> = Part::of(root, map, false).into_iter().collect();
    let is_simple = scale == Vec3::ONE && parts.iter().all(|own| !own.is_sensor);
    if !root.contains::<ImplicitBody>() {
        gather_below(world, root, map, &mut parts);
    }
    let own = usize::from(root.contains::<Collider>());
    if (is_simple || own == 0) && parts.len() == own {
        return None;
    }
    sort::by_key(&mut parts[own..], |part| part.spawn_order);
    Some(parts)
}

fn gather_below(world: &World, root: EntityRef, map: Affine3A, parts: &mut Vec<Part>) {
    let below = |entity: EntityRef, map: Affine3A, stack: &mut Vec<(Entity, Affine3A)>| {
        if let Some(children) = entity.get::<Children>() {
            stack.extend(children.iter().rev().map(|child| (child, map)));
        }
    };
    let mut stack = Vec::new();
    below(root, map, &mut stack);
    while let Some((at, above)) = stack.pop() {
        let Ok(entity) = world.get_entity(at) else {
            continue;
        };
        if is_real_body(entity) {
            continue;
        }
        let local = entity.get::<Transform>();
        let map = above * local.map_or(Affine3A::IDENTITY, Transform::compute_affine);
        if !entity.contains::<Disabled>() {
            parts.extend(Part::of(entity, map, true));
        }
        below(entity, map, &mut stack);
    }
}

/// A body with so many entities below it is weighed only in a step.
const MAX_WEIGHED_AT_ONCE: usize = 32;

/// Returns true if there are not many entities below a body, whose parts can be weighed at once.
pub(crate) fn has_few(world: &World, body: Entity) -> bool {
    let mut count = 0;
    let mut stack = vec![body];
    while let Some(at) = stack.pop() {
        if let Some(children) = world.get::<Children>(at) {
            count += children.len();
            if count > MAX_WEIGHED_AT_ONCE {
                return false;
            }
            stack.extend(children.iter());
        }
    }
    true
}
