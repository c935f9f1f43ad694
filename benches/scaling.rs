//! How a step scales: over bodies, and over threads.
//!
//! ```text
//! cargo bench --bench scaling
//! ```

use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use drystone::prelude::*;
use drystone::settings::{PhysicsThreads, Preset};
use drystone_lab::experiment::{Experiment, Run};
use drystone_lab::scenes::Scene;
use std::time::Duration;

const DT: f32 = 1.0 / 60.0;

/// A scene after a second, nothing asleep.
fn started(scene: Scene, threads: usize) -> Run {
    let mut experiment = Experiment::new(scene, Preset::Default);
    experiment.threads = PhysicsThreads::new(threads).expect("threads can be had");
    experiment.sleeping.enabled = false;
    let mut run = experiment.start();
    for _ in 0..60 {
        run.step();
    }
    run
}

/// 1, 2, 4 … as many as the machine has.
fn threads() -> impl Iterator<Item = usize> {
    let most = std::thread::available_parallelism().map_or(1, usize::from);
    std::iter::successors(Some(1), |n| Some(2 * n)).take_while(move |n| *n <= most)
}

fn walls(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("a wall, a step");
    group
        .sample_size(10)
        .measurement_time(Duration::from_secs(2));
    for (width, courses) in [(10, 10), (20, 15), (40, 25), (100, 50)] {
        for threads in threads() {
            let mut run = started(Scene::Wall(width, courses), threads);
            let name = BenchmarkId::new(format!("{width}x{courses}"), threads);
            group.throughput(Throughput::Elements((width * courses) as u64));
            group.bench_function(name, |bencher| {
                bencher.iter(|| drystone::step(&mut run.world, DT));
            });
        }
    }
    group.finish();
}

/// So many pyramids by so many, of cubes, on a base of ten.
fn pyramids(world: &mut World, side: u32) {
    const BASE: u32 = 10;
    let collider = Collider::cuboid(1.0, 1.0, 1.0);
    for (row, column) in (0..side).flat_map(|row| (0..side).map(move |column| (row, column))) {
        for course in 0..BASE {
            for i in 0..BASE - course {
                let x = i as f32 + 0.5 * course as f32 + (BASE + 2) as f32 * column as f32;
                let at = Vec3::new(x, course as f32 + 0.5, 3.0 * row as f32);
                world.spawn((
                    RigidBody::Dynamic,
                    collider.clone(),
                    Transform::from_translation(at),
                ));
            }
        }
    }
}

fn islands(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("14 x 14 pyramids of base 10, a step");
    group
        .sample_size(10)
        .measurement_time(Duration::from_secs(4));
    for threads in threads() {
        let mut run = started(Scene::Sliding, threads);
        pyramids(&mut run.world, 14);
        for _ in 0..30 {
            run.step();
        }
        group.bench_function(BenchmarkId::from_parameter(threads), |bencher| {
            bencher.iter(|| drystone::step(&mut run.world, DT));
        });
    }
    group.finish();
}

criterion_group!(benches, walls, islands);
criterion_main!(benches);
