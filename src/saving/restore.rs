//! Loading: part of the stage *prepare*. The contacts of a scene wait in [`Restored`] until the stage *broadphase* has made their pairs.

use crate::body::{BodyTable, SpawnOrder, mark_if_part};
use crate::joint_types::JointForces;
use crate::restored::{Restored, Saved};
use crate::solver::sort;
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::prelude::*;
use bevy_ecs::world::DeferredWorld;

/// Run condition: a scene was loaded or saved since the last step.
pub fn any_saved(saved: Query<(), (With<Saved>, Allow<Disabled>)>) -> bool {
    !saved.is_empty()
}

/// Takes up the [`Saved`] of all entities.
pub fn restore(world: &mut World, saved: &mut QueryState<(Entity, &Saved), Allow<Disabled>>) {
    let mut loaded: Vec<(u64, Entity)> = saved
        .iter(world)
        .map(|(entity, saved)| (saved.spawn_order, entity))
        .collect();
    sort::by_key(&mut loaded, |&(order, entity)| (order, entity.index_u32()));
    restore_order(world, &loaded);
    let mut restored = world.remove_resource::<Restored>().unwrap_or_default();
    for (_, entity) in loaded {
        // Whoever heard of the one before may have despawned it.
        let saved = world.get_entity_mut(entity);
        let Some(saved) = saved.ok().and_then(|mut entity| entity.take::<Saved>()) else {
            continue;
        };
        restored.accounts.insert(entity, saved.account);
        for contact in saved.contacts {
            let bodies = [contact.other, entity];
            restored.contacts.insert(bodies, (saved.step, contact));
        }
        if !saved.inside.is_empty() {
            restored.inside.insert(entity, saved.inside);
        }
        if let Some(saved) = saved.joint
            && let Some(mut forces) = world.get_mut::<JointForces>(entity)
        {
            forces.set_if_neq(saved);
        }
    }
    world.insert_resource(restored);
}

/// Exchanges the numbers of loaded entities, so that these are in the order in which they were saved. The numbers stay unique.
fn restore_order(world: &mut World, loaded: &[(u64, Entity)]) {
    let orders = loaded.iter().filter_map(|&(_, entity)| {
        let order = world.get::<SpawnOrder>(entity)?;
        Some((entity, *order))
    });
    let (entities, mut orders): (Vec<Entity>, Vec<SpawnOrder>) = orders.unzip();
    // They were loaded before the plugins were added.
    for order in &mut orders {
        if *order == SpawnOrder::NONE {
            *order = world.resource_mut::<BodyTable>().next_spawn_order();
        }
    }
    orders.sort_unstable();
    for (entity, order) in entities.into_iter().zip(orders) {
        if world
            .get::<SpawnOrder>(entity)
            .is_some_and(|known| *known != order)
        {
            world.entity_mut(entity).insert(order);
            if world.get_entity(entity).is_ok() {
                mark_if_part(&mut DeferredWorld::from(&mut *world), entity);
            }
        }
    }
}
