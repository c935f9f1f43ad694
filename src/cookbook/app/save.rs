use bevy_app::App;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::masonry::Arch;
use drystone::prelude::*;
use drystone::saving;

/// In a game it goes into a file. A system that has no `&mut World` queues it as a command.
fn save(world: &mut World) -> String {
    saving::to_string(world).unwrap() // `to_string_with` for entities and resources of your own
}

fn load(world: &mut World, text: &str) {
    saving::from_str(world, text).unwrap();
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
