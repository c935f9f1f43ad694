//! New ids for the entities of a snapshot.

use bevy_ecs::component::Component;
use bevy_ecs::entity::{Entity, EntityHashMap, EntityMapper, SceneEntityMapper};
use bevy_ecs::world::World;

/// The entities that those of a snapshot have become.
pub(crate) enum Renaming<'a, 'm> {
    /// They are the same.
    Nothing,
    /// Some were despawned, and have been spawned anew.
    Some(&'a EntityHashMap<Entity>),
    /// All are new, because the world is another one. Entities that the snapshot does not hold become ones that do not exist.
    All(&'a mut SceneEntityMapper<'m>),
}

impl Renaming<'_, '_> {
    /// Renames the entities that a component or resource refers to.
    #[inline]
    pub fn apply<T: Component>(&mut self, value: &mut T) {
        if !self.is_nothing() {
            T::map_entities(value, self);
        }
    }

    /// Inserts values into those of the entities that lack the component.
    pub fn insert_missing<'v, T: Component + Clone>(
        &mut self,
        world: &mut World,
        values: impl Iterator<Item = (Entity, &'v T)>,
    ) {
        let missing = values.filter_map(|(entity, value)| {
            let lacks = world.get_entity(entity).is_ok_and(|it| !it.contains::<T>());
            lacks.then(|| {
                let mut value = value.clone();
                self.apply(&mut value);
                (entity, value)
            })
        });
        let missing: Vec<(Entity, T)> = missing.collect();
        if !missing.is_empty() {
            world.insert_batch(missing);
        }
    }

    #[inline]
    pub fn is_nothing(&self) -> bool {
        matches!(self, Self::Nothing)
    }
}

impl EntityMapper for Renaming<'_, '_> {
    fn get_mapped(&mut self, source: Entity) -> Entity {
        match self {
            Self::Nothing => source,
            Self::Some(map) => map.get(&source).copied().unwrap_or(source),
            Self::All(mapper) => mapper.get_mapped(source),
        }
    }

    fn set_mapped(&mut self, source: Entity, target: Entity) {
        if let Self::All(mapper) = self {
            mapper.set_mapped(source, target);
        }
    }
}
