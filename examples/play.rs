//! The cost of playing on a wall that sleeps: every half second a brick is laid on it, a ball of 4 kg is thrown at it, a brick is laid, and
//! one is taken. Everything is at its defaults, on one thread.
//!
//! ```text
//! cargo run --release --example play -- [--scene wall:40x25] [--seconds 15] [--wreck | --touch] [--islands]
//! ```
//!
//! At a scene that is not a wall (`heap:300`), balls are thrown while it falls together. `--wreck` throws a ball of 524 kg at 20 m/s into
//! the middle of a wall. Prints the mean, the 99th percentile and the longest of the steps, and the mean number of bodies awake. `peers/`
//! does the same in Rapier.

use clap::Parser;
use drystone::settings::{PhysicsThreads, Preset, SleepSettings, Waking};
use drystone_lab::experiment::Experiment;
use drystone_lab::play::{Cost, Script, Session, Touch, touches};
use drystone_lab::scenes::Scene;

/// Measures what playing costs.
#[derive(Parser)]
struct Arguments {
    /// The scene.
    #[arg(long, default_value = "wall:40x25")]
    scene: Scene,
    /// How long to play, s.
    #[arg(long, default_value_t = 15.0)]
    seconds: f32,
    /// A heavy ball flies into the wall.
    #[arg(long)]
    wreck: bool,
    /// Measures single deeds instead: the step in which a brick of a wall is pushed by 1 mN·s, laid or taken, and the next.
    #[arg(long)]
    touch: bool,
    /// Sleeping bodies wake by whole islands.
    #[arg(long)]
    islands: bool,
    /// Seed of where the player lays and throws.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Threads.
    #[arg(long, default_value_t = 1)]
    threads: usize,
}

const DT: f32 = 1.0 / 60.0;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments = Arguments::parse();
    let script = Script::of(arguments.scene, arguments.wreck)?;
    let mut experiment = Experiment::new(arguments.scene, Preset::Default);
    experiment.threads = PhysicsThreads::new(arguments.threads)?;
    let mut run = experiment.start();
    if arguments.islands {
        run.world.resource_mut::<SleepSettings>().waking = Waking::Islands;
    }
    if arguments.touch {
        let Script::Build([_, courses]) = script else {
            return Err("bricks are laid on walls only".into());
        };
        for _ in 0..300 {
            run.step();
        }
        println!("{}", Touch::HEAD);
        for touch in touches(&mut run.world, &run.bodies, 0.5 * courses as f32, DT) {
            println!("{touch}");
        }
        return Ok(());
    }
    let world = run.world;
    let mut session = Session::new(world, script, arguments.seed, DT);
    session.settle();
    session.steps((arguments.seconds / DT).round() as usize);
    println!("{}\n| drystone | {}", Cost::HEAD, session.cost());
    Ok(())
}
