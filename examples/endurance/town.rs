//! A town that stands for a day, and a player who comes to one of its walls once an hour.

use super::DT;
use super::flat::{PARTS, Parts};
use bevy_app::App;
use bevy_ecs::entity::EntityHashSet;
use bevy_ecs::prelude::*;
use drystone::prelude::*;
use drystone_lab::play::Player;
use drystone_lab::town;
use std::error::Error;

/// Bricks in a course, and courses.
const WALL: [u32; 2] = [40, 25];

/// Distance between the walls of a street, m. Balls come to rest between them.
const APART: f32 = 6.0;

/// Time between two visits of the player, s.
const HOUR: f32 = 3600.0;

/// Length of a visit, and time between two actions of the player, s.
const VISIT: f32 = 60.0;
const PAUSE: f32 = 0.5;

/// How far a brick of the wall on which the player plays may be from its place, m. Balls of 4 kg hit it.
const PLAYED: f32 = 0.01;

pub fn run(hours: f32, walls: u32) -> Result<(), Box<dyn Error>> {
    let mut app = App::new();
    app.add_plugins(DrystonePlugins::default());
    let world = app.world_mut();
    world.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
    let bricks = town::build(world, WALL, walls, APART)?;
    drystone::step(world, DT)?;
    let town = bodies(world).into_iter().collect();
    let places: Vec<Pose> = poses(world, &bricks);

    println!("{} bricks, {hours} h\n", bricks.len());
    let steps = ((3600.0 * hours / DT) as usize / PARTS).max(1);
    let (hour, visit, pause) = [HOUR, VISIT, PAUSE].map(|time| (time / DT) as usize).into();
    let mut player = Player::new(WALL, 1);
    let mut parts = Parts::begin();
    for part in 0..PARTS {
        for step in 0..steps {
            match (part * steps + step) % hour {
                now if now < visit && now % pause == 0 => _ = player.act(world),
                // What the player brought lies about for a minute.
                now if now == 2 * visit => {
                    clear(world, &town);
                    player = Player::new(WALL, (part * steps + step) as u64);
                }
                _ => (),
            }
            drystone::step(world, DT)?;
        }
        parts.end(steps, bodies(world).len())?;
    }
    compare(world, &bricks, &places)?;
    parts.are_flat()
}

fn bodies(world: &mut World) -> Vec<Entity> {
    let mut bodies = world.query_filtered::<Entity, With<RigidBody>>();
    bodies.iter(world).collect()
}

fn poses(world: &World, bricks: &[Entity]) -> Vec<Pose> {
    let pose = |&brick: &Entity| world.get::<Pose>(brick).copied().unwrap_or_default();
    bricks.iter().map(pose).collect()
}

/// Removes all bodies that are not the town's.
fn clear(world: &mut World, town: &EntityHashSet) {
    let brought: Vec<Entity> = bodies(world)
        .into_iter()
        .filter(|body| !town.contains(body))
        .collect();
    for body in brought {
        world.despawn(body);
    }
}

/// Compares all bricks with their places.
///
/// # Errors
/// If a brick of a wall to which nobody came is not exactly where it was, or one of the other wall is far from it.
fn compare(world: &World, bricks: &[Entity], places: &[Pose]) -> Result<(), Box<dyn Error>> {
    let played = bricks.len().min(1012);
    let now = poses(world, bricks);
    let moved = |i: &usize| now[*i] != places[*i];
    let others = (played..bricks.len()).filter(moved).count();
    let distances = (0..played).map(|i| now[i].position.distance(places[i].position));
    let farthest = distances.fold(0.0, f32::max);
    println!(
        "\n{others} of {} bricks moved that nobody touched; on the wall that was played on, bricks are up to {:.3} mm from their places",
        bricks.len() - played,
        1e3 * farthest
    );
    if others > 0 {
        return Err(format!("{others} bricks moved").into());
    }
    if farthest > PLAYED {
        return Err(format!("a brick moved by {farthest} m").into());
    }
    Ok(())
}
