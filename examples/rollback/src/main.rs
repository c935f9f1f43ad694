//! Two players build and shoot one wall over a bad connection. See `README.md`.

use clap::Parser;
use drystone_rollback::duel::Duel;
use drystone_rollback::game::{Setup, WallGame};
use drystone_rollback::input::Input;
use drystone_rollback::link::Conditions;
use drystone_rollback::report::{HEAD, Times};
use drystone_rollback::script::Script;
use drystone_rollback::sync_test::sync_test;
use ggrs::{Frame, GgrsError};
use std::error::Error;
use std::process::ExitCode;
use std::time::Duration;

/// Two players build and shoot one wall of 1 012 bricks over a bad connection, with rollback. Fails if their worlds differ.
#[derive(Parser)]
struct Arguments {
    /// Rolls one game back by 8 frames in every frame instead, at rest and played on, and prints how long that takes.
    #[arg(long)]
    sync_test: bool,
    /// How long is played, s of simulated time.
    #[arg(long, default_value_t = 20.0)]
    seconds: f32,
    /// Decides what the players do, and which packets are lost.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Delay of every packet, one way, ms.
    #[arg(long, default_value_t = 100)]
    delay: u64,
    /// The most that a packet takes longer, ms.
    #[arg(long, default_value_t = 20)]
    jitter: u64,
    /// Radius of the balls, m. They fly at 20 m/s, and weigh 4 kg at 0.1 m, 113 kg at 0.3 m.
    #[arg(long, default_value_t = 0.1)]
    ball: f32,
    /// Share of packets that are lost, 0 to 1.
    #[arg(long, default_value_t = 0.05)]
    loss: f32,
}

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let arguments = Arguments::parse();
    let frames = (60.0 * arguments.seconds).round() as Frame;
    let is_in_sync = match arguments.sync_test {
        true => test(frames, &arguments)?,
        false => play(frames, &arguments)?,
    };
    Ok(match is_in_sync {
        true => ExitCode::SUCCESS,
        false => ExitCode::FAILURE,
    })
}

fn play(frames: Frame, arguments: &Arguments) -> Result<bool, Box<dyn Error>> {
    let duel = Duel {
        frames,
        conditions: Conditions {
            delay: Duration::from_millis(arguments.delay),
            jitter: Duration::from_millis(arguments.jitter),
            loss: arguments.loss,
        },
        seed: arguments.seed,
    };
    let game = || WallGame::new(setup(arguments));
    let outcome = duel.play([game(), game()], game())?;
    println!("{outcome}");
    Ok(outcome.is_in_sync())
}

fn setup(arguments: &Arguments) -> Setup {
    Setup {
        ball: arguments.ball,
        ..Setup::default()
    }
}

fn test(frames: Frame, arguments: &Arguments) -> Result<bool, Box<dyn Error>> {
    let script = Script {
        seed: arguments.seed,
        delay: 0,
    };
    let asleep = setup(arguments);
    let awake = Setup {
        sleeping: false,
        ..asleep
    };
    println!("{HEAD}");
    for (name, setup, is_played) in [
        ("nobody plays, asleep", asleep, false),
        ("nobody plays, awake", awake, false),
        ("played on", asleep, true),
        ("played on, awake", awake, true),
    ] {
        let inputs = |frame| match is_played {
            true => script.inputs(frame),
            false => [Input::default(); 2],
        };
        match sync_test(WallGame::new(setup), frames, inputs) {
            Ok(mut driver) => {
                let [awake, all] = driver.game.awake();
                let times = Times::of(&driver.rollbacks);
                println!("| {name}: {awake} of {all} awake at the end | {times} |");
            }
            Err(error @ GgrsError::MismatchedChecksum { .. }) => {
                println!("\nDESYNC: {name}: {error}");
                return Ok(false);
            }
            Err(error) => return Err(error.into()),
        }
    }
    println!("\nin sync: all frames ended with the same checksum each time");
    Ok(true)
}
