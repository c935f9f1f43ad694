//! A steady step allocates nothing, with the default solver on one thread, whatever the number of islands. (Solvers of points make their
//! blocks anew in every step, and so do islands of three contacts and fewer, which are solved together.)

use crate::MEMORY;
use bevy_ecs::prelude::*;
use drystone::collider::Collider;
use drystone::graph::Islands;
use drystone::settings::{PhysicsThreads, Preset, SleepSettings};
use drystone_lab::experiment::Experiment;
use glam::Vec3;
use stats_alloc::Region;
use support::*;

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
        assert_nothing_is_allocated(&mut run.world, &format!("{scene}, sleeping {sleeping}"));
    }
    many_islands();
}

fn assert_nothing_is_allocated(world: &mut World, what: &str) {
    let region = Region::new(MEMORY);
    drystone::step(world, 1.0 / 60.0).unwrap();
    let change = region.change();
    let count = change.allocations + change.reallocations;
    assert_eq!(count, 0, "{what}: {change:?}");
}

/// Stacks of every height from 4 on, and walls, all awake.
fn many_islands() {
    let mut lab = Lab::new();
    lab.world.insert_resource(PhysicsThreads::new(1).unwrap());
    lab.world.resource_mut::<SleepSettings>().enabled = false;
    lab.ground();
    for (x, z) in (0..6).flat_map(|x| (0..6).map(move |z| (x, z))) {
        let width = if z % 2 == 0 { 1 } else { 4 };
        for (column, course) in (0..width).flat_map(|i| (0..4 + x).map(move |j| (i, j))) {
            let shift = if width > 1 {
                0.5 * (course % 2) as f32
            } else {
                0.0
            };
            let at = Vec3::new(
                8.0 * x as f32 + column as f32 + shift,
                0.25 + 0.5 * course as f32,
                3.0 * z as f32,
            );
            lab.body(Collider::cuboid(1.0, 0.5, 0.5), at);
        }
    }
    for _ in 0..240 {
        drystone::step(&mut lab.world, 1.0 / 60.0).unwrap();
    }
    assert!(lab.world.resource::<Islands>().count() == 36);
    assert_nothing_is_allocated(&mut lab.world, "many islands");
}
