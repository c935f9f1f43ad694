//! Components by their identifiers, for code that runs rarely. Bevy compiles some thousands of lines for each query, and some hundreds for each
//! type of a command. What takes an identifier is compiled once.

use bevy_ecs::archetype::Archetypes;
use bevy_ecs::component::{ComponentId, Components};
use bevy_ecs::prelude::*;
use bevy_ecs::system::ReadOnlySystem;

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
    let mut ids = all.iter().map(|find| find(components));
    let Some(first) = ids.next().flatten() else {
        return false;
    };
    let Some(holders) = archetypes.component_index().get(&first) else {
        return false;
    };
    // Most worlds have nobody with the first one.
    let mut holders = holders.keys().filter_map(|&id| archetypes.get(id));
    holders.any(|archetype| {
        let mut others = ids.clone();
        !archetype.is_empty() && others.all(|id| id.is_some_and(|id| archetype.contains(id)))
    })
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
