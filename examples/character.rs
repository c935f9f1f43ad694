//! A character climbs stairs of loose bricks, and pushes a crate off the top: `cargo run --release --example character`.
//!
//! The character is no body: it only asks where it can go, by [`SpatialQuery::move_and_slide`]. It weighs nothing on what it stands on, and the
//! bricks stay where they were put. The crate that it runs into it pushes with a limited force.

use bevy_app::App;
use bevy_ecs::prelude::*;
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

/// A character that walks along +x.
#[derive(Component)]
pub struct Character {
    shape: Collider,
    /// Speed downwards of a character that does not stand, m/s.
    fall: f32,
    /// What it stands on.
    pub ground: Option<Ground>,
}

/// A body that the character pushes. Bricks of stairs are none.
#[derive(Component)]
pub struct Pushable;

/// Moves the character by one step, and pushes what it runs into.
pub fn walk(
    world: SpatialQuery,
    mut characters: Query<(&mut Character, &mut Transform)>,
    mut bodies: Query<Forces, (With<Pushable>, Without<Character>)>,
    gravity: Res<Gravity>,
) {
    for (mut character, mut transform) in &mut characters {
        let carried = character
            .ground
            .map_or(Vec3::ZERO, |ground| ground.velocity);
        character.fall = match character.ground {
            Some(_) => 0.0,
            None => character.fall - gravity.0.y * DT,
        };
        let velocity = carried + Vec3::X * WALK + Vec3::NEG_Y * character.fall;
        let from = Pose {
            position: transform.translation,
            rotation: transform.rotation,
        };
        let filter = QueryFilter::default();
        let rules = MoveAndSlide::default();
        let slide = world.move_and_slide(&character.shape, from, velocity * DT, &rules, &filter);
        let Ok(slide) = slide.inspect_err(|error| eprintln!("{error}")) else {
            continue;
        };
        transform.translation = slide.position;
        character.ground = slide.ground;
        for hit in slide.hits {
            if let Ok(mut body) = bodies.get_mut(hit.entity) {
                body.apply_linear_impulse_at_point(hit.push(PUSH, DT), hit.point);
            }
        }
    }
}

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
        .spawn((brick(crate_at, Vec3::splat(0.5)), Density(400.0), Pushable))
        .id();
    let settled = |world: &World, body: Entity| world.get::<Transform>(body).unwrap().translation;
    for _ in 0..60 {
        drystone::step(world, DT).expect("the step is valid");
    }
    let put: Vec<Vec3> = bricks.iter().map(|&of| settled(world, of)).collect();
    let shape = Collider::capsule(0.3, 1.0);
    let character = (
        Transform::from_xyz(-1.0, 0.81, 0.0),
        Character {
            shape,
            fall: 0.0,
            ground: None,
        },
    );
    let character = world.spawn(character).id();
    let mut outcome = Outcome {
        highest: 0.0,
        moved: 0.0,
        pushed: 0.0,
        airborne: 0.0,
    };
    let mut airborne = 0.0f32;
    for _ in 0..(seconds / DT) as usize {
        drystone::step(world, DT).expect("the step is valid");
        world.run_system_cached(walk).expect("the system runs");
        let at = settled(world, character);
        outcome.highest = outcome.highest.max(at.y - 0.8);
        let stands = world.get::<Character>(character).unwrap().ground.is_some();
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
