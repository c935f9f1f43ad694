//! What a sensor costs: a zone over 1 000 sleeping bodies, and one through which 1 000 bodies fall. Timed is the stage *sensors* inside
//! whole steps, by drystone's own [`Profile`].
//!
//! ```text
//! cargo bench --bench sensors
//! ```

use bevy_app::App;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use criterion::{Criterion, criterion_group, criterion_main};
use drystone::prelude::*;
use drystone::settings::PhysicsThreads;
use std::time::Duration;

const DT: f32 = 1.0 / 60.0;

/// Number of bodies along each side of a square.
const SIDE: usize = 32;

/// Bodies in a square on the ground, and a zone around all of them.
fn world(asleep: bool) -> World {
    let mut app = App::new();
    app.add_plugins(DrystonePlugins::default());
    let mut world = std::mem::take(app.world_mut());
    world.insert_resource(PhysicsThreads::new(1).expect("one thread can be had"));
    world.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
    let bodies = (0..SIDE * SIDE).map(|i| {
        let (x, z) = ((i % SIDE) as f32, (i / SIDE) as f32);
        let y = if asleep { 0.25 } else { 40.0 };
        let sleeping = Sleeping {
            asleep,
            ..Sleeping::default()
        };
        let at = Transform::from_xyz(x, y, z);
        (
            RigidBody::Dynamic,
            Collider::cuboid(0.5, 0.5, 0.5),
            at,
            sleeping,
        )
    });
    let bodies: Vec<_> = bodies.collect();
    world.spawn_batch(bodies);
    let zone = Transform::from_xyz(16.0, 0.0, 16.0);
    let zone = world
        .spawn((Collider::cuboid(40.0, 100.0, 40.0), Sensor, zone))
        .id();
    for _ in 0..10 {
        drystone::step(&mut world, DT).expect("the step is positive");
    }
    let inside = world.get::<SensorOverlaps>(zone).expect("it is a sensor");
    assert_eq!(inside.len(), SIDE * SIDE);
    world
}

/// Time of the stage in so many steps.
fn time(world: &mut World, steps: u64) -> Duration {
    let mut sum = Duration::ZERO;
    for _ in 0..steps {
        drystone::step(world, DT).expect("the step is positive");
        let profile = world.resource::<Profile>();
        sum += profile.system("sensors").unwrap_or_default();
    }
    sum
}

fn sensors(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("sensors");
    let mut asleep = world(true);
    group.bench_function("a zone over 1 024 sleeping bodies", |bencher| {
        bencher.iter_custom(|steps| time(&mut asleep, steps));
    });
    group.bench_function("a zone over 1 024 falling bodies", |bencher| {
        // They leave it after a while.
        bencher.iter_custom(|steps| {
            let mut time_of = Duration::ZERO;
            let mut left = steps;
            while left > 0 {
                let some = left.min(60);
                time_of += time(&mut world(false), some);
                left -= some;
            }
            time_of
        });
    });
    group.finish();
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(20);
    targets = sensors
}
criterion_main!(benches);
