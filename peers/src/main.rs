//! Drystone beside other engines: the same scenes, each engine at its default settings, in the same run.
//!
//! ```text
//! cargo run --release --package drystone-peers -- --scene wall:40x25 --scene stack:20 --steps 600
//! ```

#![deny(unsafe_code)]

mod arguments;
mod body;
#[cfg(feature = "box3d")]
mod box3d;
mod busy;
mod compare;
mod engine;
mod joint;
mod meter;
mod own;
mod peer;
mod play;
mod rapier;
mod report;
mod rocking;
mod run;
mod scene;
mod table;
#[cfg(test)]
mod tests;

use arguments::{Arguments, Command};
use clap::Parser;
use std::io::Write;
use std::process::ExitCode;

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let done = match &arguments.command {
        Some(Command::Table(table)) => table.make(),
        Some(Command::Busy(busy)) => busy.make(),
        Some(Command::Play(play)) => play.print(),
        Some(Command::Rocking(rocking)) => rocking.draw(),
        None => scenes(&arguments),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::from(2)
        }
    }
}

fn scenes(arguments: &Arguments) -> Result<(), String> {
    let mut out = std::io::stdout().lock();
    for &scene in &arguments.scene {
        for &seed in &arguments.seeds {
            let comparison = compare::compare(scene, seed, &arguments.run)?;
            let written = if arguments.json {
                writeln!(out, "{}", comparison.json())
            } else {
                writeln!(out, "{comparison}")
            };
            if written.is_err() {
                // The reader of the output has closed it.
                return Ok(());
            }
        }
    }
    Ok(())
}
