//! The same wall, built farther and farther from the origin: whether it stands, and how far it drifts.
//!
//! It is turned by 30°, so that no brick is exactly where it should be: coordinates are rounded, and neighbours overlap or have gaps.

use super::DT;
use bevy_app::App;
use bevy_ecs::world::World;
use bevy_transform::components::Transform;
use drystone::masonry::{BRICK, Bond, Wall};
use drystone::prelude::*;
use std::error::Error;

/// Distances from the origin, km.
const DISTANCES: [f32; 8] = [0.0, 1.0, 10.0, 30.0, 100.0, 200.0, 300.0, 1000.0];

/// Angle of the wall about the vertical, rad.
const TURN: f32 = std::f32::consts::FRAC_PI_6;

/// How long a wall stands, s.
const TIME: f32 = 20.0;

/// A drift from which on a wall counts as fallen, m.
const FALLEN: f32 = 0.25;

pub fn run() -> Result<(), Box<dyn Error>> {
    println!(
        "| km | rounding of a coordinate, mm | wall of 10 × 10, drift, mm | laid brick by brick, mm | a ball is thrown at it, mm | as \
         far up, mm |\n|---|---|---|---|---|---|"
    );
    for distance in DISTANCES {
        let far = 1e3 * distance * Vec3::new(0.6, 0.0, 0.8);
        let up = far + 1e3 * distance * Vec3::Y;
        let rounding = far.max_element() * f32::EPSILON;
        let columns = [
            (far, Way::Standing),
            (far, Way::ByBrick),
            (far, Way::Hit),
            (up, Way::Standing),
        ];
        let columns = columns.map(|(far, way)| drift(far, way));
        let [standing, laid, hit, up] = columns.map(|drift| match drift {
            Ok(drift) if drift < FALLEN => format!("{:.2}", 1e3 * drift),
            Ok(_) => "fallen".into(),
            Err(error) => error.to_string(),
        });
        println!(
            "| {distance} | {:.3} | {standing} | {laid} | {hit} | {up} |",
            1e3 * rounding
        );
    }
    Ok(())
}

/// What is done.
#[derive(Clone, Copy, PartialEq)]
enum Way {
    /// All bricks are there at once.
    Standing,
    /// A brick is laid every tenth of a second, a millimetre above the course.
    ByBrick,
    /// A ball of 4 kg flies at 10 m/s into the middle of the wall.
    Hit,
}

/// The largest distance of a brick from where it was put, m. Only the wall sleeps that is hit.
fn drift(far: Vec3, way: Way) -> Result<f32, Box<dyn Error>> {
    let mut app = App::new();
    app.add_plugins(DrystonePlugins::default());
    let world = app.world_mut();
    world.resource_mut::<SleepSettings>().enabled = way == Way::Hit;
    // The ground is near the wall: a half-space is defined by a point, too.
    let ground = Transform::from_translation(far);
    world.spawn((RigidBody::Static, Collider::half_space(Vec3::Y), ground));
    let wall = Wall {
        length: 10.0,
        courses: 10,
        ..Wall::new(Bond::Running)
    };
    let turn = Quat::from_rotation_y(TURN);
    let frame = Pose {
        position: far,
        rotation: turn,
    };
    let blocks = wall.blocks()?.into_iter();
    let blocks: Vec<_> = blocks.map(|block| block.moved(&frame)).collect();
    let places: Vec<Vec3> = blocks.iter().map(|block| block.pose.position).collect();
    let mut bricks = Vec::new();
    for mut block in blocks {
        if way == Way::ByBrick {
            block.pose.position.y += 1e-3;
        }
        bricks.push(world.spawn(block.bundle()).id());
        if way == Way::ByBrick {
            steps(world, 0.1)?;
        }
    }
    if way == Way::Hit {
        steps(world, 2.0)?;
        let at = far + turn * Vec3::new(0.3, 5.0 * BRICK.y, 2.0);
        world.spawn((
            RigidBody::Dynamic,
            Collider::ball(0.1),
            Transform::from_translation(at),
            Velocity::linear(turn * Vec3::new(0.0, 1.0, -10.0)),
        ));
    }
    steps(world, TIME)?;
    let drifts = bricks.iter().zip(&places).map(|(&brick, place)| {
        let now = world.get::<Pose>(brick).copied().unwrap_or_default();
        (now.position - *place).length()
    });
    Ok(drifts.fold(0.0, f32::max))
}

fn steps(world: &mut World, time: f32) -> Result<(), Box<dyn Error>> {
    for _ in 0..(time / DT).round() as usize {
        drystone::step(world, DT)?;
    }
    Ok(())
}
