//! The bits of ten simulations with the feature `enhanced-determinism`, compared with those in `pinned.txt`: they must be the same on every
//! processor, at every level of optimization, and on any number of threads.
//!
//! ```text
//! cargo test -p drystone-tests --test pinned --features enhanced-determinism
//! ```
//!
//! A change of the method changes them. The failing test prints the new ones.

use drystone::settings::{PhysicsThreads, Preset};
use drystone_lab::experiment::Experiment;
use drystone_lab::hashes::hash;
use drystone_lab::scenes::Scene;

/// Scene, number of steps, and steps a second. Small ones, since unoptimized code runs them too.
const SCENES: [(&str, usize, f32); 10] = [
    ("wall:5x4", 60, 60.0),
    ("stack:5", 60, 10.0),
    ("pyramid:4", 60, 60.0),
    ("arch:9", 60, 60.0),
    ("heap:20", 90, 60.0),
    ("pile:hulls:10", 90, 60.0),
    ("dominoes:6", 60, 60.0),
    ("cardhouse:2", 60, 60.0),
    ("bridge:6", 60, 60.0),
    ("ragdolls:2", 60, 60.0),
];

fn lines(threads: usize) -> String {
    let mut text = String::new();
    for (name, steps, rate) in SCENES {
        let scene: Scene = name.parse().expect("the name of a scene");
        let mut experiment = Experiment::new(scene, Preset::Default);
        experiment.dt = 1.0 / rate;
        experiment.options.noise_position = 0.002;
        experiment.options.noise_angle = 0.01;
        let threads = PhysicsThreads::new(threads).expect("threads are to be had");
        // Everything that can be divided among threads is, however small.
        experiment.threads = threads.with_min_items(1);
        let hash = hash(&mut experiment.start(), steps);
        text += &format!("{name:14} {rate:2.0} Hz {hash:016x}\n");
    }
    text
}

#[test]
fn ten_scenes_give_the_same_bits_on_every_processor() {
    let now = lines(1);
    assert_eq!(now, lines(3), "threads matter");
    let pinned = include_str!("pinned.txt");
    assert_eq!(now, pinned, "the bits are others now:\n{now}");
}
