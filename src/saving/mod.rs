//! Saving and loading: bodies, joints and what they bear, in Bevy's scene format or any other that works with reflection or serde.
//!
//! All components that users write are registered for reflection, so a scene holds them as it holds those of a game. Contacts are entities of
//! their own that belong to one world. [`prepare`] puts what a structure needs to stand as it stood into the component [`Saved`] of its bodies
//! and joints: the contacts with their forces and anchors, and the order of spawning. The first step after loading takes it from there. Bodies
//! that slept are asleep at once, nothing settles anew, loads and supports are those of before, and no [`ContactStarted`](crate::contact::ContactStarted)
//! or [`SensorEntered`](crate::sensor::SensorEntered) is sent again.
//!
//! Enable the feature `serde`, because shapes are written by it.
//!
//! ```
//! # #[cfg(feature = "serde")] {
//! use bevy_app::App;
//! use bevy_ecs::entity::EntityHashMap;
//! use bevy_ecs::prelude::*;
//! use bevy_world_serialization::serde::WorldDeserializer;
//! use bevy_world_serialization::{DynamicWorldBuilder, WorldFilter};
//! use drystone::masonry::{Bond, Wall};
//! use drystone::prelude::*;
//! use drystone::saving;
//! use serde::de::DeserializeSeed;
//!
//! # struct NoAssets;
//! # impl bevy_asset::LoadFromPath for NoAssets {
//! #     fn load_from_path_erased(&mut self, _: std::any::TypeId, _: bevy_asset::AssetPath<'static>) -> bevy_asset::UntypedHandle {
//! #         unreachable!("the scene has no assets")
//! #     }
//! # }
//! # fn new_app() -> App {
//! #     let mut app = App::new();
//! #     app.add_plugins(DrystonePlugins::default());
//! #     app
//! # }
//! let mut app = new_app(); // with `DrystonePlugins`
//! let world = app.world_mut();
//! world.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
//! for brick in Wall::new(Bond::Running).blocks().unwrap() {
//!     world.spawn(brick.bundle());
//! }
//! for _ in 0..120 {
//!     drystone::step(world, 1.0 / 60.0).unwrap();
//! }
//!
//! // Save.
//! let entities = saving::prepare(world); // and your own
//! let registry = world.resource::<AppTypeRegistry>().clone();
//! let text = DynamicWorldBuilder::from_world(world, &registry.read())
//!     .with_component_filter(WorldFilter::Denylist(saving::computed(world).collect()))
//!     .with_resource_filter(WorldFilter::Allowlist(saving::settings().collect())) // and your own
//!     .extract_entities(entities.into_iter())
//!     .extract_resources()
//!     .build()
//!     .serialize(&registry.read())
//!     .unwrap();
//!
//! // Load. In a game, the asset server does this with a file.
//! let mut app = new_app();
//! let world = app.world_mut();
//! let registry = world.resource::<AppTypeRegistry>().clone();
//! let scene = WorldDeserializer {
//!     type_registry: &registry.read(),
//!     load_from_path: &mut NoAssets,
//! };
//! let scene = scene.deserialize(&mut ron::de::Deserializer::from_str(&text).unwrap()).unwrap();
//! scene.write_to_world(world, &mut EntityHashMap::default()).unwrap();
//! let mut bricks = world.query::<(&RigidBody, &Pose, &Sleeping)>();
//! let heights = |world: &World, bricks: &mut QueryState<(&RigidBody, &Pose, &Sleeping)>| {
//!     let mut heights: Vec<f32> = bricks.iter(world).map(|(_, pose, _)| pose.position.y).collect();
//!     heights.sort_by(f32::total_cmp);
//!     heights
//! };
//! let before = heights(world, &mut bricks);
//! drystone::step(world, 1.0 / 60.0).unwrap();
//! assert!(bricks.iter(world).all(|(kind, _, sleeping)| *kind != RigidBody::Dynamic || sleeping.asleep));
//! assert_eq!(heights(world, &mut bricks), before);
//! # }
//! ```
//!
//! # What comes back
//!
//! - Exactly: shapes, settings, all components of bodies and joints, velocities, forces of contacts and joints. The pose of a body is that of its
//!   `Transform`; below a parent it is rounded.
//! - Entities get other ids, and all references follow. A scene may be loaded into a world with other bodies, and several times.
//! - What a scene does not contain starts anew: a reference to an entity that was not saved refers to nothing.
//! - What a hand holds is let go; a [`Hand`](crate::grab::Hand) that is closed grabs again. [`ContactHooks`](crate::contact::ContactHooks) and
//!   solvers of your own are code, and are not saved.
//! - Without [`prepare`], a scene is loaded as newly spawned bodies are: sleeping structures without joints get loads by statics, others settle.
//!   So do bodies whose shape is edited between loading and the first step.

mod restore;
mod save;
mod saved;

#[doc(hidden)]
pub use restore::Restored;
pub(crate) use restore::RestoredContacts;
pub use restore::{any_saved, restore};
pub use save::{computed, prepare, settings};
pub use saved::{Saved, SavedContact};
