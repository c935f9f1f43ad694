//! A steady step allocates nothing. (NNCG keeps two lists of its own a solve.)

use drystone::settings::{ContactSolver, PhysicsThreads, Preset};
use drystone::solver::{Pgs, SoftStep};
use drystone_lab::experiment::Experiment;
use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};
use std::alloc::System;

#[global_allocator]
static MEMORY: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

/// One test, since the allocator counts for all threads.
#[test]
fn a_steady_step_allocates_nothing() {
    let presets: [(&str, fn() -> ContactSolver); 2] = [
        ("Soft Step", || ContactSolver::SoftStep(SoftStep::default())),
        ("PGS", || ContactSolver::Pgs(Pgs::default())),
    ];
    for (name, solver) in presets {
        for (scene, sleeping) in [
            ("wall:10x10", false),
            ("stack:20", false),
            ("wall:10x10", true),
        ] {
            let mut experiment = Experiment::new(scene.parse().unwrap(), Preset::Default);
            experiment.solver.solver = solver();
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
            println!("{name}, {scene}, sleeping {sleeping}: {count} allocations");
            assert_eq!(count, 0, "{name}, {scene}, sleeping {sleeping}: {change:?}");
        }
    }
}
