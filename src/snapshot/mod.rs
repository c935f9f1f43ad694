//! Snapshots: the whole state of a world, kept in memory and restored to the same bits.
//!
//! A [`Snapshot`] holds everything that is on the list of the [state]: bodies, contacts, joints, hands, and what the simulation
//! remembers of the last step. A world that is restored continues as it did, bitwise: awake or asleep, on any number of threads. So a game
//! can go back in time, a client can predict and correct, and a test can repeat a step.
//!
//! ```
//! use bevy_app::App;
//! use bevy_transform::components::Transform;
//! use drystone::prelude::*;
//! use drystone::snapshot::Snapshot;
//!
//! let mut app = App::new();
//! app.add_plugins(DrystonePlugins::default());
//! let world = app.world_mut();
//! world.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
//! let at = Transform::from_xyz(0.0, 2.0, 0.0);
//! let ball = world.spawn((RigidBody::Dynamic, Collider::ball(0.5), at)).id();
//! drystone::step(world, 1.0 / 60.0).unwrap();
//!
//! let snapshot = Snapshot::take(world);
//! let mut steps = |world: &mut bevy_ecs::world::World| {
//!     for _ in 0..60 {
//!         drystone::step(world, 1.0 / 60.0).unwrap();
//!     }
//!     *world.get::<Transform>(ball).unwrap()
//! };
//! let first = steps(world);
//! snapshot.restore(world).unwrap();
//! assert_eq!(steps(world), first);
//! ```
//!
//! # What is restored
//!
//! - *Entities* with a component of drystone: bodies, colliders, joints, hands, sensors, contacts. Of these, all components on the list,
//!   and no other: components of your game stay as they are. Entities above them in the hierarchy keep their place too.
//! - Entities that were spawned since are despawned. Entities that were despawned since are spawned anew, with new ids and only the
//!   components on the list; every reference among them follows. [`Snapshot::restore`] returns the new ids, so that you can give them their
//!   meshes, and update references of your own.
//! - In another world every entity is a new one, and those of drystone that were there are despawned. That world needs the same plugins.
//! - *Settings*, the clock of the step, and the hook of contacts.
//! - Not messages: those that were sent and not read yet stay.
//!
//! # Speed
//!
//! Values are copied a table of the ECS at a time. In a large world a snapshot is taken on all [threads](crate::settings::PhysicsThreads).
//! [`Snapshot::take_into`] uses the memory of an older snapshot again, which saves most of the allocations. A component is marked as
//! changed only if its value differs, or if you had written it after the last step. The first step after a restore derives the problems of
//! islands anew; the result is bitwise equal.
//!
//! # Bytes
//!
//! With the feature `serde`, `Snapshot::to_bytes` writes a snapshot to bytes, and `to_bytes_after` what differs from an earlier one. That
//! is little if little has moved.

#[cfg(feature = "serde")]
pub(crate) mod bytes;
mod column;
mod difference;
mod error;
pub(crate) mod layout;
pub(crate) mod renaming;
mod resource;
mod structure;
mod target;
mod text;

pub use difference::Difference;
pub use error::SnapshotError;

use crate::body::BodyTable;
use crate::settings::{Columns, PhysicsThreads};
use crate::solver::join::join;
use crate::state;
use bevy_ecs::entity::{Entity, EntityHashMap, SceneEntityMapper};
use bevy_ecs::prelude::*;
use bevy_ecs::world::WorldId;
#[cfg(feature = "serde")]
pub(crate) use column::replace_if_other;
use column::{Column, On};
use layout::{KnownKinds, Layout, own_tables};
use renaming::Renaming;
use resource::Kept;
use std::fmt;
use structure::Differences;
use target::Target;

/// Where a snapshot is from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Origin {
    /// It is empty.
    Nothing,
    World(WorldId),
    /// Its entities are those of no world.
    #[cfg(feature = "serde")]
    Bytes,
}

/// The state of a world. See the [module](self).
#[derive(Clone)]
pub struct Snapshot {
    origin: Origin,
    layout: Layout,
    /// By kind.
    columns: Vec<Column>,
    resources: Vec<Kept>,
}

/// An empty snapshot, which cannot be restored. It is there for [`Snapshot::take_into`].
impl Default for Snapshot {
    fn default() -> Self {
        let list = state::list();
        Self {
            origin: Origin::Nothing,
            layout: Layout::default(),
            columns: list.components.iter().copied().map(Column::new).collect(),
            resources: list.resources.iter().copied().map(Kept::new).collect(),
        }
    }
}

impl fmt::Debug for Snapshot {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Snapshot")
            .field("origin", &self.origin)
            .field("entities", &self.layout.entities.len())
            .finish_non_exhaustive()
    }
}

impl Snapshot {
    /// Takes the state of a world between two steps.
    pub fn take(world: &World) -> Self {
        let mut snapshot = Self::default();
        snapshot.take_into(world);
        snapshot
    }

    /// Replaces this snapshot by the state of a world, and uses its memory again.
    pub fn take_into(&mut self, world: &World) {
        self.take_with(world, &[]);
    }

    /// Takes the state of a world, and other entities to which components refer.
    pub(crate) fn take_with(&mut self, world: &World, others: &[Entity]) {
        let known = KnownKinds::of_world(world, &self.columns);
        let table = world.get_resource::<BodyTable>();
        self.origin = table.map_or(Origin::Nothing, |_| Origin::World(world.id()));
        self.layout.find(world, &known);
        self.layout.add(world, &known, others);
        let since = table.and_then(BodyTable::visited_at);
        let Self {
            layout,
            columns,
            resources,
            ..
        } = self;
        let take = |kind: usize, column: &mut Column| {
            column.take(kind, world, layout, since);
        };
        let threads = world.get_resource::<PhysicsThreads>();
        let items = layout.entities.len();
        match threads.filter(|threads| threads.runs_in_parallel(items)) {
            Some(threads) => threads.run(items, || {
                let kinds = 0..columns.len();
                join(
                    || (kinds, &mut **columns).share(1, &|(kind, column)| take(kind, column)),
                    || (&mut **resources,).share(1, &|(kept,)| kept.take(world)),
                );
            }),
            None => {
                let columns = columns.iter_mut().enumerate();
                columns.for_each(|(kind, column)| take(kind, column));
                resources.iter_mut().for_each(|kept| kept.take(world));
            }
        }
    }

    /// Makes the state of a world that of this snapshot. Call it between two steps.
    ///
    /// Returns the entities of the snapshot that have other ids in the world, with the new ones: those that were despawned since the
    /// snapshot was taken, or all of them if it was taken of another world. Then it has also those that the snapshot refers to although
    /// they were despawned before; their new ids are of no entity either.
    ///
    /// # Errors
    /// If the snapshot is empty, or the world lacks a plugin. Nothing has changed then.
    pub fn restore(&self, world: &mut World) -> Result<EntityHashMap<Entity>, SnapshotError> {
        if self.origin == Origin::Nothing {
            return Err(SnapshotError::Empty);
        }
        let missing = self.resources.iter().find(|kept| kept.is_missing(world));
        if let Some(missing) = missing {
            return Err(SnapshotError::MissingPlugin(missing.kind.name()));
        }
        world.flush();
        match self.origin == Origin::World(world.id()) {
            true => Ok(self.restore_here(world)),
            false => Ok(self.restore_elsewhere(world)),
        }
    }

    /// The entities that the snapshot holds, in no particular order.
    pub fn entities(&self) -> &[Entity] {
        &self.layout.entities
    }

    fn restore_here(&self, world: &mut World) -> EntityHashMap<Entity> {
        let layout = &self.layout;
        let mut entities = layout.entities.clone();
        let on = On {
            layout,
            entities: &layout.entities,
        };
        let all = Differences::find(world, &KnownKinds::of_world(world, &self.columns), on);
        let (is_same, gone) = (all.is_empty(), all.gone);
        let new = world.spawn_batch(gone.iter().map(|_| ()));
        let new: Vec<Entity> = new.collect();
        let mut map = EntityHashMap::default();
        for (row, new) in gone.into_iter().zip(new) {
            map.insert(entities[row], new);
            entities[row] = new;
        }
        let mut to = match map.is_empty() {
            true => Renaming::Nothing,
            false => Renaming::Some(&map),
        };
        self.write(world, &entities, &mut to, is_same);
        map
    }

    fn restore_elsewhere(&self, world: &mut World) -> EntityHashMap<Entity> {
        let known = KnownKinds::of_world(world, &self.columns);
        let old = own_tables(world, &known);
        let old: Vec<Entity> = old
            .flat_map(|(_, table, _)| table.entities())
            .copied()
            .collect();
        for entity in old {
            // It may have been a child of the last one.
            world.try_despawn(entity).ok();
        }
        let originals = &self.layout.entities;
        let entities = world.spawn_batch(originals.iter().map(|_| ()));
        let entities: Vec<Entity> = entities.collect();
        let pairs = originals.iter().copied().zip(entities.iter().copied());
        let mut map: EntityHashMap<Entity> = pairs.collect();
        SceneEntityMapper::world_scope(&mut map, world, |world, mapper| {
            self.write(world, &entities, &mut Renaming::All(mapper), false);
        });
        map
    }

    /// Makes the state of a world that of the snapshot. `entities` are those of the world by row; all of them exist. `is_same` says that
    /// they have the components of the snapshot, and that there are no others.
    fn write(&self, world: &mut World, entities: &[Entity], to: &mut Renaming, is_same: bool) {
        let layout = &self.layout;
        let on = On { layout, entities };
        structure::restore(world, &self.columns, on, to, is_same);
        // Components that are written from here on count as changed since the last step.
        let now = world.increment_change_tick();
        let known = KnownKinds::of_world(world, &self.columns);
        let target = Target::find(layout, entities, world, &known);
        for (kind, column) in self.columns.iter().enumerate() {
            column.write(kind, world, &target, to);
        }
        for kept in &self.resources {
            kept.write(world, to);
        }
        world.resource_mut::<BodyTable>().set_visited_at(now);
        state::list().reset_derived(world);
    }
}
