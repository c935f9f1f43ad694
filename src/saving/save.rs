//! Saving.

use crate::body::{BodyIndex, BodyTable, SensorOverlaps, SpawnOrder};
use crate::components::holders_in;
use crate::graph::Islands;
use crate::joint_types::JointForces;
use crate::pair::{ContactPair, clone_pair};
use crate::restored::{Saved, SavedContact};
use crate::settings::StepTime;
use crate::solver::sort;
use crate::state::{self, Role};
use bevy_ecs::component::{ComponentCloneBehavior, Components};
use bevy_ecs::entity::{EntityHashMap, EntityHashSet};
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::hierarchy::ChildOf;
use bevy_ecs::prelude::*;
use std::any::TypeId;

type Numbered = (
    Entity,
    &'static SpawnOrder,
    Option<&'static JointForces>,
    Option<&'static SensorOverlaps>,
    Option<&'static BodyIndex>,
);

/// Gives all bodies, colliders and joints the component [`Saved`]. Call it before you extract a scene, and extract the scene before the
/// next step.
///
/// Returns the entities that belong to the scene: bodies, colliders, joints, and the entities above them in the hierarchy. Entities with
/// none of these are for you to add.
pub fn prepare(world: &mut World) -> Vec<Entity> {
    let mut contacts: EntityHashMap<Vec<(SpawnOrder, SavedContact)>> = EntityHashMap::default();
    for pair in holders_in(world, &[Components::component_id::<ContactPair>]) {
        let contact = clone_pair(world.entity(pair));
        let contact =
            contact.filter(|(pair, parts)| pair.announced() || !parts.0.points.is_empty());
        if let Some((pair, parts)) = contact {
            let of_b = contacts.entry(pair.bodies[1]).or_default();
            of_b.push((pair.spawn_orders[0], SavedContact::new(&pair, parts)));
        }
    }
    let step = world.get_resource().map_or(0.0, StepTime::whole);
    let mut numbered = world.query_filtered::<Numbered, Allow<Disabled>>();
    let bodies = world
        .get_resource::<BodyTable>()
        .zip(world.get_resource::<Islands>());
    let account = |entity: Entity, index: BodyIndex| {
        let (table, islands) = bodies?;
        let account = islands.account(index.0)?;
        table.holds(entity, index).then_some(account)
    };
    let saved = numbered
        .iter(world)
        .map(|(entity, order, forces, inside, index)| {
            let mut contacts = contacts.remove(&entity).unwrap_or_default();
            sort::by_key(&mut contacts, |&(order, _)| order);
            let saved = Saved {
                spawn_order: order.0,
                contacts: contacts.into_iter().map(|(_, contact)| contact).collect(),
                step,
                joint: forces.copied(),
                inside: inside.map_or_else(Vec::new, |inside| inside.iter().collect()),
                account: index.and_then(|&index| account(entity, index)),
            };
            (entity, saved)
        });
    let saved: Vec<(Entity, Saved)> = saved.collect();
    let mut entities: Vec<Entity> = Vec::with_capacity(saved.len());
    let mut seen = EntityHashSet::default();
    for &(entity, _) in &saved {
        let mut next = Some(entity);
        while let Some(at) = next.filter(|&at| seen.insert(at)) {
            entities.push(at);
            next = world.get::<ChildOf>(at).map(ChildOf::parent);
        }
    }
    _ = world.try_insert_batch(saved);
    entities
}

/// The types of components that are computed, and that belong to one world. Loading a scene skips them, so a scene need not hold them: it
/// is half as long without.
pub fn computed(world: &World) -> impl Iterator<Item = TypeId> {
    let components = world.components().iter_registered();
    let computed = components.filter(|(_, component)| {
        matches!(component.clone_behavior(), ComponentCloneBehavior::Ignore)
    });
    computed.filter_map(|(_, component)| component.type_id())
}

/// The types of the resources that a scene may hold: the settings, and the lengths of the last steps.
pub fn settings() -> impl Iterator<Item = TypeId> {
    let resources = state::list().resources.iter();
    let saved = resources.filter(|kind| matches!(kind.role, Role::Setting | Role::Time));
    saved.map(|kind| kind.type_id())
}
