//! A steady step allocates nothing, with the default solver on one thread. (Solvers of points make their blocks anew in every step.)

use crate::MEMORY;
use drystone::settings::{PhysicsThreads, Preset};
use drystone_lab::experiment::Experiment;
use stats_alloc::Region;

pub fn a_steady_step_allocates_nothing() {
    for (scene, sleeping) in [
        ("wall:10x10", false),
        ("wall:40x25", false),
        ("stack:20", false),
        ("arch:15", false),
        ("wall:10x10", true),
    ] {
        let mut experiment = Experiment::new(scene.parse().unwrap(), Preset::Default);
        experiment.sleeping.enabled = sleeping;
        experiment.threads = PhysicsThreads::new(1).unwrap();
        let mut run = experiment.start();
        for _ in 0..240 {
            run.step();
        }
        let region = Region::new(MEMORY);
        drystone::step(&mut run.world, 1.0 / 60.0).unwrap();
        let change = region.change();
        let count = change.allocations + change.reallocations;
        assert_eq!(count, 0, "{scene}, sleeping {sleeping}: {change:?}");
    }
}
