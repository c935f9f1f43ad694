//! A character climbs stairs of loose bricks, and pushes a crate off the top: `cargo run --release --example character`.
//!
//! The step moves the character by the component [`Character`]: the game only says where it wants to go. It weighs nothing on what it
//! stands on, and the bricks stay where they were put. The crate that it runs into it pushes with a limited force.

use bevy_app::App;
use bevy_ecs::entity::Entity;
use bevy_ecs::world::World;
use bevy_transform::components::Transform;
use drystone::prelude::*;

/// Length of a step, s.
const DT: f32 = 1.0 / 60.0;
/// Speed of the character, m/s.
const WALK: f32 = 2.0;
/// The largest force with which it pushes, N.
const PUSH: f32 = 320.0;
/// Number of stairs, and their size, m.
const STAIRS: usize = 8;
const STAIR: Vec3 = Vec3::new(0.4, 0.2, 1.5);

/// What happened.
#[derive(Debug)]
pub struct Outcome {
    /// The highest position of the character's feet, m.
    pub highest: f32,
    /// The farthest that a brick has moved from where it was put, m.
    pub moved: f32,
    /// How far the crate was pushed, m.
    pub pushed: f32,
    /// The longest time without ground on the stairs, s.
    pub airborne: f32,
}

/// Builds the stairs, and lets the character climb them for some seconds.
pub fn play(seconds: f32) -> Outcome {
    let mut app = App::new();
    app.add_plugins(DrystonePlugins::default());
    let world = app.world_mut();
    world.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
    let brick = |at: Vec3, size: Vec3| {
        let shape = Collider::cuboid(size.x, size.y, size.z);
        (RigidBody::Dynamic, shape, Transform::from_translation(at))
    };
    let mut bricks = Vec::new();
    for (row, side) in (0..STAIRS).flat_map(|row| [(row, -0.25), (row, 0.25)]) {
        // Each course begins one stair farther on, and all end together. Two loose bricks lie side by side in it.
        let length = STAIR.x * (STAIRS + 2 - row) as f32;
        let x = 0.8 + STAIR.x * row as f32 + 0.5 * length;
        let at = Vec3::new(x, STAIR.y * (row as f32 + 0.5), side * STAIR.z);
        bricks.push(
            world
                .spawn(brick(at, Vec3::new(length, STAIR.y, 0.5 * STAIR.z)))
                .id(),
        );
    }
    let top = STAIR.y * STAIRS as f32;
    let end = 1.0 + STAIR.x * (STAIRS + 1) as f32;
    let crate_at = Vec3::new(end, top + 0.25, 0.0);
    let pushed = world
        .spawn((brick(crate_at, Vec3::splat(0.5)), Density(400.0)))
        .id();
    let settled = |world: &World, body: Entity| world.get::<Transform>(body).unwrap().translation;
    for _ in 0..60 {
        drystone::step(world, DT).expect("the step is valid");
    }
    let put: Vec<Vec3> = bricks.iter().map(|&of| settled(world, of)).collect();
    let character = Character {
        walk: Vec3::X * WALK,
        push: PUSH,
        ..Character::default()
    };
    let shape = Collider::capsule(0.3, 1.0);
    let at = Transform::from_xyz(-1.0, 0.81, 0.0);
    let character = world.spawn((character, shape, at)).id();
    let mut outcome = Outcome {
        highest: 0.0,
        moved: 0.0,
        pushed: 0.0,
        airborne: 0.0,
    };
    let mut airborne = 0.0f32;
    for _ in 0..(seconds / DT) as usize {
        drystone::step(world, DT).expect("the step is valid");
        let at = settled(world, character);
        outcome.highest = outcome.highest.max(at.y - 0.8);
        let stands = world.get::<CharacterState>(character).unwrap().stands();
        airborne = if stands { 0.0 } else { airborne + DT };
        if at.x < end {
            outcome.airborne = outcome.airborne.max(airborne);
        }
        for (&brick, put) in bricks.iter().zip(&put) {
            outcome.moved = outcome.moved.max(settled(world, brick).distance(*put));
        }
        outcome.pushed = outcome.pushed.max(settled(world, pushed).x - crate_at.x);
    }
    outcome
}

fn main() {
    let Outcome {
        highest,
        moved,
        pushed,
        airborne,
    } = play(6.0);
    println!(
        "The character climbed to {highest:.3} m, and was in the air for {airborne:.2} s at most."
    );
    println!("No brick moved by more than {:.4} mm.", 1e3 * moved);
    println!("It pushed the crate by {pushed:.2} m.");
}
