//! What snapshots cost: to take, to restore, and to go back eight frames as a client does that predicts; and their size as bytes.
//!
//! `cargo run --release -p drystone-tests --example snapshots -- [--threads 1]`

use clap::Parser;
use drystone::settings::{PhysicsThreads, Preset};
use drystone::snapshot::Snapshot;
use drystone_lab::experiment::{Experiment, Run};
use drystone_lab::scenes::Scene;
use std::time::{Duration, Instant};

/// Scene, whether its bodies sleep, and the steps before the first snapshot.
const SCENES: [(&str, bool, usize); 3] = [
    ("wall:40x25", false, 60),
    ("wall:40x25", true, 300),
    ("heap:1000", false, 60),
];

/// Number of measurements, of which the median counts.
const TIMES: usize = 31;

/// Frames that are taken back and simulated again.
const FRAMES: usize = 8;

/// Measures snapshots.
#[derive(Parser)]
struct Arguments {
    /// Threads.
    #[arg(long, default_value_t = 1)]
    threads: usize,
}

fn main() {
    let arguments = Arguments::parse();
    println!(
        "| scene | bodies | a step, ms | take, ms | take into an old one, ms | restore the last step, ms | restore {FRAMES} steps and \
         take them again, ms | bytes a body | of the difference a step makes | written, ms |\n|---|---|---|---|---|---|---|---|---|---|"
    );
    for (name, sleeping, steps) in SCENES {
        let scene: Scene = name.parse().expect("the name of a scene");
        let mut experiment = Experiment::new(scene, Preset::Default);
        experiment.sleeping.enabled = sleeping;
        experiment.threads = PhysicsThreads::new(arguments.threads).expect("they are to be had");
        let mut run = experiment.start();
        for _ in 0..steps {
            run.step();
        }
        row(name, sleeping, &mut run);
    }
}

fn row(name: &str, sleeping: bool, run: &mut Run) {
    let mut times: [Vec<Duration>; 5] = Default::default();
    let mut kept = Snapshot::take(&run.world);
    for _ in 0..TIMES {
        times[0].push(time(|| _ = run.step()));
        times[1].push(time(|| drop(Snapshot::take(&run.world))));
        times[2].push(time(|| kept.take_into(&run.world)));
        run.step();
        times[3].push(time(|| restore(&kept, run)));
        for _ in 0..FRAMES {
            run.step();
        }
        times[4].push(time(|| {
            restore(&kept, run);
            for _ in 0..FRAMES {
                run.step();
            }
        }));
    }
    let bodies = run.bodies.len();
    restore(&kept, run);
    run.step();
    let next = Snapshot::take(&run.world);
    let difference = next.to_bytes_after(&kept);
    let [bytes, difference] = [kept.to_bytes(), difference]
        .map(|bytes| bytes.expect("it holds no code").len() as f64 / bodies as f64);
    let write = time(|| drop(next.to_bytes_after(&kept)));
    let [step, take, again, back, frames] = times.map(median);
    let rest = if sleeping { "asleep" } else { "awake" };
    println!(
        "| `{name}`, {rest} | {bodies} | {step:.3} | {take:.3} | {again:.3} | {back:.3} | {frames:.2} | {bytes:.0} | {difference:.0} | \
         {:.1} |",
        1e3 * write.as_secs_f64()
    );
}

fn restore(snapshot: &Snapshot, run: &mut Run) {
    let renamed = snapshot.restore(&mut run.world);
    assert!(
        renamed
            .expect("it is of this world")
            .keys()
            .all(|entity| !run.bodies.contains(entity)),
        "no body was despawned"
    );
}

fn time(work: impl FnOnce()) -> Duration {
    let start = Instant::now();
    work();
    start.elapsed()
}

/// ms
fn median(mut times: Vec<Duration>) -> f64 {
    times.sort_unstable();
    1e3 * times[times.len() / 2].as_secs_f64()
}
