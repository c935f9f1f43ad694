//! What recording and replay do with each component on the list of the [state](crate::state).

use crate::body::{Inactive, new_rows, newer_than};
use crate::contact::{
    ContactAnchors, ContactImpulses, ContactPair, ContactTargets, Manifold, NarrowphaseCache,
};
use crate::snapshot::SnapshotError;
use crate::snapshot::bytes::{read, write};
use crate::snapshot::renaming::Renaming;
use crate::state::{self, Stored, Visitor};
use bevy_ecs::change_detection::Tick;
use bevy_ecs::component::{ComponentId, Mutable, StorageType};
use bevy_ecs::entity::EntityMapper;
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::prelude::*;
use std::any::TypeId;
use std::fmt::Debug;
use std::marker::PhantomData;

/// How a component is read from bytes and put into a world.
pub(super) trait How<T>: Debug + Send + Sync + 'static {
    fn write(value: &T, out: &mut Vec<u8>) -> Result<(), SnapshotError>;

    fn read(from: &mut &[u8]) -> Result<T, SnapshotError>;

    /// Gives an entity the value, which was written or only kept. It is marked as changed only if it differs.
    fn put(entity: &mut EntityWorldMut, value: T, is_written: bool);
}

/// A component that users may read.
#[derive(Debug)]
struct Marked;

/// A component that stages write without change detection.
#[derive(Debug)]
struct Silent;

/// A component that can only be replaced.
#[derive(Debug)]
struct Replaced;

/// A component without a value.
#[derive(Debug)]
struct Valueless;

/// Writes and reads values that can be stored.
macro_rules! stored {
    () => {
        fn write(value: &T, out: &mut Vec<u8>) -> Result<(), SnapshotError> {
            write(value, std::any::type_name::<T>(), out)
        }

        fn read(from: &mut &[u8]) -> Result<T, SnapshotError> {
            read(from)
        }
    };
}

impl<T: Component<Mutability = Mutable> + Stored + PartialEq> How<T> for Marked {
    stored!();

    fn put(entity: &mut EntityWorldMut, value: T, is_written: bool) {
        let Some(mut known) = entity.get_mut::<T>() else {
            entity.insert(value);
            return;
        };
        let differs = *known != value;
        // Equal values that were written may have other bits: 0 and -0. A value that was not written is not replaced by an equal one, because stages compare
        // compound shapes by identity: an equal shape would count as a new one.
        if differs || is_written {
            *known.bypass_change_detection() = value;
        }
        if differs {
            known.set_changed();
        }
    }
}

impl<T: Component<Mutability = Mutable> + Stored> How<T> for Silent {
    stored!();

    fn put(entity: &mut EntityWorldMut, value: T, _: bool) {
        match entity.get_mut::<T>() {
            Some(mut known) => *known.bypass_change_detection() = value,
            None => _ = entity.insert(value),
        }
    }
}

impl<T: Component + Stored + PartialEq> How<T> for Replaced {
    stored!();

    fn put(entity: &mut EntityWorldMut, value: T, _: bool) {
        if entity.get::<T>() != Some(&value) {
            entity.insert(value);
        }
    }
}

impl<T: Component + Default> How<T> for Valueless {
    fn write(_: &T, _: &mut Vec<u8>) -> Result<(), SnapshotError> {
        Ok(())
    }

    fn read(_: &mut &[u8]) -> Result<T, SnapshotError> {
        Ok(T::default())
    }

    fn put(entity: &mut EntityWorldMut, value: T, _: bool) {
        if !entity.contains::<T>() {
            entity.insert(value);
        }
    }
}

/// Some component on the list.
pub(super) trait AnyKind: Send + Sync {
    /// Whether it is a component of Bevy, which entities have that have nothing to do with drystone.
    fn is_shared(&self) -> bool;

    /// Whether it is a component of pairs, which only stages spawn.
    fn is_of_pair(&self) -> bool;

    /// Whether users remove it.
    fn is_removed_by_users(&self) -> bool;

    /// Makes the world know the component.
    fn register(&self, world: &mut World) -> ComponentId;

    /// Finds the entities for which the component was inserted or written after `since`. Tables in which no entity is drystone's are left out
    /// by `is_own`.
    fn find_written(
        &mut self,
        world: &World,
        since: Tick,
        is_own: &dyn Fn(Entity) -> bool,
        found: &mut Vec<Entity>,
    );

    /// Appends the value of an entity to bytes, and the entities that it refers to.
    fn write(
        &self,
        world: &World,
        entity: Entity,
        referred: &mut Vec<Entity>,
        out: &mut Vec<u8>,
    ) -> Result<(), SnapshotError>;

    /// Adds the entities that the values of all entities refer to.
    fn find_referred(&self, world: &World, referred: &mut Vec<Entity>);

    /// Takes as many values from the front of bytes.
    fn read(&self, count: usize, from: &mut &[u8]) -> Result<Box<dyn Values>, SnapshotError>;

    /// Removes the component from an entity.
    fn remove(&self, entity: &mut EntityWorldMut);
}

/// Values of one component that were read.
pub(super) trait Values: Debug + Send + Sync {
    /// Inserts the component into those of the entities that lack it.
    fn insert(&self, world: &mut World, entities: &[(Entity, bool)], to: &mut Renaming);

    /// Gives the entities their values. With each entity comes whether its value was written, or only kept.
    fn put(&self, world: &mut World, entities: &[(Entity, bool)], to: &mut Renaming);
}

/// A component on the list.
struct Kind<T: Component, H> {
    query: Option<QueryState<(Entity, Ref<'static, T>, Has<Disabled>)>>,
    how: PhantomData<H>,
}

impl<T: Component, H> Default for Kind<T, H> {
    fn default() -> Self {
        Self {
            query: None,
            how: PhantomData,
        }
    }
}

impl<T: Component + Clone + Debug, H: How<T>> AnyKind for Kind<T, H> {
    fn is_shared(&self) -> bool {
        state::is_of_bevy::<T>()
    }

    fn is_of_pair(&self) -> bool {
        let of_pairs = [
            TypeId::of::<ContactPair>(),
            TypeId::of::<Manifold>(),
            TypeId::of::<ContactTargets>(),
            TypeId::of::<ContactImpulses>(),
            TypeId::of::<ContactAnchors>(),
            TypeId::of::<NarrowphaseCache>(),
        ];
        of_pairs.contains(&TypeId::of::<T>())
    }

    fn is_removed_by_users(&self) -> bool {
        !self.is_of_pair() && TypeId::of::<T>() != TypeId::of::<Inactive>()
    }

    fn register(&self, world: &mut World) -> ComponentId {
        world.register_component::<T>()
    }

    fn find_written(
        &mut self,
        world: &World,
        since: Tick,
        is_own: &dyn Fn(Entity) -> bool,
        found: &mut Vec<Entity>,
    ) {
        let is_shared = self.is_shared();
        if self.query.is_none() {
            self.query = QueryState::try_new(world);
        }
        let Some(query) = &mut self.query else {
            return;
        };
        let now = world.read_change_tick();
        let is_new = newer_than(since, now);
        if matches!(T::STORAGE_TYPE, StorageType::SparseSet) {
            let written = query.iter(world);
            let written = written.filter(|(_, value, _)| is_new(value.last_changed()));
            found.extend(written.map(|(entity, ..)| entity));
            return;
        }
        let tables = query.contiguous_iter(world);
        for (entities, column, _) in tables.expect("it is kept in tables") {
            if is_shared && !entities.first().is_some_and(|&first| is_own(first)) {
                continue;
            }
            let written = new_rows(column.changed_ticks_slice(), is_new);
            found.extend(written.map(|row| entities[row]));
        }
    }

    fn write(
        &self,
        world: &World,
        entity: Entity,
        referred: &mut Vec<Entity>,
        out: &mut Vec<u8>,
    ) -> Result<(), SnapshotError> {
        // It was found a moment ago.
        let Some(value) = world.get::<T>(entity) else {
            return Err(SnapshotError::NotWritable(std::any::type_name::<T>()));
        };
        T::map_entities(&mut value.clone(), &mut Referred(referred));
        H::write(value, out)
    }

    fn find_referred(&self, world: &World, referred: &mut Vec<Entity>) {
        // Bevy's own components refer to entities above others, which every snapshot has.
        if self.is_shared() || self.is_of_pair() {
            return;
        }
        if let Some(mut query) = world.try_query::<(&T, Has<Disabled>)>() {
            for (value, _) in query.iter(world) {
                T::map_entities(&mut value.clone(), &mut Referred(referred));
            }
        }
    }

    fn read(&self, count: usize, from: &mut &[u8]) -> Result<Box<dyn Values>, SnapshotError> {
        let values = (0..count).map(|_| H::read(from));
        Ok(Box::new(Read::<T, H> {
            values: values.collect::<Result<_, _>>()?,
            how: PhantomData,
        }))
    }

    fn remove(&self, entity: &mut EntityWorldMut) {
        entity.remove::<T>();
    }
}

/// Collects the entities that a value refers to.
struct Referred<'a>(&'a mut Vec<Entity>);

impl EntityMapper for Referred<'_> {
    fn get_mapped(&mut self, source: Entity) -> Entity {
        self.0.push(source);
        source
    }

    fn set_mapped(&mut self, _: Entity, _: Entity) {}
}

/// Values of one component that were read.
#[derive(Debug)]
struct Read<T, H> {
    values: Vec<T>,
    how: PhantomData<H>,
}

impl<T: Component + Clone + Debug, H: How<T>> Values for Read<T, H> {
    fn insert(&self, world: &mut World, entities: &[(Entity, bool)], to: &mut Renaming) {
        let entities = entities.iter().map(|&(entity, _)| entity);
        to.insert_missing(world, entities.zip(&self.values));
    }

    fn put(&self, world: &mut World, entities: &[(Entity, bool)], to: &mut Renaming) {
        for (value, &(entity, is_written)) in self.values.iter().zip(entities) {
            if let Ok(mut entity) = world.get_entity_mut(entity) {
                let mut value = value.clone();
                to.apply(&mut value);
                H::put(&mut entity, value, is_written);
            }
        }
    }
}

/// All components on the list, in its order.
pub(super) fn all() -> Vec<Box<dyn AnyKind>> {
    let mut list = List(Vec::new());
    state::visit(&mut list);
    list.0
}

struct List(Vec<Box<dyn AnyKind>>);

impl List {
    fn push<T: Component + Clone + Debug, H: How<T>>(&mut self) {
        self.0.push(Box::new(Kind::<T, H>::default()));
    }
}

impl Visitor for List {
    fn component<T: Component<Mutability = Mutable> + Stored + PartialEq>(&mut self) {
        self.push::<T, Marked>();
    }

    fn internal<T: Component<Mutability = Mutable> + Stored>(&mut self) {
        self.push::<T, Silent>();
    }

    fn immutable<T: Component + Stored + PartialEq>(&mut self) {
        self.push::<T, Replaced>();
    }

    fn marker<T: Component<Mutability = Mutable> + Clone + Debug + Default>(&mut self) {
        self.push::<T, Valueless>();
    }

    fn resource<T: Resource + Component<Mutability = Mutable> + Stored>(&mut self) {}

    fn code<T: Resource + Component<Mutability = Mutable> + Clone + Debug>(&mut self) {}

    fn derived<T: Resource + Default>(&mut self) {}
}
