//! Structures on a shaking table: which fall, and how far others are off afterwards, beside the same at 1/1920 s.
//!
//! ```text
//! cargo run --release --example shake -- [--quick]
//! ```

use clap::Parser;
use drystone_lab::quake::{Quake, Structure};
use std::process::ExitCode;

/// Shakes a wall, an arch, a column of drums and a small house.
#[derive(Parser)]
struct Arguments {
    /// No steps of 1/1920 s: ends within a minute.
    #[arg(long)]
    quick: bool,
    /// Largest accelerations of the table, in units of that of free fall.
    #[arg(long, value_delimiter = ',', default_value = "0.1,0.2,0.3,0.4,0.5")]
    accelerations: Vec<f64>,
}

const STEPS: [(&str, f32); 3] = [
    ("1/60 s", 1.0 / 60.0),
    ("1/240 s", 1.0 / 240.0),
    ("1/1920 s", 1.0 / 1920.0),
];

fn main() -> ExitCode {
    let Arguments {
        quick,
        accelerations,
    } = Arguments::parse();
    let steps = if quick { &STEPS[..2] } else { &STEPS };
    let names: Vec<&str> = steps.iter().map(|(name, _)| *name).collect();
    println!(
        "| structure | table | largest acceleration, g | {} |",
        names.join(" | ")
    );
    println!("|---|---|---|{}", "---|".repeat(steps.len()));
    for structure in Structure::ALL {
        for quake in Quake::ALL {
            for &g in &accelerations {
                let mut cells = Vec::new();
                for (_, dt) in steps {
                    match structure.shake(quake, 9.81 * g, *dt) {
                        Ok(shaken) if shaken.fallen == 0 => {
                            cells.push(format!("{:.1} mm", 1e3 * shaken.offset));
                        }
                        Ok(shaken) => cells.push(format!("{} fall", shaken.fallen)),
                        Err(error) => {
                            eprintln!("{}: {error}", structure.name());
                            return ExitCode::FAILURE;
                        }
                    }
                }
                let cells = cells.join(" | ");
                println!(
                    "| {} | {} | {g} | {cells} |",
                    structure.name(),
                    quake.name()
                );
            }
        }
    }
    ExitCode::SUCCESS
}
