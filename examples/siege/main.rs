//! A siege, played by a script: a castle of some 550 bricks, a trebuchet, a drawbridge on two ropes over a moat in which barrels float, a
//! hill in which holes are blown, a lift, a mortared keep, raiders, a zone that counts them, a guard that makes its rounds, repairs, undo,
//! and a game that is saved and loaded in the middle of it.
//!
//! `cargo run --release --example siege -- --help`
//!
//! It has no window, and lists every fault at the end. The game is in components, resources and functions:
//! `examples/builder/examples/siege` shows the same in a window.

mod castle;
mod drawbridge;
mod game;
mod guard;
mod hill;
mod keeper;
mod lift;
mod moat;
#[cfg(feature = "ui")]
mod panel;
mod raiders;
mod run;
mod save;
mod trebuchet;

use clap::Parser;
use run::Game;

/// A siege, played by a script.
#[derive(Parser)]
struct Arguments {
    /// How long it is played, s.
    #[arg(long, default_value_t = 300.0)]
    seconds: f32,
    /// Steps a second.
    #[arg(long, default_value_t = 60.0)]
    rate: f32,
}

fn main() {
    let arguments = Arguments::parse();
    let mut game = Game::new(1.0 / arguments.rate);
    let steps = (arguments.seconds * arguments.rate) as u32;
    for step in 0..steps {
        if step == steps / 2 {
            game = game.saved_and_loaded();
        }
        game.step();
    }
    println!("{}", game.report());
    if !game.faults.is_empty() {
        std::process::exit(1);
    }
}
