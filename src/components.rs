//! Components by their identifiers, and resources, for code that runs rarely. Bevy compiles some thousands of lines for each query, and
//! some hundreds for each type of a command. Code that takes an identifier is compiled once.

use crate::solver::sort;
use bevy_ecs::archetype::{Archetype, ArchetypeEntity, Archetypes};
use bevy_ecs::component::{ComponentId, Components};
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::prelude::*;
use bevy_ecs::system::ReadOnlySystem;
use smallvec::SmallVec;

/// Finds the identifier of a component: `Components::component_id::<T>`. There is none before the world knows the type.
pub(crate) type FindId = fn(&Components) -> Option<ComponentId>;

/// Run condition: whether some entity has a component, disabled entities included.
pub(crate) fn any_with(find: FindId) -> impl ReadOnlySystem<In = (), Out = bool> {
    IntoSystem::into_system(move |components: &Components, archetypes: &Archetypes| {
        any(components, archetypes, &[find])
    })
}

/// Whether some entity has all of these components, disabled entities included.
pub(crate) fn any(components: &Components, archetypes: &Archetypes, all: &[FindId]) -> bool {
    let mut found = false;
    if let Some(ids) = ids_of(components, all) {
        each_holder(archetypes, &ids, &mut |archetype| {
            found = !archetype.is_empty();
            !found
        });
    }
    found
}

/// The entities that have all of these components, disabled ones included.
pub(crate) fn holders(
    components: &Components,
    archetypes: &Archetypes,
    all: &[FindId],
) -> Vec<Entity> {
    ids_of(components, all).map_or_else(Vec::new, |ids| holders_of(archetypes, &ids))
}

/// The entities that have all of these components, disabled ones included.
pub(crate) fn holders_of(archetypes: &Archetypes, all: &[ComponentId]) -> Vec<Entity> {
    let mut holders = SmallVec::<[&Archetype; 16]>::new();
    each_holder(archetypes, all, &mut |archetype| {
        holders.push(archetype);
        true
    });
    // In the order in which a query has them.
    sort::by_key(&mut holders, |archetype| archetype.id().index());
    let mut found = Vec::new();
    for archetype in holders {
        found.extend(archetype.entities().iter().map(ArchetypeEntity::id));
    }
    found
}

/// The entities of a world that have all of these components, as a query would find them: without disabled ones.
pub(crate) fn holders_in(world: &World, all: &[FindId]) -> Vec<Entity> {
    let mut found = holders(world.components(), world.archetypes(), all);
    found.retain(|&entity| !world.entity(entity).contains::<Disabled>());
    found
}

/// Inserts components into an entity if it still exists: an observer of something else may have despawned it.
pub(crate) fn put(world: &mut World, entity: Entity, bundle: impl Bundle) {
    if let Ok(mut entity) = world.get_entity_mut(entity) {
        entity.insert(bundle);
    }
}

/// The identifiers of these components, if the world knows all of them.
fn ids_of(components: &Components, all: &[FindId]) -> Option<SmallVec<[ComponentId; 4]>> {
    let mut ids = SmallVec::new();
    for find in all {
        ids.push(find(components)?);
    }
    Some(ids)
}

/// Calls `visit` with each archetype that has all of these components, until it returns false. The order is not defined.
fn each_holder<'a>(
    archetypes: &'a Archetypes,
    ids: &[ComponentId],
    visit: &mut dyn FnMut(&'a Archetype) -> bool,
) {
    // Most worlds have no entity with the first one.
    let Some(holders) = archetypes.component_index().get(&ids[0]) else {
        return;
    };
    for &archetype in holders.keys() {
        if let Some(archetype) = archetypes.get(archetype)
            && ids.iter().all(|&id| archetype.contains(id))
            && !visit(archetype)
        {
            return;
        }
    }
}

/// Removes components of an entity, if it exists, as [`EntityWorldMut::remove`] does with a bundle.
pub(crate) fn remove(world: &mut World, entity: Entity, all: &[FindId]) {
    let components = world.components();
    let ids = all.iter().filter_map(|find| find(components));
    let ids: Vec<ComponentId> = ids.collect();
    if let Ok(mut entity) = world.get_entity_mut(entity) {
        entity.remove_by_ids(&ids);
    }
}

/// Has a component of an entity removed when commands are applied, if the entity exists by then.
pub(crate) fn remove_later(commands: &mut Commands, entity: Entity, find: FindId) {
    commands.queue(move |world: &mut World| remove(world, entity, &[find]));
}

/// Inserts a resource with its default, unless the world has it. Bevy's `init_resource` compiles to four times as much code for each type,
/// because it spawns and inserts the resource as a bundle.
pub(crate) fn init<R: Resource + FromWorld>(world: &mut World) {
    if !world.contains_resource::<R>() {
        let value = R::from_world(world);
        world.insert_resource(value);
    }
}
