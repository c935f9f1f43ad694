//! The time that one contact that begins or ends takes in a wall of 10 000 bricks, compared with a step without changes: in the constraint
//! graph, and in the stage *warm start*. The contact is one of the wall, or that of two bricks beside it, which are another island.
//!
//! ```text
//! cargo bench --bench graph
//! ```
//!
//! A system between *narrowphase* and *islands* takes the points out of its manifold and puts them back. Stages are timed inside whole
//! steps, by drystone's own [`Profile`].

use criterion::{Criterion, criterion_group, criterion_main};
use drystone::contact::{ContactPoint, Manifold};
use drystone::prelude::*;
use drystone::settings::{PhysicsThreads, Preset};
use drystone_lab::experiment::{Experiment, Run};
use drystone_lab::scenes::Scene;
use std::time::Duration;

use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;

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

/// Where the contact is.
#[derive(Clone, Copy, PartialEq)]
enum At {
    /// On top of the wall.
    Wall,
    /// Between two bricks that lie on each other beside the wall.
    Beside,
}

/// A wall of 10 000 bricks that has come to rest; one thread, nothing asleep.
fn resting_wall(at: At) -> Run {
    let mut experiment = Experiment::new(Scene::Wall(100, 99), Preset::Default);
    experiment.threads = PhysicsThreads::new(1).expect("one thread can be had");
    experiment.sleeping.enabled = false;
    let mut run = experiment.start();
    let place = |height| Transform::from_xyz(0.0, height, 20.0);
    let beside = [0.25, 0.75].map(|height| {
        let brick = (
            RigidBody::Dynamic,
            Collider::cuboid(1.0, 0.5, 0.5),
            place(height),
        );
        run.world.spawn(brick).id()
    });
    for _ in 0..10 {
        run.step();
    }
    let world = &mut run.world;
    let mut bodies = world.query::<(Entity, &Pose)>();
    let highest = bodies
        .iter(world)
        .max_by(|(_, a), (_, b)| a.position.y.total_cmp(&b.position.y));
    let upper = match at {
        At::Wall => highest.expect("the wall has bricks").0,
        At::Beside => beside[1],
    };
    let mut pairs = world.query::<(Entity, &ContactPair, &Manifold)>();
    let of_it = pairs
        .iter(world)
        .find(|(_, pair, manifold)| pair.bodies.contains(&upper) && !manifold.points.is_empty());
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

/// Takes a step and returns the time of a stage.
fn time(run: &mut Run, stage: &str) -> Duration {
    drystone::step(&mut run.world, DT).expect("the step is positive");
    let profile = run.world.resource::<Profile>();
    profile.system(stage).unwrap_or_default()
}

fn graph(criterion: &mut Criterion) {
    for (at, place) in [(At::Wall, "in it"), (At::Beside, "beside it")] {
        let mut run = resting_wall(at);
        for stage in ["islands", "warm_start"] {
            let mut group =
                criterion.benchmark_group(format!("wall of 10 000, contact {place}, {stage}"));
            group
                .sample_size(10)
                .warm_up_time(Duration::from_millis(100))
                .measurement_time(Duration::from_secs(1));
            group.bench_function("nothing changes", |bencher| {
                bencher
                    .iter_custom(|iterations| (0..iterations).map(|_| time(&mut run, stage)).sum());
            });
            for (name, touches) in [("it begins", true), ("it ends", false)] {
                group.bench_function(name, |bencher| {
                    bencher.iter_custom(|iterations| {
                        let mut spent = Duration::ZERO;
                        for _ in 0..iterations {
                            run.world.resource_mut::<Toggled>().touches = !touches;
                            time(&mut run, stage);
                            time(&mut run, stage);
                            run.world.resource_mut::<Toggled>().touches = touches;
                            spent += time(&mut run, stage);
                        }
                        spent
                    });
                });
            }
            group.finish();
        }
    }
}

criterion_group!(benches, graph);
criterion_main!(benches);
