//! Restitution: the kept speed, no gain of energy, and the events.

use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::body::{Density, RigidBody, Velocity};
use drystone::collider::{Collider, Friction, Restitution};
use drystone::contact::{ContactImpulses, ContactPair};
use drystone::settings::Gravity;
use drystone_lab::metrics;
use glam::{Quat, Vec3};
use support::*;

const ELASTIC: Restitution = Restitution::new(1.0);

/// A ground that gives everything back.
fn floor(lab: &mut Lab, restitution: f32) {
    lab.spawn((
        RigidBody::Static,
        Collider::half_space(Vec3::Y),
        Restitution::new(restitution),
    ));
}

/// Mechanical energy at each apex, J/kg above that of lying on the ground at this height.
fn apexes(lab: &mut Lab, body: Entity, rest: f32, seconds: f32) -> Vec<f32> {
    let (mut energies, mut rising) = (Vec::new(), false);
    for _ in 0..(seconds / lab.dt) as usize {
        lab.step();
        let v = lab.velocity(body).linear.y;
        if rising && v <= 0.0 {
            energies.push(G * (lab.position(body).y - rest) + 0.5 * v * v);
        }
        rising = v > 0.0;
    }
    energies
}

fn bounces(lab: impl Fn(f32) -> Lab, what: &str, noise: f32) {
    for (shape, collider) in [
        ("ball", Collider::ball(0.25)),
        ("box", Collider::cuboid(0.5, 0.5, 0.5)),
    ] {
        for height in [0.3, 1.0, 3.0] {
            let mut lab = lab(1.0 / 60.0);
            floor(&mut lab, 1.0);
            let body = lab.spawn((
                RigidBody::Dynamic,
                collider.clone(),
                ELASTIC,
                Transform::from_xyz(0.0, 0.25 + height, 0.0),
            ));
            let energies = apexes(&mut lab, body, 0.25, 30.0);
            let n = energies.len();
            let last = *energies.last().unwrap_or(&0.0);
            let each = 1.0 - (last / (G * height)).powf(1.0 / n as f32);
            let gain = energies
                .windows(2)
                .map(|pair| pair[1] / pair[0] - 1.0)
                .fold(energies[0] / (G * height) - 1.0, f32::max);
            println!(
                "{what}, {shape} from {height} m: {n} bounces, {:.3} % lost in each, gains {gain:.1e}",
                100.0 * each
            );
            assert!(each < 0.01, "{what}, {shape} from {height} m: {each}");
            assert!(gain < noise, "{what}, {shape} from {height} m: {gain}");
        }
    }
}

#[test]
fn bodies_lose_less_than_a_hundredth_a_bounce() {
    bounces(Lab::shipped, "soft step", 1e-4);
    // Semi-implicit Euler swings about the true energy by gΔt v/2, and apexes are seen at up to gΔt.
    bounces(Lab::exact, "nncg", 0.005);
}

/// Forty balls in a closed box without gravity, each of which meets a wall or another some 170 times in the minute. Without
/// friction, which would slow and spin them.
#[test]
fn a_gas_of_balls_keeps_its_energy() {
    let mut lab = Lab::shipped(1.0 / 60.0);
    lab.world.insert_resource(Gravity(Vec3::ZERO));
    let size = 4.0;
    for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
        for side in [-1.0, 1.0] {
            let half = Vec3::splat(size) - axis * (size - 1.0);
            lab.spawn((
                RigidBody::Static,
                Collider::cuboid(2.0 * half.x, 2.0 * half.y, 2.0 * half.z),
                ELASTIC,
                Friction::new(0.0),
                Transform::from_translation(axis * side * (0.5 * size + 1.0)),
            ));
        }
    }
    let mut rng = fastrand::Rng::with_seed(5);
    for i in 0..40 {
        let at = Vec3::new((i % 4) as f32, (i / 4 % 4) as f32, (i / 16) as f32) - 1.5;
        let mut one = || 6.0 * rng.f32() - 3.0;
        let velocity = Velocity::linear(Vec3::new(one(), one(), one()));
        lab.spawn((
            RigidBody::Dynamic,
            Collider::ball(0.2),
            ELASTIC,
            Friction::new(0.0),
            velocity,
            Transform::from_translation(at * 0.9),
        ));
    }
    lab.step();
    let start = metrics::kinetic_energy(&mut lab.world);
    let (mut last, mut gain) = (start, 0.0f64);
    for _ in 0..3600 {
        lab.step();
        let now = metrics::kinetic_energy(&mut lab.world);
        gain = gain.max((now - last) / last);
        last = now;
    }
    println!("{:.4} kept, gains {gain:.1e}", last / start);
    assert!(last > 0.99 * start, "{last} J of {start} J");
    assert!(gain < 1e-6, "{gain}");
}

/// Balls and boxes of many weights that fly into each other, and fall into a heap. From one step to the next the springs of contacts
/// may give back what they have just taken, as they do without restitution; against the start nothing is gained.
#[test]
fn bounces_among_many_gain_nothing() {
    for seed in 0..8 {
        for restitution in [0.0, 0.5, 0.9, 1.0] {
            let mut lab = Lab::shipped(1.0 / 60.0);
            let mut rng = fastrand::Rng::with_seed(seed);
            let mut random = |size: f32| {
                let mut one = || (2.0 * rng.f32() - 1.0) * size;
                Vec3::new(one(), one(), one())
            };
            if seed % 2 == 0 {
                lab.world.insert_resource(Gravity(Vec3::ZERO));
            } else {
                floor(&mut lab, restitution);
            }
            for i in 0..27 {
                let cell = Vec3::new((i % 3) as f32, (i / 3 % 3) as f32, (i / 9) as f32);
                let at = (cell - 1.0) * 1.1;
                let collider = match i % 2 {
                    0 => Collider::cuboid(0.8, 0.5, 0.6),
                    _ => Collider::ball(0.4),
                };
                lab.spawn((
                    RigidBody::Dynamic,
                    collider,
                    Restitution::new(restitution),
                    Friction::new(if seed % 3 == 0 { 0.0 } else { 0.5 }),
                    Density(500.0 * (1 + i % 4) as f32),
                    Velocity {
                        linear: -2.0 * at + random(2.0),
                        angular: random(3.0),
                    },
                    Transform::from_translation(at + Vec3::Y * 2.2)
                        .with_rotation(Quat::from_scaled_axis(random(0.1))),
                ));
            }
            lab.step();
            let start = metrics::energy(&mut lab.world);
            let (mut last, mut gain) = (start, 0.0f64);
            for _ in 0..600 {
                lab.step();
                let now = metrics::energy(&mut lab.world);
                assert!(
                    now <= start * (1.0 + 1e-6),
                    "seed {seed}, e {restitution}: {start} to {now} J"
                );
                gain = gain.max((now - last) / start);
                last = now;
            }
            println!(
                "seed {seed}, e {restitution}: {:.3} kept, gains {gain:.1e}",
                last / start
            );
            // The contact springs of landed bodies return a little energy, but never more than at the start.
            assert!(gain < 3e-3, "seed {seed}, e {restitution}: {gain}");
        }
    }
}

/// Five balls in a row that touch, and one that comes.
#[test]
fn a_row_of_balls_hands_the_blow_on() {
    let mut lab = Lab::shipped(1.0 / 60.0);
    lab.world.insert_resource(Gravity(Vec3::ZERO));
    let balls: Vec<Entity> = [-2.0, 0.0, 0.5, 1.0, 1.5, 2.0]
        .map(|x| {
            lab.spawn((
                RigidBody::Dynamic,
                Collider::ball(0.25),
                ELASTIC,
                Transform::from_xyz(x, 0.0, 0.0),
            ))
        })
        .to_vec();
    lab.set_velocity(balls[0], Vec3::X * 2.0, Vec3::ZERO);
    lab.step();
    let start = metrics::kinetic_energy(&mut lab.world);
    let mut last = start;
    for _ in 0..120 {
        lab.step();
        let now = metrics::kinetic_energy(&mut lab.world);
        assert!(now <= last * (1.0 + 1e-6), "{last} to {now} J");
        last = now;
    }
    let speeds: Vec<f32> = balls.iter().map(|&b| lab.velocity(b).linear.x).collect();
    println!("{speeds:?}, {:.4} kept", last / start);
    assert!(last > 0.999 * start, "{last} J of {start} J");
}

/// Σ λ_n of a landing in its one step is m v (1 + e).
#[test]
fn the_impulse_of_a_landing_is_told_whole_in_its_step() {
    for (shape, collider) in [
        ("ball", Collider::ball(0.5)),
        ("box", Collider::cuboid(1.0, 1.0, 1.0)),
    ] {
        for restitution in [0.0, 0.5, 0.8, 1.0] {
            for height in [0.2, 1.0, 5.0] {
                let mut lab = Lab::shipped(1.0 / 60.0);
                floor(&mut lab, restitution);
                let body = lab.spawn((
                    RigidBody::Dynamic,
                    collider.clone(),
                    Restitution::new(restitution),
                    Transform::from_xyz(0.0, 0.5 + height, 0.0),
                ));
                lab.step();
                let mass = lab.mass(body).mass();
                let mut told = Vec::new();
                for _ in 0..120 {
                    lab.step();
                    let mut pairs = lab.world.query::<(&ContactPair, &ContactImpulses)>();
                    let sum: f32 = pairs
                        .iter(&lab.world)
                        .flat_map(|(_, impulses)| &impulses.points)
                        .map(|point| point.normal)
                        .sum();
                    if sum > 0.0 || !told.is_empty() {
                        told.push(sum);
                    }
                    if told.len() == 2 {
                        break;
                    }
                }
                let expected = mass * (2.0 * G * height).sqrt() * (1.0 + restitution);
                let what = format!("{shape}, e {restitution}, from {height} m");
                println!("{what}: {told:?} of {expected} N·s");
                // For the rest of the step the ground carries its weight too.
                let weight = mass * G * lab.dt;
                let fits = 0.98 * expected..=1.02 * expected + weight;
                assert!(
                    fits.contains(&told[0]),
                    "{what}: {told:?} of {expected} N·s"
                );
                assert!(told[1] <= 1.02 * weight, "{what}: {told:?}");
            }
        }
    }
}
