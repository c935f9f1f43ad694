//! Scenes as text (feature `scenes`).

use super::{computed, prepare, settings};
use bevy_asset::{AssetPath, AssetServer, LoadFromPath, UntypedHandle};
use bevy_ecs::entity::EntityHashMap;
use bevy_ecs::prelude::*;
use bevy_world_serialization::serde::WorldDeserializer;
use bevy_world_serialization::{DynamicWorldBuilder, WorldFilter};
use serde::de::DeserializeSeed;
use std::any::TypeId;
use thiserror::Error;

/// Why a world cannot be written to text or read from it.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum TextError {
    /// A component cannot be written: a collider of a custom shape, or a type of the game without `ReflectSerialize`.
    #[error("the world cannot be written: {0}")]
    Write(String),
    /// The text is no scene in Bevy's format, or names a type that is not registered.
    #[error("the text cannot be read: {0}")]
    Read(String),
    /// A type of the scene is registered, but not as a component or resource.
    #[error("the scene cannot be put into the world: {0}")]
    Insert(String),
}

/// The bodies, colliders and joints of a world and its settings, as text in Bevy's scene format (`.scn.ron`). All components of these
/// entities are written that are registered, also those of the game. [`from_str`] reads it, and so does Bevy's asset server.
///
/// ```
/// use bevy_app::App;
/// use bevy_ecs::prelude::*;
/// use bevy_transform::components::Transform;
/// use drystone::prelude::*;
/// use drystone::saving;
///
/// let app = || {
///     let mut app = App::new();
///     app.add_plugins(DrystonePlugins::default());
///     app
/// };
/// let (mut before, mut after) = (app(), app());
/// let world = before.world_mut();
/// world.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
/// let brick = (RigidBody::Dynamic, Collider::cuboid(1.0, 0.5, 0.5), Transform::from_xyz(0.0, 0.25, 0.0));
/// let brick = world.spawn(brick).id();
/// for _ in 0..60 {
///     drystone::step(world, 1.0 / 60.0).unwrap();
/// }
/// let text = saving::to_string(world).unwrap();
/// let entities = saving::from_str(after.world_mut(), &text).unwrap();
/// // It sleeps where it slept.
/// drystone::step(after.world_mut(), 1.0 / 60.0).unwrap();
/// let again = after.world().entity(entities[&brick]);
/// assert!(again.get::<Sleeping>().unwrap().asleep);
/// assert_eq!(again.get::<Transform>(), before.world().get::<Transform>(brick));
/// ```
///
/// # Errors
/// [`TextError::Write`].
pub fn to_string(world: &mut World) -> Result<String, TextError> {
    to_string_with(world, &[], &[])
}

/// As [`to_string`], with more entities and resources: those of the game.
///
/// # Errors
/// [`TextError::Write`].
pub fn to_string_with(
    world: &mut World,
    entities: &[Entity],
    resources: &[TypeId],
) -> Result<String, TextError> {
    let own = prepare(world);
    let registry = world.resource::<AppTypeRegistry>().clone();
    let resources = settings().chain(resources.iter().copied());
    let scene = DynamicWorldBuilder::from_world(world, &registry.read())
        .with_component_filter(WorldFilter::Denylist(computed(world).collect()))
        .with_resource_filter(WorldFilter::Allowlist(resources.collect()))
        .extract_entities(own.into_iter().chain(entities.iter().copied()))
        .extract_resources()
        .build();
    let text = scene.serialize(&registry.read());
    text.map_err(|error| TextError::Write(error.to_string()))
}

/// Spawns what [`to_string`] has written, and returns the new entities by those that were written. Types of the game must be registered.
/// Assets are loaded by the `AssetServer`, if the world has one.
///
/// # Errors
/// [`TextError::Read`], after which the world is as before, or [`TextError::Insert`].
pub fn from_str(world: &mut World, text: &str) -> Result<EntityHashMap<Entity>, TextError> {
    let registry = world.resource::<AppTypeRegistry>().clone();
    let scene = WorldDeserializer {
        type_registry: &registry.read(),
        load_from_path: &mut Assets(world.get_resource::<AssetServer>().cloned()),
    };
    let read = |error: String| TextError::Read(error);
    let mut text =
        ron::de::Deserializer::from_str(text).map_err(|error| read(error.to_string()))?;
    let scene = scene.deserialize(&mut text);
    let scene = scene.map_err(|error| read(text.span_error(error).to_string()))?;
    let mut entities = EntityHashMap::default();
    let put = scene.write_to_world(world, &mut entities);
    put.map_err(|error| TextError::Insert(error.to_string()))?;
    Ok(entities)
}

/// Loads the assets that a scene refers to.
struct Assets(Option<AssetServer>);

impl LoadFromPath for Assets {
    fn load_from_path_erased(&mut self, kind: TypeId, path: AssetPath<'static>) -> UntypedHandle {
        match &mut self.0 {
            Some(server) => server.load_from_path_erased(kind, path),
            None => UntypedHandle::default_for_type(kind),
        }
    }
}
