//! Prints a hash of thirty simulations: ten scenes, each with three solvers, over both presets and at 60 and 10 Hz.
//!
//! A change that only moves code must leave every line as it is. Write the lines to a file before the change and compare after it:
//!
//! ```text
//! cargo run --release --example hashes > before.txt
//! cargo run --release --example hashes | diff before.txt -
//! ```
//!
//! A hash covers the bits of the pose and velocity of every body after every step. With `--islands` sleeping bodies wake by whole islands.

use drystone::settings::{ContactSolver, Preset, SleepSettings, Waking};
use drystone::solver::{Nncg, Pgs, SoftStep};
use drystone_lab::experiment::Experiment;
use drystone_lab::hashes::hash;
use drystone_lab::scenes::Scene;

/// Scene and length of the simulation in steps.
const SCENES: [(&str, usize); 10] = [
    ("wall:8x6", 240),
    ("stack:10", 240),
    ("pyramid:8", 180),
    ("arch:15", 180),
    ("heap:60", 240),
    ("pile:hulls:40", 180),
    ("dominoes:12", 240),
    ("cardhouse:3", 180),
    ("dropped", 240),
    ("pressed:5", 300),
];

/// Step length in seconds.
const RATES: [f32; 2] = [1.0 / 60.0, 0.1];

fn solvers() -> [(&'static str, ContactSolver); 3] {
    [
        ("soft-step", SoftStep::default().into()),
        ("pgs", Pgs::default().into()),
        ("nncg", Nncg::default().into()),
    ]
}

fn main() {
    let islands = std::env::args().any(|argument| argument == "--islands");
    for (i, (name, steps)) in SCENES.into_iter().enumerate() {
        let scene: Scene = name.parse().expect("the name of a scene");
        for (j, (solver_name, solver)) in solvers().into_iter().enumerate() {
            // Each solver meets each preset at each rate.
            let (preset, preset_name) = match (i + j) % 2 {
                0 => (Preset::Default, "default"),
                _ => (Preset::Paper, "paper"),
            };
            let dt = RATES[(i / 2 + j) % 2];
            let mut experiment = Experiment::new(scene, preset);
            experiment.dt = dt;
            experiment.solver.solver = solver;
            let mut run = experiment.start();
            if islands {
                run.world.resource_mut::<SleepSettings>().waking = Waking::Islands;
            }
            let hash = hash(&mut run, steps);
            let rate = 1.0 / dt;
            println!("{name:14} {solver_name:9} {preset_name:8} {rate:2.0} Hz {hash:016x}");
        }
    }
}
