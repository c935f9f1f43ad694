//! Drystone beside Rapier: the same scenes, each engine at its default settings, in the same run.
//!
//! ```text
//! cargo run --release --manifest-path peers/Cargo.toml -- --scene wall:40x25 --scene stack:20 --steps 600
//! ```

mod compare;
mod engine;
mod meter;
mod overlap;
mod own;
mod rapier;
mod report;
mod scene;

use clap::Parser;
use drystone_lab::scenes::{KNOWN, Scene};
use std::io::Write;
use std::process::ExitCode;

/// Simulates scenes in drystone and in Rapier and prints what became of them.
#[derive(Parser)]
#[command(after_help = format!("Scenes: {KNOWN}; not those with a hand (pressed:N)."))]
struct Arguments {
    /// What to simulate; may be given several times.
    #[arg(long, required = true)]
    scene: Vec<Scene>,
    /// How many steps.
    #[arg(long, default_value_t = 600, value_parser = count)]
    steps: usize,
    /// Steps that an engine takes before it is the other's turn.
    #[arg(long, default_value_t = 30, value_parser = count)]
    turn: usize,
    /// Length of a step, s.
    #[arg(long, default_value_t = 1.0 / 60.0, value_parser = length)]
    dt: f32,
    /// Seeds of what a scene has at random, one comparison each.
    #[arg(long, value_delimiter = ',', default_value = "1")]
    seeds: Vec<u64>,
    /// Threads of each engine; more than one with the feature `parallel`.
    #[arg(long, default_value_t = 1, value_parser = threads)]
    threads: usize,
    /// Rapier's num_solver_iterations; its default if not given.
    #[arg(long, value_parser = count)]
    rapier_iterations: Option<usize>,
    /// What Rapier gets for a half-space.
    #[arg(long, value_enum, default_value = "slab")]
    rapier_ground: rapier::Ground,
    /// One JSON object a line instead of tables.
    #[arg(long)]
    json: bool,
}

fn count(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(n) if n > 0 => Ok(n),
        _ => Err("must be a whole number above 0".into()),
    }
}

fn length(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(dt) if (1e-6..=1.0).contains(&dt) => Ok(dt),
        _ => Err("must be a number from 0.000001 to 1".into()),
    }
}

fn threads(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(n) if (1..=256).contains(&n) => Ok(n),
        _ => Err("must be a whole number from 1 to 256".into()),
    }
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let conditions = scene::Conditions {
        dt: arguments.dt,
        threads: arguments.threads,
    };
    let course = compare::Course {
        steps: arguments.steps,
        turn: arguments.turn,
    };
    let options = rapier::Options {
        iterations: arguments.rapier_iterations,
        ground: arguments.rapier_ground,
    };
    let mut out = std::io::stdout().lock();
    for &scene in &arguments.scene {
        for &seed in &arguments.seeds {
            let comparison = match compare::compare(scene, seed, course, conditions, options) {
                Ok(comparison) => comparison,
                Err(error) => {
                    eprintln!("{error}");
                    return ExitCode::from(2);
                }
            };
            let written = if arguments.json {
                writeln!(out, "{}", comparison.json())
            } else {
                writeln!(out, "{comparison}")
            };
            if written.is_err() {
                // Whoever read us has gone.
                return ExitCode::SUCCESS;
            }
        }
    }
    ExitCode::SUCCESS
}
