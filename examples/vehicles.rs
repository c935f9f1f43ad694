//! Drives a car on wheels that are rays, and a cart on jointed wheels, over hills of height fields in tiles, and prints how they get on.
//!
//! ```text
//! cargo run --release --example vehicles -- [--seconds 20] [--vehicles 1] [--hertz 60]
//! ```
//!
//! Each vehicle has a lane of its own. The table has a row for every two seconds: how far the first car and the first cart have got, how
//! fast they are, and the greatest load on a wheel of the car. Then it prints the median time of a step with the cars alone, with the carts
//! alone, and with the cars parked and asleep.

use bevy_app::App;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use clap::Parser;
use drystone::prelude::*;
use drystone::vehicle::ackermann;
use std::f32::consts::FRAC_PI_2;
use std::time::{Duration, Instant};

/// Drives a car and a cart over hills.
#[derive(Parser)]
struct Arguments {
    /// Simulated time, s.
    #[arg(long, default_value_t = 20, value_parser = clap::value_parser!(u32).range(2..600))]
    seconds: u32,
    /// Number of cars, and of carts.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..1000))]
    vehicles: u32,
    /// Steps in a second.
    #[arg(long, default_value_t = 60, value_parser = clap::value_parser!(u32).range(20..1000))]
    hertz: u32,
}

/// Size of a tile, m.
const TILE: f32 = 32.0;

/// Distance of lanes, m.
const LANE: f32 = 6.0;

/// What the driver of a car wants.
const SPEED: f32 = 8.0;

/// Distance of the axles of a car, and of its wheels from the middle, m.
const BASE: f32 = 2.6;
const HALF_TRACK: f32 = 0.7;

#[derive(Component)]
struct Car;

#[derive(Component)]
struct Cart;

/// The height of the hills, m.
fn height(x: f32, z: f32) -> f32 {
    0.6 * (0.15 * x).sin() * (0.2 * z).cos() + 0.1 * (0.7 * x + 0.5 * z).sin()
}

/// Tiles of height fields, from z = 0 to `length` forwards and so many lanes wide.
fn lay_tiles(world: &mut World, lanes: u32, length: f32) {
    const CELLS: u8 = 32;
    let columns = (lanes as f32 * LANE / TILE).ceil() as u32;
    let rows = (length / TILE).ceil() as u32 + 1;
    for tile in 0..columns * rows {
        let (column, row) = ((tile % columns) as f32, (tile / columns) as f32);
        let center = TILE * Vec3::new(column + 0.5, 0.0, 0.5 - row);
        let place = |i: u8| TILE * (f32::from(i) / f32::from(CELLS) - 0.5);
        let line = |i: u8| {
            let point = |j: u8| height(center.x + place(j), center.z + place(i));
            (0..=CELLS).map(point).collect()
        };
        let heights: Vec<Vec<f32>> = (0..=CELLS).map(line).collect();
        let field = Collider::height_field(&heights, Vec3::new(TILE, 1.0, TILE));
        let field = field.expect("the heights are finite");
        world.spawn((
            RigidBody::Static,
            field,
            Transform::from_translation(center),
        ));
    }
}

/// The place of a lane at the start.
fn start(lane: u32, above: f32) -> Vec3 {
    let x = LANE * (lane as f32 + 0.5);
    Vec3::new(x, height(x, 0.0) + above, 0.0)
}

fn spawn_car(world: &mut World, lane: u32) {
    let body = (
        RigidBody::Dynamic,
        Collider::cuboid(1.6, 0.5, 3.6),
        Mass(1200.0),
    );
    let at = Transform::from_translation(start(lane, 1.0));
    let car = world.spawn((body, at, Car)).id();
    for (x, z) in [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)] {
        let place = Transform::from_xyz(HALF_TRACK * x, -0.1, 0.5 * BASE * z);
        world.spawn((Wheel::default(), ChildOf(car), place));
    }
}

fn spawn_cart(world: &mut World, lane: u32) {
    let at = start(lane, 0.9);
    let body = (
        RigidBody::Dynamic,
        Collider::cuboid(1.0, 0.3, 2.0),
        Mass(300.0),
    );
    let cart = world
        .spawn((body, Transform::from_translation(at), Cart))
        .id();
    for (x, z) in [(-0.7, -0.8), (0.7, -0.8), (-0.7, 0.8), (0.7, 0.8)] {
        let center = at + Vec3::new(x, -0.2, z);
        let place =
            Transform::from_translation(center).with_rotation(Quat::from_rotation_z(FRAC_PI_2));
        let wheel = (
            RigidBody::Dynamic,
            Collider::cylinder(0.4, 0.2),
            Mass(20.0),
            Friction::new(1.0),
        );
        let wheel = world.spawn((wheel, place)).id();
        let hinge = RevoluteJoint::new(cart, wheel)
            .with_anchor(center)
            .with_hinge_axis(Vec3::X);
        // The rear axle has a motor.
        world.spawn(match z > 0.0 {
            true => hinge.with_motor(JointMotor::velocity(-10.0, 300.0)),
            false => hinge,
        });
    }
}

/// Keeps cars at their speed and in their lanes, or parks them.
fn steer(world: &mut World, parks: bool) {
    let mut cars = world.query_filtered::<(&Transform, &Velocity, &Children), With<Car>>();
    let mut orders = Vec::new();
    for (at, velocity, wheels) in cars.iter(world) {
        let forward = at.forward();
        let lane = (at.translation.x / LANE).floor() * LANE + 0.5 * LANE;
        let aim = Vec3::new(lane - at.translation.x, 0.0, -8.0);
        let steering = forward
            .cross(aim)
            .y
            .atan2(forward.dot(aim))
            .clamp(-0.5, 0.5);
        let engine = (300.0 * (SPEED - forward.dot(velocity.linear))).clamp(-300.0, 300.0);
        orders.extend(wheels.iter().map(|wheel| (wheel, steering, engine)));
    }
    let mut wheels = world.query::<(&mut Wheel, &Transform)>();
    for (wheel, steering, engine) in orders {
        if let Ok((mut wheel, place)) = wheels.get_mut(world, wheel) {
            wheel.engine = if parks { 0.0 } else { engine };
            wheel.brake = if parks { 2000.0 } else { 0.0 };
            if place.translation.z < 0.0 && !parks {
                wheel.steering = ackermann(steering, BASE, place.translation.x);
            }
        }
    }
}

/// Where the first vehicle is, and how fast.
fn first<M: Component>(world: &mut World) -> (Vec3, f32) {
    let mut bodies = world.query_filtered::<(&Transform, &Velocity), With<M>>();
    let (at, velocity) = bodies.iter(world).next().expect("there is one");
    (at.translation, velocity.linear.length())
}

fn world(arguments: &Arguments, spawn: &[fn(&mut World, u32)]) -> App {
    let mut app = App::new();
    app.add_plugins(DrystonePlugins::default());
    let world = app.world_mut();
    let count = arguments.vehicles * spawn.len() as u32;
    lay_tiles(world, count, (SPEED + 1.0) * arguments.seconds as f32);
    for lane in 0..count {
        spawn[lane as usize % spawn.len()](world, lane);
    }
    app
}

/// The median time of a step, ms.
fn median(mut times: Vec<Duration>) -> f64 {
    times.sort_unstable();
    1e3 * times[times.len() / 2].as_secs_f64()
}

fn main() {
    let arguments = Arguments::parse();
    let dt = 1.0 / arguments.hertz as f32;
    let mut app = world(&arguments, &[spawn_car, spawn_cart]);
    println!("  time |  car: way, speed, load |  cart: way, speed");
    let mut most = 0.0f32;
    for step in 1..=arguments.seconds * arguments.hertz {
        let world = app.world_mut();
        steer(world, false);
        drystone::step(world, dt).expect("the step is valid");
        let mut wheels = world.query::<&WheelState>();
        most = wheels
            .iter(world)
            .map(|wheel| wheel.load)
            .fold(most, f32::max);
        if step % (2 * arguments.hertz) == 0 {
            let ((car, fast), (cart, slow)) = (first::<Car>(world), first::<Cart>(world));
            let seconds = step / arguments.hertz;
            let (car, cart) = (-car.z, -cart.z);
            println!(
                "{seconds:4} s | {car:6.1} m {fast:4.1} m/s {most:5.0} N | {cart:6.1} m {slow:4.1} m/s"
            );
            most = 0.0;
        }
    }
    for (name, spawn, parks) in [
        ("cars", spawn_car as fn(&mut World, u32), false),
        ("carts", spawn_cart, false),
        ("parked cars", spawn_car, true),
    ] {
        let mut app = world(&arguments, &[spawn]);
        let mut times = Vec::new();
        for step in 0..600 {
            steer(app.world_mut(), parks);
            let start = Instant::now();
            drystone::step(app.world_mut(), dt).expect("the step is valid");
            if step >= 400 {
                times.push(start.elapsed());
            }
        }
        println!(
            "{} {name}: {:.3} ms a step",
            arguments.vehicles,
            median(times)
        );
    }
}
