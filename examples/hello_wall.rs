//! A wall without an app around it, ten seconds, and where its top brick is then: `cargo run --release --example hello_wall`.

use bevy_app::App;
use bevy_ecs::prelude::*;
use drystone::{masonry::*, prelude::*};

fn main() {
    let mut app = App::new();
    app.add_plugins(DrystonePlugins::default());
    let world = app.world_mut();
    world.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
    let mut top = Entity::PLACEHOLDER;
    for brick in Wall::new(Bond::Running).blocks().unwrap() {
        top = world.spawn(brick.bundle()).id();
    }
    for _ in 0..600 {
        drystone::step(world, 1.0 / 60.0).unwrap();
    }
    let Pose { position, .. } = world.get(top).unwrap();
    println!("after ten seconds the top brick is at {position}");
}
