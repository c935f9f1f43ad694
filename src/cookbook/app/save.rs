use bevy_app::{App, Startup};
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::masonry::Arch;
use drystone::prelude::*;
use drystone::saving;

/// What was saved. In a game it is a file.
#[derive(Resource, Default)]
struct Slot(String);

fn save(world: &mut World) {
    let text = saving::to_string(world).unwrap(); // `to_string_with` for entities and resources of your own
    world.insert_resource(Slot(text));
}

fn load(world: &mut World) {
    let text = world.resource::<Slot>().0.clone();
    saving::from_str(world, &text).unwrap();
}

fn build(mut commands: Commands) {
    commands.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
    for stone in Arch::default().blocks().unwrap() {
        commands.spawn(stone.bundle());
    }
}

fn an_arch_is_saved_and_loaded() {
    let mut before = App::new();
    before.add_plugins(DrystonePlugins::default());
    before.add_systems(Startup, build);
    before.world_mut().run_schedule(Startup);
    for _ in 0..240 {
        drystone::step(before.world_mut(), 1.0 / 60.0).unwrap();
    }
    save(before.world_mut());

    let mut after = App::new();
    after.add_plugins(DrystonePlugins::default());
    let slot = before.world_mut().remove_resource::<Slot>().unwrap();
    after.insert_resource(slot);
    load(after.world_mut());
    drystone::step(after.world_mut(), 1.0 / 60.0).unwrap();

    let asleep = |app: &mut App| {
        let mut bodies = app.world_mut().query::<&Sleeping>();
        bodies.iter(app.world()).filter(|body| body.asleep).count()
    };
    assert!(asleep(&mut before) > 10);
    assert_eq!(asleep(&mut after), asleep(&mut before));
    let heights = |app: &mut App| {
        let mut bodies = app.world_mut().query::<&Transform>();
        let mut heights: Vec<f32> = bodies
            .iter(app.world())
            .map(|at| at.translation.y)
            .collect();
        heights.sort_by(f32::total_cmp);
        heights
    };
    assert_eq!(heights(&mut after), heights(&mut before));
}
