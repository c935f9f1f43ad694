//! A step of scenes with joints once they have settled: a chain of 40 links with 100 kg, a bridge of 40 planks with 10 t, 20 ragdolls;
//! walls in mortar at rest, and while their last brick is pushed to and fro.
//!
//! ```text
//! cargo bench --bench joints
//! ```

use bevy_ecs::prelude::*;
use criterion::{Criterion, criterion_group, criterion_main};
use drystone::body::ExternalForce;
use drystone::prelude::*;
use drystone::settings::Preset;
use drystone_lab::experiment::{Experiment, Run};
use drystone_lab::scenes::Scene;
use glam::Vec3;

const DT: f32 = 1.0 / 60.0;

/// Number of steps in which a scene settles.
const SETTLING: usize = 240;

/// The walls in mortar, of 39 and 410 bricks.
const WALLS: [&str; 2] = ["wall:6x6", "wall:20x20"];

/// The force on the last brick of a wall, N, in steps that follow each other.
const PUSHES: [f32; 4] = [3e3, -1e3, 1e3, -3e3];

/// A scene after it has settled, with sleeping off: a sleeping island costs nothing.
fn settled(scene: &str, is_bonded: bool) -> Run {
    let scene: Scene = scene.parse().expect("it is a scene");
    let mut experiment = Experiment::new(scene, Preset::Default);
    experiment.dt = DT;
    experiment.sleeping.enabled = false;
    let mut run = experiment.start();
    if is_bonded {
        for brick in bricks(&mut run) {
            run.world.entity_mut(brick).insert(Mortar::new(1e7, 1e7));
        }
    }
    for _ in 0..SETTLING {
        drystone::step(&mut run.world, DT).expect("the step is positive");
    }
    run
}

fn bricks(run: &mut Run) -> Vec<Entity> {
    let mut bodies = run.world.query::<(Entity, &RigidBody)>();
    let bodies = bodies.iter(&run.world);
    let moving = bodies.filter(|(_, kind)| **kind == RigidBody::Dynamic);
    moving.map(|(body, _)| body).collect()
}

fn joints(c: &mut Criterion) {
    let mut group = c.benchmark_group("joints");
    group.sample_size(20);
    for scene in ["chain:40", "bridge:40", "ragdolls:20"] {
        let mut run = settled(scene, false);
        group.bench_function(scene, |b| {
            b.iter(|| drystone::step(&mut run.world, DT).expect("the step is positive"));
        });
    }
    group.finish();
}

fn mortar(c: &mut Criterion) {
    let mut group = c.benchmark_group("mortar");
    group.sample_size(20);
    for wall in WALLS {
        let mut run = settled(wall, true);
        group.bench_function(wall, |b| {
            b.iter(|| drystone::step(&mut run.world, DT).expect("the step is positive"));
        });
        let last = bricks(&mut run).pop();
        let last = last.expect("a wall has bricks");
        let mut pushes = PUSHES.into_iter().cycle();
        group.bench_function(format!("{wall}, pushed"), |b| {
            b.iter(|| {
                let force = ExternalForce {
                    force: Vec3::Z * pushes.next().unwrap_or_default(),
                    ..Default::default()
                };
                run.world.entity_mut(last).insert(force);
                drystone::step(&mut run.world, DT).expect("the step is positive");
            });
        });
    }
    group.finish();
}

criterion_group!(benches, joints, mortar);
criterion_main!(benches);
