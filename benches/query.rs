//! The time of queries: spatial queries among ten thousand bricks (a wall of 400 × 25), supports in a wall of 40 × 25, and previews and
//! stability in a wall of 10 × 10 (stability with `--features stability`).
//!
//! ```text
//! cargo bench --bench query
//! ```

use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemState;
use criterion::{Criterion, criterion_group, criterion_main};
use drystone::collider::Collider;
use drystone::contact::{Contacts, Supports};
use drystone::prelude::{Pose, Quat, Vec3};
use drystone::preview::{Edit, Shadow, preview};
use drystone::query::{Dir3, QueryFilter, Ray3d, SpatialQuery};
use drystone::settings::Preset;
use drystone_lab::experiment::Experiment;
use drystone_lab::scenes::Scene;
use fastrand::Rng;
use std::hint::black_box;

/// How many different questions are asked in turn, so that none finds in the cache all that it needs.
const QUESTIONS: usize = 1024;

/// From in front of the wall to some place on it.
fn rays(rng: &mut Rng) -> Vec<Ray3d> {
    let mut place = |depth| Vec3::new(380.0 * (rng.f32() - 0.5), 12.0 * rng.f32(), depth);
    let ray = |from: Vec3, to: Vec3| Ray3d::new(from, Dir3::new(to - from).expect("a way"));
    (0..QUESTIONS)
        .map(|_| {
            let (to, aside) = (place(0.0), place(10.0));
            ray(Vec3::new(to.x, aside.y, 10.0), to)
        })
        .collect()
}

fn questions(criterion: &mut Criterion) {
    let mut run = Experiment::new(Scene::Wall(400, 25), Preset::Default).start();
    run.step();
    let mut state = SystemState::<SpatialQuery>::new(&mut run.world);
    let world = state.get(&run.world).expect("drystone is there");
    let rng = &mut Rng::with_seed(1);
    let rays = rays(rng);
    let any = QueryFilter::default();
    let hits = rays.iter().map(|&ray| world.cast_ray(ray, 100.0, &any));
    let hits: Vec<_> = hits
        .map(|hit| hit.expect("a ray").expect("a wall"))
        .collect();
    let brick = Collider::cuboid(1.0, 0.5, 0.5);
    let pose = |position| Pose {
        position,
        rotation: Quat::IDENTITY,
    };

    let mut group = criterion.benchmark_group("query, 10 000 bricks");
    let mut ask = |name: &str, question: &dyn Fn(usize)| {
        let mut i = 0;
        group.bench_function(name, |bencher| {
            bencher.iter(|| {
                i = (i + 1) % QUESTIONS;
                question(i);
            });
        });
    };
    ask("ray, first", &|i| {
        black_box(world.cast_ray(rays[i], 100.0, &any)).ok();
    });
    ask("ray, all", &|i| {
        black_box(world.cast_ray_through(rays[i], 100.0, &any)).ok();
    });
    ask("ray along the wall, all of a course", &|i| {
        let along = Ray3d::new(Vec3::new(-300.0, hits[i].point.y, 0.0), Dir3::X);
        black_box(world.cast_ray_through(along, 1000.0, &any)).ok();
    });
    ask("shape on its way", &|i| {
        let from = pose(rays[i].origin);
        black_box(world.cast_shape(&brick, from, rays[i].direction, 100.0, &any)).ok();
    });
    ask("closest point", &|i| {
        black_box(world.closest_point(rays[i].origin, 100.0, &any)).ok();
    });
    ask("does a brick fit", &|i| {
        let there = pose(hits[i].point);
        black_box(world.fits(&brick, there, 1e-3, &any)).ok();
    });
}

/// From a brick in the middle of the wall.
fn carrying(criterion: &mut Criterion) {
    let mut run = Experiment::new(Scene::Wall(40, 25), Preset::Default).start();
    for _ in 0..120 {
        run.step();
    }
    let mut poses = run.world.query::<(Entity, &Pose)>();
    let poses = poses.iter(&run.world);
    let poses: Vec<(Entity, Vec3)> = poses.map(|(body, pose)| (body, pose.position)).collect();
    let nearest = |at: Vec3| {
        let distance = |body: &&(Entity, Vec3)| at.distance_squared(body.1);
        let nearest = poses
            .iter()
            .min_by(|a, b| distance(a).total_cmp(&distance(b)));
        nearest.expect("there are bricks").0
    };
    let (top, middle) = (nearest(Vec3::Y * 20.0), nearest(Vec3::Y * 6.0));
    let mut state = SystemState::<(Contacts, Supports)>::new(&mut run.world);
    let (contacts, supports) = state.get(&run.world).expect("drystone is there");

    let mut group = criterion.benchmark_group("carrying, 1 000 bricks");
    let mut ask = |name: &str, question: &dyn Fn()| {
        group.bench_function(name, |bencher| bencher.iter(question));
    };
    ask("forces on a brick", &|| {
        black_box(contacts.on(middle)).ok();
    });
    ask("supported by", &|| {
        black_box(supports.supported_by(middle)).ok();
    });
    ask("supports", &|| {
        black_box(supports.supports(middle)).ok();
    });
    ask("load path from the middle", &|| {
        black_box(supports.load_path(middle)).ok();
    });
    ask("load path from the top", &|| {
        black_box(supports.load_path(top)).ok();
    });
    ask("hanging on", &|| {
        black_box(supports.supported_only_by(middle)).ok();
    });
    ask("structure", &|| {
        black_box(supports.structure(middle)).ok();
    });
}

/// Previews in a wall of 10 × 10.
fn previews(criterion: &mut Criterion) {
    let mut run = Experiment::new(Scene::Wall(10, 10), Preset::Default).start();
    for _ in 0..60 {
        run.step();
    }
    let mut group = criterion.benchmark_group("preview, 105 bricks");
    for (name, brick) in [("nothing falls", 60), ("a corner falls", 0)] {
        let edit = Edit::Remove(vec![run.bodies[brick]]);
        group.bench_function(name, |bencher| {
            bencher.iter(|| black_box(preview(&run.world, &edit)));
        });
    }
    group.bench_function("the copy alone", |bencher| {
        bencher.iter(|| black_box(Shadow::around(&run.world, &run.bodies).is_ok()));
    });
    group.finish();
    #[cfg(feature = "stability")]
    {
        use drystone::stability::{Trial, stability};
        criterion.bench_function("stability, 105 bricks, tilted", |bencher| {
            let trial = Trial::Tilt(Vec3::Z);
            bencher.iter(|| black_box(stability(&run.world, &run.bodies, &trial)));
        });
    }
}

criterion_group!(benches, questions, carrying, previews);
criterion_main!(benches);
