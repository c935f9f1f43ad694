//! Measures the cost of a hand: a wall alone, the wall with a brick held over it, and the wall with its top brick held.
//!
//! ```text
//! cargo run --release --example held -- [--scene wall:100x50] [--steps 60] [--threads 1]
//! ```
//!
//! The three worlds take their steps in turns, so that a busy machine delays all of them alike. Prints the median time of a step of each,
//! and how many times the wall's own it is.

use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use clap::Parser;
use drystone::body::{MassProperties, Pose, RigidBody};
use drystone::collider::Collider;
use drystone::grab::Grab;
use drystone::settings::{PhysicsThreads, Preset};
use drystone_lab::experiment::{Experiment, Run};
use drystone_lab::scenes::Scene;
use glam::Vec3;
use std::time::{Duration, Instant};

/// Measures what a hand costs.
#[derive(Parser)]
struct Arguments {
    /// The scene.
    #[arg(long, default_value = "wall:100x50")]
    scene: Scene,
    /// Steps of a sixtieth of a second that are timed.
    #[arg(long, default_value_t = 60, value_parser = clap::value_parser!(u32).range(1..))]
    steps: u32,
    /// Threads.
    #[arg(long, default_value_t = 1)]
    threads: usize,
}

/// Steps before a brick is held, and again before any step is timed.
const SETTLING: u32 = 30;

const DT: f32 = 1.0 / 60.0;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments = Arguments::parse();
    let mut experiment = Experiment::new(arguments.scene, Preset::Default);
    experiment.threads = PhysicsThreads::new(arguments.threads)?;
    experiment.sleeping.enabled = false;
    let mut runs = [Place::None, Place::Over, Place::On].map(|place| {
        let mut run = experiment.start();
        for step in 0..2 * SETTLING {
            if step == SETTLING {
                hold(&mut run, place);
            }
            drystone::step(&mut run.world, DT).expect("the step is positive");
        }
        (place, run, Vec::new())
    });
    for _ in 0..arguments.steps {
        for (_, run, times) in &mut runs {
            let start = Instant::now();
            drystone::step(&mut run.world, DT).expect("the step is positive");
            times.push(start.elapsed());
        }
    }
    let medians = runs.map(|(place, _, mut times)| {
        times.sort_unstable();
        (place, times[times.len() / 2])
    });
    let ms = |time: Duration| 1e3 * time.as_secs_f64();
    let (_, alone) = medians[0];
    for (place, median) in medians {
        let name = match place {
            Place::None => "by itself",
            Place::Over => "a brick held over it",
            Place::On => "its top brick held",
        };
        let times = ms(median) / ms(alone);
        println!(
            "{}, {name}: {:.3} ms, {times:.3}",
            arguments.scene,
            ms(median)
        );
    }
    Ok(())
}

/// Place of the brick that a hand holds.
#[derive(Clone, Copy)]
enum Place {
    /// Nothing.
    None,
    /// A brick of its own, 1 m over the highest.
    Over,
    /// The highest.
    On,
}

fn hold(run: &mut Run, place: Place) {
    let at = |body: Entity| run.world.get::<Pose>(body).map(|pose| pose.position);
    let bodies = run.bodies.iter().copied();
    let bodies = bodies.filter_map(|body| Some((body, at(body)?)));
    let middle = |at: Vec3| at.y - 1e-3 * at.x.abs();
    let Some((body, at)) = bodies.max_by(|a, b| middle(a.1).total_cmp(&middle(b.1))) else {
        return;
    };
    let mass = run.world.get(body).map_or(1.0, MassProperties::mass);
    match place {
        Place::None => (),
        Place::Over => {
            let over = at + Vec3::Y;
            run.world.spawn((
                RigidBody::Dynamic,
                Collider::cuboid(1.0, 0.5, 0.5),
                Transform::from_translation(over),
                Grab::gentle(mass, Vec3::ZERO, over),
            ));
        }
        Place::On => {
            let grab = Grab::gentle(mass, Vec3::ZERO, at);
            run.world.entity_mut(body).insert(grab);
        }
    }
}
