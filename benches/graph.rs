//! The time that one contact that begins or ends takes in the constraint graph of a wall of 10 000 bricks, compared with a step without changes.
//!
//! ```text
//! cargo bench --bench graph
//! ```
//!
//! The contact is one of the wall's own: a system between *narrowphase* and *islands* takes the points out of its manifold and puts them
//! back. The stage *islands* is timed inside whole steps, by drystone's own [`Profile`].

use criterion::{Criterion, criterion_group, criterion_main};
use drystone::contact::{ContactPoint, Manifold};
use drystone::prelude::*;
use drystone::settings::{PhysicsThreads, Preset};
use drystone_lab::experiment::{Experiment, Run};
use drystone_lab::scenes::Scene;
use std::time::Duration;

use bevy_ecs::prelude::*;

const DT: f32 = 1.0 / 60.0;

/// The pair whose contact begins and ends, and its points while it has none.
#[derive(Resource)]
struct Toggled {
    pair: Entity,
    points: Vec<ContactPoint>,
    /// Whether it is to have its points in the next step.
    touches: bool,
}

fn toggle(mut toggled: ResMut<Toggled>, mut manifolds: Query<&mut Manifold>) {
    let Ok(mut manifold) = manifolds.get_mut(toggled.pair) else {
        return;
    };
    match toggled.touches {
        true if manifold.points.is_empty() => manifold.points.extend(toggled.points.drain(..)),
        false if !manifold.points.is_empty() => {
            toggled.points = manifold.points.drain(..).collect();
        }
        _ => (),
    }
}

/// A wall of 10 000 bricks that has come to rest; one thread, nothing asleep.
fn resting_wall() -> Run {
    let mut experiment = Experiment::new(Scene::Wall(100, 99), Preset::Default);
    experiment.threads = PhysicsThreads::new(1).expect("one thread can be had");
    experiment.sleeping.enabled = false;
    let mut run = experiment.start();
    for _ in 0..10 {
        run.step();
    }
    let world = &mut run.world;
    let mut bodies = world.query::<(Entity, &Pose)>();
    let highest = bodies
        .iter(world)
        .max_by(|(_, a), (_, b)| a.position.y.total_cmp(&b.position.y));
    let highest = highest.expect("the wall has bricks").0;
    let mut pairs = world.query::<(Entity, &ContactPair, &Manifold)>();
    let of_it = pairs
        .iter(world)
        .find(|(_, pair, manifold)| pair.bodies.contains(&highest) && !manifold.points.is_empty());
    let pair = of_it.expect("it lies on others").0;
    world.insert_resource(Toggled {
        pair,
        points: Vec::new(),
        touches: true,
    });
    let mut schedules = world.resource_mut::<Schedules>();
    schedules.add_systems(
        PhysicsSchedule,
        toggle
            .after(PhysicsSystems::Narrowphase)
            .before(PhysicsSystems::Islands),
    );
    run
}

fn islands(run: &mut Run) -> Duration {
    drystone::step(&mut run.world, DT).expect("the step is positive");
    let profile = run.world.resource::<Profile>();
    profile.system("islands").unwrap_or_default()
}

fn graph(criterion: &mut Criterion) {
    let mut run = resting_wall();
    let mut group = criterion.benchmark_group("wall of 10 000, stage islands");
    group
        .sample_size(10)
        .warm_up_time(Duration::from_millis(100))
        .measurement_time(Duration::from_secs(1));
    group.bench_function("nothing changes", |bencher| {
        bencher.iter_custom(|iterations| (0..iterations).map(|_| islands(&mut run)).sum());
    });
    for (name, touches) in [("a contact begins", true), ("a contact ends", false)] {
        group.bench_function(name, |bencher| {
            bencher.iter_custom(|iterations| {
                let mut spent = Duration::ZERO;
                for _ in 0..iterations {
                    run.world.resource_mut::<Toggled>().touches = !touches;
                    islands(&mut run);
                    islands(&mut run);
                    run.world.resource_mut::<Toggled>().touches = touches;
                    spent += islands(&mut run);
                }
                spent
            });
        });
    }
    group.finish();
}

criterion_group!(benches, graph);
criterion_main!(benches);
