//! Everyday faults: each test is something that a user found, and stands for its kind. `cargo test --test everyday seams::` runs one
//! module.

use bevy_app::App;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::prelude::*;

mod angles;
mod breaking;
mod bytes;
mod characters;
mod children;
mod contacts;
mod dominance;
mod fast;
mod hooks;
mod joints;
mod lengths;
mod need;
mod oblique;
mod previews;
mod queries;
mod seams;
mod sensors;
mod sleep;
mod stances;
mod tops;

/// 1/60 s.
const DT: f32 = 1.0 / 60.0;

/// A world with drystone's plugins.
fn app() -> App {
    let mut app = App::new();
    app.add_plugins(DrystonePlugins::default());
    app
}

fn at(x: f32, y: f32, z: f32) -> Transform {
    Transform::from_xyz(x, y, z)
}

fn cube(size: f32) -> Collider {
    Collider::cuboid(size, size, size)
}

/// Takes steps of [`DT`].
fn steps(world: &mut World, count: usize) {
    steps_of(world, count, DT);
}

fn steps_of(world: &mut World, count: usize, dt: f32) {
    for _ in 0..count {
        drystone::step(world, dt).unwrap();
    }
}

fn position(world: &World, id: Entity) -> Vec3 {
    world.get::<Transform>(id).unwrap().translation
}

fn velocity(world: &World, id: Entity) -> Velocity {
    *world.get::<Velocity>(id).unwrap()
}

/// Friction of zero, whatever the other body has.
fn ice() -> Friction {
    Friction::new(0.0).with_rule(CombineRule::Min)
}
