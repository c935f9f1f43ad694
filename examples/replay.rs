//! Replays a recording without a window: what to do with the file of a bug report.
//!
//! `cargo run --release -p drystone-tests --example replay -- crash.drystone --step 300 --threads 4`
//!
//! It says how many bodies there are, and which step and which body differs first from what was recorded, if one does. The world has all
//! plugins of drystone that simulate. A game with hooks of contacts or systems between the stages replays its recordings itself, as this
//! example does.
//!
//! `… -- --record wall.drystone --scene wall:10x10 --steps 600` makes a recording: of a player who lays bricks, takes them and throws
//! balls. `… -- --cost` measures what recording costs.

use bevy_app::App;
use bevy_ecs::prelude::*;
use clap::Parser;
use drystone::prelude::*;
use drystone::recording::{Recorder, RecorderSettings, Recording, RecordingError, Replay};
use drystone::settings::PhysicsThreads;
use drystone_lab::play::Player;
use drystone_lab::scenes::{Scene, SceneOptions};
use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::{Duration, Instant};

const DT: f32 = 1.0 / 60.0;

/// Replays a recording of drystone.
#[derive(Parser)]
struct Options {
    /// The recording to replay.
    #[arg(required_unless_present_any = ["record", "cost"])]
    file: Option<PathBuf>,
    /// Replay only so many steps.
    #[arg(long)]
    step: Option<usize>,
    /// Number of threads; all by default.
    #[arg(long, default_value_t = 0)]
    threads: usize,
    /// Make a recording instead.
    #[arg(long, conflicts_with = "file")]
    record: Option<PathBuf>,
    /// The scene that is recorded.
    #[arg(long, default_value = "wall:10x10")]
    scene: Scene,
    /// Number of steps that are recorded.
    #[arg(long, default_value_t = 600)]
    steps: usize,
    /// Measure what recording costs.
    #[arg(long)]
    cost: bool,
}

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let options = Options::parse();
    if options.cost {
        cost()?;
    } else if let Some(path) = &options.record {
        record(path, &options)?;
    } else if let Some(path) = &options.file {
        return replay(path, &options);
    }
    Ok(ExitCode::SUCCESS)
}

fn empty(threads: usize) -> Result<World, Box<dyn Error>> {
    let mut app = App::new();
    app.add_plugins((DrystonePlugins::default(), HandPlugin, CollapsePlugin));
    let mut world = std::mem::take(app.world_mut());
    world.insert_resource(PhysicsThreads::new(threads)?);
    Ok(world)
}

fn replay(path: &Path, options: &Options) -> Result<ExitCode, Box<dyn Error>> {
    let recording = Recording::read(path)?;
    let ends = match recording.is_whole() {
        true => "",
        false => "; the game ended in the middle",
    };
    println!(
        "{} steps, {} with changes from outside{ends}",
        recording.steps(),
        recording.changes().count()
    );
    let mut world = empty(options.threads)?;
    let mut replay = Replay::start(&recording, &mut world)?;
    let last = options.step.unwrap_or(recording.steps());
    let start = Instant::now();
    while replay.steps() < last && replay.step(&mut world)? {
        if replay.steps().is_multiple_of(60) {
            say(&mut world, replay.steps());
        }
    }
    let taken = start.elapsed();
    if !replay.steps().is_multiple_of(60) {
        say(&mut world, replay.steps());
    }
    let each = taken / replay.steps().max(1) as u32;
    println!(
        "{:.2} s, {} µs a step",
        taken.as_secs_f32(),
        each.as_micros()
    );
    match replay.divergence() {
        Some(divergence) => {
            println!("{divergence}");
            Ok(ExitCode::FAILURE)
        }
        None => {
            println!("all steps have the bits that were recorded");
            Ok(ExitCode::SUCCESS)
        }
    }
}

fn say(world: &mut World, step: usize) {
    let mut bodies = world.query::<(&RigidBody, &Sleeping)>();
    let bodies = bodies.iter(world);
    let (mut count, mut awake) = (0, 0);
    for (kind, sleeping) in bodies {
        count += 1;
        awake += usize::from(*kind == RigidBody::Dynamic && !sleeping.asleep);
    }
    println!("after step {step}: {count} bodies, {awake} awake");
}

/// The bricks in a course, and the courses, that the player plays at.
fn size(scene: Scene) -> [u32; 2] {
    match scene {
        Scene::Wall(columns, courses) => [columns, courses],
        _ => [4, 4],
    }
}

fn record(path: &Path, options: &Options) -> Result<(), Box<dyn Error>> {
    let mut world = empty(options.threads)?;
    options.scene.build(&mut world, &SceneOptions::default());
    let settings = RecorderSettings {
        path: Some(path.to_owned()),
        ..RecorderSettings::default()
    };
    Recorder::start(&mut world, settings)?;
    let mut player = Player::new(size(options.scene), 1);
    for step in 0..options.steps {
        if step % 30 == 29 {
            player.act(&mut world);
        }
        drystone::step(&mut world, DT)?;
    }
    Recorder::stop(&mut world)?;
    let bytes = std::fs::metadata(path)?.len();
    println!("{}: {} steps, {bytes} bytes", path.display(), options.steps);
    Ok(())
}

/// How often each case is run. Each step counts by its shortest time, because it does the same in each run.
const ROUNDS: usize = 7;

/// What is measured: its name, whether the wall sleeps, whether a player plays at it, and the number of steps.
const CASES: [(&str, bool, bool, usize); 4] = [
    ("asleep, left alone", true, false, 600),
    ("asleep, played at", true, true, 300),
    ("awake, left alone", false, false, 240),
    ("awake, played at", false, true, 240),
];

fn cost() -> Result<(), Box<dyn Error>> {
    println!(
        "| a wall of 1 012 bricks | a step, µs | recorded, µs | more | start, ms | bytes a step |\n|---|---|---|---|---|---|"
    );
    let path = std::env::temp_dir().join(format!("drystone-cost-{}", std::process::id()));
    for (name, sleeps, is_played, steps) in CASES {
        let mut times = [(); 2].map(|()| vec![Duration::MAX; steps]);
        let mut start = Duration::MAX;
        let mut bytes = [0; 2];
        for round in 0..2 * ROUNDS {
            // In turns, and in another order each time.
            let is_recorded = round % 4 == 1 || round % 4 == 2;
            let mut world = settled(sleeps)?;
            if is_recorded {
                let before = Instant::now();
                start_recording(&mut world, &path)?;
                start = start.min(before.elapsed());
                bytes[0] = std::fs::metadata(&path)?.len();
            }
            let mut player = Player::new([40, 25], 1);
            for (step, time) in times[usize::from(is_recorded)].iter_mut().enumerate() {
                let before = Instant::now();
                if is_played && step % 30 == 0 {
                    player.act(&mut world);
                }
                drystone::step(&mut world, DT)?;
                *time = before.elapsed().min(*time);
            }
            if is_recorded {
                Recorder::stop(&mut world)?;
                bytes[1] = std::fs::metadata(&path)?.len();
            }
        }
        let mean =
            |times: &[Duration]| 1e6 * times.iter().sum::<Duration>().as_secs_f64() / steps as f64;
        let [plain, recorded] = times.each_ref().map(|times| mean(times));
        println!(
            "| {name} | {plain:.1} | {recorded:.1} | {:.2} % | {:.1} | {} |",
            100.0 * (recorded / plain - 1.0),
            1e3 * start.as_secs_f64(),
            (bytes[1] - bytes[0]) / steps as u64,
        );
    }
    std::fs::remove_file(&path)?;
    Ok(())
}

fn start_recording(world: &mut World, path: &Path) -> Result<(), RecordingError> {
    let path = Some(path.to_owned());
    let settings = RecorderSettings {
        path,
        ..RecorderSettings::default()
    };
    Recorder::start(world, settings)
}

/// A wall at rest, on one thread.
fn settled(sleeps: bool) -> Result<World, Box<dyn Error>> {
    let mut world = empty(1)?;
    world.resource_mut::<SleepSettings>().enabled = sleeps;
    Scene::Wall(40, 25).build(&mut world, &SceneOptions::default());
    for _ in 0..180 {
        drystone::step(&mut world, DT)?;
    }
    Ok(world)
}
