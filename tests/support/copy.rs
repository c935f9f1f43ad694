//! The state of a world, copied into another world: exactly what is on the list of [`drystone::state`].

use bevy_ecs::change_detection::{MAX_CHANGE_AGE, Tick};
use bevy_ecs::component::{ComponentId, Components, Mutable};
use bevy_ecs::entity::{EntityHashMap, SceneEntityMapper};
use bevy_ecs::prelude::*;
use drystone::state::{Role, Stored, Visitor, visit};
use std::fmt::Debug;

/// Replaces the state of a world by that of another one, which goes on there to the same bits. The two must have the same plugins.
///
/// Entities of the other world that have a component on the list get new entities here. Returned is which is which.
pub fn copy_state(from: &World, to: &mut World) -> EntityHashMap<Entity> {
    let old: Vec<Entity> = entities_with_state(to);
    for entity in old {
        to.despawn(entity);
    }
    let originals = entities_with_state(from);
    let pairs: Vec<_> = originals
        .into_iter()
        .map(|original| (original, to.spawn_empty().id()))
        .collect();
    let mut map: EntityHashMap<Entity> = pairs.iter().copied().collect();
    SceneEntityMapper::world_scope(&mut map, to, |to, mapper| {
        visit(&mut Copier {
            from,
            to,
            mapper,
            pairs,
        });
    });
    map
}

/// The entities that have a component on the list, in the order in which queries find those of one kind.
fn entities_with_state(world: &World) -> Vec<Entity> {
    let mut on_the_list = OnTheList {
        components: world.components(),
        ids: Vec::new(),
    };
    visit(&mut on_the_list);
    let ids = on_the_list.ids;
    let archetypes = world.archetypes().iter();
    let archetypes = archetypes.filter(|archetype| ids.iter().any(|&id| archetype.contains(id)));
    let entities = archetypes.flat_map(|archetype| archetype.entities());
    entities.map(|entity| entity.id()).collect()
}

/// Gathers the components on the list that a world knows.
struct OnTheList<'a> {
    components: &'a Components,
    ids: Vec<ComponentId>,
}

impl Visitor for OnTheList<'_> {
    fn any_component<T: Component + Clone + Debug>(&mut self) {
        self.ids.extend(self.components.component_id::<T>());
    }
}

struct Copier<'a, 'm> {
    from: &'a World,
    to: &'a mut World,
    mapper: &'a mut SceneEntityMapper<'m>,
    /// Originals and copies.
    pairs: Vec<(Entity, Entity)>,
}

impl Visitor for Copier<'_, '_> {
    fn any_component<T: Component + Clone + Debug>(&mut self) {
        for &(original, copy) in &self.pairs {
            if let Some(component) = self.from.get::<T>(original) {
                let mut component = component.clone();
                T::map_entities(&mut component, self.mapper);
                self.to.entity_mut(copy).insert(component);
            }
        }
    }

    /// It must not count as added by a user: stages would write it at once.
    fn output<T: Component<Mutability = Mutable> + Stored + PartialEq>(&mut self, _: Role) {
        self.any_component::<T>();
        let now = self.to.change_tick();
        for &(_, copy) in &self.pairs {
            if let Some(mut output) = self.to.get_mut::<T>(copy) {
                output.set_last_added(Tick::new(now.get().wrapping_sub(MAX_CHANGE_AGE)));
            }
        }
    }

    fn any_resource<T: Resource + Clone + Debug>(&mut self) {
        if let Some(resource) = self.from.get_resource::<T>() {
            let mut resource = resource.clone();
            T::map_entities(&mut resource, self.mapper);
            self.to.insert_resource(resource);
        }
    }

    fn derived<T: Resource + Default>(&mut self) {
        self.to.insert_resource(T::default());
    }
}
