//! New ids for the entities of a snapshot.

use crate::stored::erased::SliceMut;
#[cfg(feature = "serde")]
use crate::stored::erased::{Kind, Slice, Values};
use bevy_ecs::entity::{Entity, EntityHashMap, EntityMapper, SceneEntityMapper};
#[cfg(feature = "serde")]
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
    /// Renames the entities that values refer to.
    pub fn apply(&mut self, values: &mut SliceMut) {
        if !self.is_nothing() {
            values.map(self);
        }
    }

    /// Inserts values into those of the entities that lack the component.
    #[cfg(feature = "serde")]
    pub fn insert_missing<'v>(
        &mut self,
        world: &mut World,
        kind: Kind,
        values: &mut dyn Iterator<Item = (Entity, Slice<'v>)>,
    ) {
        let id = kind.register(world);
        let lacks = |(entity, _): &(Entity, _)| {
            let entity = world.get_entity(*entity);
            entity.is_ok_and(|entity| !entity.contains_id(id))
        };
        // Hooks may insert the component, but what is inserted here counts.
        let missing: Vec<(Entity, Slice)> = values.filter(lacks).collect();
        let mut renamed = Values::new(kind);
        for (entity, value) in missing {
            if let Ok(mut entity) = world.get_entity_mut(entity) {
                renamed.push(value);
                self.apply(&mut renamed.as_mut());
                renamed.insert_into(&mut entity);
            }
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
