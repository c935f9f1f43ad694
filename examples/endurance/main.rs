//! Long simulations: whether memory and time stay flat, whether what stands stays where it is, and how far from the origin it does.
//!
//! ```text
//! cargo run --release --example endurance -- building [--minutes 60]
//! cargo run --release --example endurance -- town [--hours 24] [--walls 100]
//! cargo run --release --example endurance -- far
//! ```
//!
//! `building` builds and breaks small walls: a million bricks are spawned and despawned in an hour. `town` lets a town of 100 000 bricks
//! stand for a day, in which a player comes to one of its walls once an hour. Both end with an error if memory or time grew, or if
//! something moved that nobody touched. `far` builds the same wall farther and farther from the origin.

mod building;
mod far;
mod flat;
mod town;

use clap::{Parser, Subcommand};
use std::error::Error;
use std::process::ExitCode;

/// Long simulations.
#[derive(Parser)]
struct Arguments {
    #[command(subcommand)]
    what: What,
}

#[derive(Subcommand)]
enum What {
    /// Builds and breaks small walls.
    Building {
        /// Simulated time, min.
        #[arg(long, default_value_t = 60.0)]
        minutes: f32,
    },
    /// Lets a town stand.
    Town {
        /// Simulated time, h.
        #[arg(long, default_value_t = 24.0)]
        hours: f32,
        /// Number of walls, of 1 012 bricks each.
        #[arg(long, default_value_t = 100)]
        walls: u32,
    },
    /// Builds far from the origin.
    Far,
}

/// Length of a step, s.
const DT: f32 = 1.0 / 60.0;

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    match arguments.what {
        What::Building { minutes } => building::run(minutes),
        What::Town { hours, walls } => town::run(hours, walls),
        What::Far => far::run(),
    }
}
