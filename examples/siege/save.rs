//! Saving and loading the whole game as text, in Bevy's scene format.

use crate::castle::Brick;
use crate::drawbridge::{BridgeRope, Deck};
use crate::game::{Clock, Tally};
use crate::lift::{Platform, Slider};
use crate::raiders::{Raider, Yard};
use crate::trebuchet::{Beam, Sling, Stone, Winch};
use bevy_app::App;
use bevy_ecs::entity::EntityHashMap;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use bevy_world_serialization::serde::WorldDeserializer;
use bevy_world_serialization::{DynamicWorldBuilder, WorldFilter};
use drystone::prelude::*;
use drystone::saving;
use serde::de::DeserializeSeed;
use std::any::TypeId;

/// Registers what the game saves besides physics.
pub fn register(app: &mut App) {
    app.register_type::<Brick>()
        .register_type::<Deck>()
        .register_type::<BridgeRope>()
        .register_type::<Platform>()
        .register_type::<Slider>()
        .register_type::<Raider>()
        .register_type::<Yard>()
        .register_type::<Beam>()
        .register_type::<Winch>()
        .register_type::<Sling>()
        .register_type::<Stone>()
        .register_type::<Clock>()
        .register_type::<Tally>();
}

/// The game as text.
pub fn write(world: &mut World) -> String {
    let entities = saving::prepare(world);
    let registry = world.resource::<AppTypeRegistry>().clone();
    let own = [TypeId::of::<Clock>(), TypeId::of::<Tally>()];
    let scene = DynamicWorldBuilder::from_world(world, &registry.read())
        .with_component_filter(WorldFilter::Denylist(saving::computed(world).collect()))
        .with_resource_filter(WorldFilter::Allowlist(
            saving::settings().chain(own).collect(),
        ))
        .extract_entities(entities.into_iter())
        .extract_resources()
        .build();
    scene
        .serialize(&registry.read())
        .expect("all of it can be written")
}

/// Reads a game into an empty app.
pub fn read(world: &mut World, text: &str) {
    let registry = world.resource::<AppTypeRegistry>().clone();
    let scene = WorldDeserializer {
        type_registry: &registry.read(),
        load_from_path: &mut NoAssets,
    };
    let mut text = ron::de::Deserializer::from_str(text).expect("it was written by us");
    let scene = scene.deserialize(&mut text).expect("it was written by us");
    scene
        .write_to_world(world, &mut EntityHashMap::default())
        .expect("all of it is registered");
}

struct NoAssets;

impl bevy_asset::LoadFromPath for NoAssets {
    fn load_from_path_erased(
        &mut self,
        _: TypeId,
        _: bevy_asset::AssetPath<'static>,
    ) -> bevy_asset::UntypedHandle {
        unreachable!("the game has no assets")
    }
}

/// The positions of all bodies, sorted: two apps have different entities.
pub fn poses(world: &mut World) -> Vec<[u32; 3]> {
    let mut bodies = world.query_filtered::<&Transform, With<RigidBody>>();
    let bodies = bodies
        .iter(world)
        .map(|at| at.translation.to_array().map(f32::to_bits));
    let mut poses: Vec<_> = bodies.collect();
    poses.sort_unstable();
    poses
}

/// How many bodies sleep.
pub fn asleep(world: &mut World) -> usize {
    let mut bodies = world.query::<&Sleeping>();
    bodies.iter(world).filter(|body| body.asleep).count()
}
