use bevy_app::App;
use bevy_ecs::entity::EntityHashMap;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use bevy_world_serialization::serde::WorldDeserializer;
use bevy_world_serialization::{DynamicWorldBuilder, WorldFilter};
use drystone::masonry::Arch;
use drystone::prelude::*;
use drystone::saving;
use serde::de::DeserializeSeed;

fn save(world: &mut World) -> String {
    let entities = saving::prepare(world); // and your own
    let registry = world.resource::<AppTypeRegistry>().clone();
    let scene = DynamicWorldBuilder::from_world(world, &registry.read())
        .with_component_filter(WorldFilter::Denylist(saving::computed(world).collect()))
        .with_resource_filter(WorldFilter::Allowlist(saving::settings().collect())) // and your own
        .extract_entities(entities.into_iter())
        .extract_resources()
        .build();
    scene.serialize(&registry.read()).unwrap()
}

/// In a game, the asset server does this with a file.
fn load(world: &mut World, text: &str) {
    let registry = world.resource::<AppTypeRegistry>().clone();
    let scene = WorldDeserializer {
        type_registry: &registry.read(),
        load_from_path: &mut NoAssets,
    };
    let mut text = ron::de::Deserializer::from_str(text).unwrap();
    let scene = scene.deserialize(&mut text).unwrap();
    scene.write_to_world(world, &mut EntityHashMap::default()).unwrap();
}

fn an_arch_is_saved_and_loaded() {
    let mut before = App::new();
    before.add_plugins(DrystonePlugins::default());
    before.world_mut().spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
    for stone in Arch::default().blocks().unwrap() {
        before.world_mut().spawn(stone.bundle());
    }
    for _ in 0..240 {
        drystone::step(before.world_mut(), 1.0 / 60.0).unwrap();
    }
    let text = save(before.world_mut());

    let mut after = App::new();
    after.add_plugins(DrystonePlugins::default());
    load(after.world_mut(), &text);
    drystone::step(after.world_mut(), 1.0 / 60.0).unwrap();

    let asleep = |world: &mut World| world.query::<&Sleeping>().iter(world).filter(|body| body.asleep).count();
    assert_eq!(asleep(after.world_mut()), asleep(before.world_mut()));
    let heights = |world: &mut World| {
        let mut heights: Vec<f32> = world.query::<&Transform>().iter(world).map(|at| at.translation.y).collect();
        heights.sort_by(f32::total_cmp);
        heights
    };
    assert_eq!(heights(after.world_mut()), heights(before.world_mut()));
}
