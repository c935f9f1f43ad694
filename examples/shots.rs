//! A heavy ball that hits a wall, at short and long steps: it must move the wall equally far.
//!
//! `cargo run --release --example shots` writes `target/shots.md`; it fails where a wall is moved too far or too little.

use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::body::{RigidBody, Velocity};
use drystone::collider::{Collider, Friction};
use drystone_lab::scenes::{Scene, SceneOptions};
use glam::Vec3;
use std::error::Error;
use std::f32::consts::PI;
use std::fmt::Write;
use std::fs;
use support::*;

/// kg, m/s
const BALL: f32 = 200.0;
const SPEED: f32 = 15.0;

/// The initial positions of balls, m: in front of the middle of the wall, a little beside the bed joint at half its height. So a ball
/// strikes at least two bricks. A single brick that is struck nearly leaves the wall, and chance decides whether it does.
const FROM: [Vec3; 5] = [
    Vec3::new(0.0, 2.0, -2.0),
    Vec3::new(0.13, 2.07, -2.0),
    Vec3::new(-0.21, 2.11, -2.0),
    Vec3::new(0.31, 1.91, -2.0),
    Vec3::new(-0.4, 1.83, -2.0),
];

/// The result of a shot.
#[derive(Clone, Copy)]
struct Shot {
    /// The displacement of bricks three seconds later: the mean and the maximum, mm.
    moved: f32,
    farthest: f32,
    /// The mean at a fifth of a second, before they swing back, mm.
    soon: f32,
    /// Then: the speed of the ball, m/s, and what the wall has of its momentum of 3000 N·s.
    ball: f32,
    momentum: f32,
}

/// Mean and largest distance, mm.
fn distances(lab: &Lab, bricks: &[Entity], start: &[Vec3]) -> (f32, f32) {
    let each = bricks.iter().zip(start);
    let far = each.map(|(&brick, start)| 1e3 * lab.position(brick).distance(*start));
    let (sum, most) = far.fold((0.0, 0f32), |(sum, most), d| (sum + d, most.max(d)));
    (sum / bricks.len() as f32, most)
}

fn shoot(dt: f32, from: Vec3) -> Shot {
    let mut lab = Lab::shipped(dt);
    let scene: Scene = "wall:12x8".parse().unwrap();
    let bricks = scene.build(&mut lab.world, &SceneOptions::default()).bodies;
    lab.run(2.0);
    let start: Vec<Vec3> = bricks.iter().map(|&b| lab.position(b)).collect();
    let radius = (BALL / 1000.0 * 0.75 / PI).cbrt();
    let ball = lab.spawn((
        RigidBody::Dynamic,
        Collider::ball(radius),
        Friction::new(0.5),
        Transform::from_translation(from),
        Velocity {
            linear: SPEED * Vec3::Z,
            angular: Vec3::ZERO,
        },
    ));
    lab.run(0.2);
    let forward = |body: &Entity| lab.velocity(*body).linear.z;
    let momentum = bricks
        .iter()
        .map(|b| forward(b) / lab.mass(*b).inverse_mass);
    let (ball, momentum) = (forward(&ball), momentum.sum());
    let (soon, _) = distances(&lab, &bricks, &start);
    lab.run(2.8);
    let (moved, farthest) = distances(&lab, &bricks, &start);
    Shot {
        moved,
        farthest,
        soon,
        ball,
        momentum,
    }
}

/// Shoots from everywhere and adds a row to the table; returns the mean of how far bricks were moved, mm.
fn moved(dt: f32, table: &mut String) -> f32 {
    let shots = FROM.map(|from| shoot(dt, from));
    let mean = |of: fn(&Shot) -> f32| shots.iter().map(of).sum::<f32>() / shots.len() as f32;
    let range = |of: fn(&Shot) -> f32| {
        let all = shots.iter().map(of);
        let (least, most) = all.fold((f32::MAX, 0f32), |(a, b), x| (a.min(x), b.max(x)));
        format!("{:.1} ({least:.1}–{most:.1})", mean(of))
    };
    let row = format!(
        "| {dt:.5} | {} | {} | {} | {:.2} | {:.0} |",
        range(|shot| shot.moved),
        range(|shot| shot.farthest),
        range(|shot| shot.soon),
        mean(|shot| shot.ball),
        mean(|shot| shot.momentum),
    );
    println!("{row}");
    writeln!(table, "{row}").expect("strings grow");
    mean(|shot| shot.moved)
}

/// The mean over all bricks and shots, as the farthest brick of a single shot goes twice as far for a ball some centimetres beside.
fn main() -> Result<(), Box<dyn Error>> {
    let mut table = String::from(
        "| Δt, s | bricks moved, mm | the farthest, mm | at 0.2 s, mm | then the ball, m/s | and the wall, \
         N·s |\n|---|---|---|---|---|---|\n",
    );
    print!("{table}");
    let truth = moved(1.0 / 960.0, &mut table);
    let mut missed = Vec::new();
    for (dt, share) in [
        (1.0 / 240.0, 0.2),
        (1.0 / 60.0, 0.2),
        (1.0 / 30.0, 0.2),
        (0.1, 0.4),
    ] {
        let off = moved(dt, &mut table) / truth - 1.0;
        println!("{:+.0} %", 100.0 * off);
        if off.abs() > share {
            missed.push((dt, off));
        }
    }
    fs::create_dir_all("target")?;
    fs::write("target/shots.md", table)?;
    match missed.as_slice() {
        [] => Ok(()),
        missed => Err(format!("steps and how far off: {missed:?}").into()),
    }
}
