//! A step of scenes with joints once they have settled: a chain of 40 links with 100 kg, a bridge of 40 planks with 10 t, 20 ragdolls.
//!
//! ```text
//! cargo bench --bench joints
//! ```

use criterion::{Criterion, criterion_group, criterion_main};
use drystone::settings::Preset;
use drystone_lab::experiment::{Experiment, Run};
use drystone_lab::scenes::Scene;

const DT: f32 = 1.0 / 60.0;

/// Number of steps in which a scene settles.
const SETTLING: usize = 240;

/// A scene after it has settled, with sleeping off: a sleeping island costs nothing.
fn settled(scene: &str) -> Run {
    let scene: Scene = scene.parse().expect("it is a scene");
    let mut experiment = Experiment::new(scene, Preset::Default);
    experiment.dt = DT;
    experiment.sleeping.enabled = false;
    let mut run = experiment.start();
    for _ in 0..SETTLING {
        drystone::step(&mut run.world, DT).expect("the step is positive");
    }
    run
}

fn joints(c: &mut Criterion) {
    let mut group = c.benchmark_group("joints");
    group.sample_size(20);
    for scene in ["chain:40", "bridge:40", "ragdolls:20"] {
        let mut run = settled(scene);
        group.bench_function(scene, |b| {
            b.iter(|| drystone::step(&mut run.world, DT).expect("the step is positive"));
        });
    }
    group.finish();
}

criterion_group!(benches, joints);
criterion_main!(benches);
