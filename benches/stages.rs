//! One bench per system on a resting wall of 1 000 bricks, and every solver per contact point and sweep.
//!
//! ```text
//! cargo bench --bench stages
//! ```
//!
//! A system is timed inside whole steps, by drystone's own [`Profile`]: alone it would meet warm caches that it never sees.

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use drystone::profile::Profile;
use drystone::schedule::step;
use drystone::settings::{PhysicsThreads, Preset};
use drystone::solver::merit::free_merit;
use drystone::solver::{
    Body, FrictionCone, Lanes, Memory, Nncg, PatchConstraint, PatchPoint, PatchProblem,
    PatchSolver, Pgs, PointConstraint, PointInput, PointProblem, PointSolver, SoftStep,
};
use drystone_lab::experiment::{Experiment, Run};
use drystone_lab::scenes::Scene;
use glam::{Mat3, Vec3};
use std::hint::black_box;
use std::time::Duration;

const DT: f32 = 1.0 / 60.0;

/// A wall of 40 × 25, 1 012 bricks, that has come to rest; one thread, nothing asleep.
fn resting_wall() -> Run {
    let mut experiment = Experiment::new(Scene::Wall(40, 25), Preset::Default);
    experiment.threads = PhysicsThreads::new(1).expect("one thread can be had");
    experiment.sleeping.enabled = false;
    let mut run = experiment.start();
    for _ in 0..60 {
        run.step();
    }
    run
}

fn systems(criterion: &mut Criterion) {
    let mut run = resting_wall();
    let names: Vec<_> = run.world.resource::<Profile>().systems();
    let mut group = criterion.benchmark_group("wall:40x25");
    group
        .sample_size(10)
        .measurement_time(Duration::from_secs(2));
    for (name, _) in names {
        group.bench_function(name, |bencher| {
            bencher.iter_custom(|iterations| {
                let mut spent = Duration::ZERO;
                for _ in 0..iterations {
                    step(&mut run.world, DT).expect("the step is positive");
                    spent += run
                        .world
                        .resource::<Profile>()
                        .system(name)
                        .unwrap_or_default();
                }
                spent
            });
        });
    }
    group.finish();
}

/// The contacts of a wall, four points each, as the solver sees them: each brick on two below.
fn wall_problem(width: u32, courses: u32) -> (Vec<Body>, Vec<PointConstraint>) {
    let ground = Body {
        inverse_inertia: Mat3::ZERO,
        ..Default::default()
    };
    let brick = Body {
        linear: Vec3::NEG_Y * 9.81 * DT,
        inverse_mass: 1.0 / 250.0,
        inverse_inertia: Mat3::from_diagonal(Vec3::new(0.096, 0.0384, 0.0384)),
        ..Default::default()
    };
    let mut bodies = vec![ground];
    bodies.extend((0..width * courses).map(|_| brick));
    let mut contacts = Vec::new();
    for course in 0..courses {
        for i in 0..width {
            let body = 1 + course * width + i;
            for side in [-1.0f32, 1.0] {
                let other = (i + (side > 0.0) as u32) % width;
                let below = if course == 0 {
                    0
                } else {
                    1 + (course - 1) * width + other
                };
                for (x, z) in [(0.0, -0.25), (0.5, 0.25), (0.5, -0.25), (0.0, 0.25)] {
                    let arm = Vec3::new(side * x, -0.25, z);
                    let from_below = Vec3::new(side * (x - 0.5), 0.25, z);
                    let input = PointInput {
                        bodies: [body, below],
                        normal: Vec3::Y,
                        arms: [arm, from_below],
                        friction: 0.5,
                        ..Default::default()
                    };
                    contacts.push(PointConstraint::prepare(&input, &bodies));
                }
            }
        }
    }
    (bodies, contacts)
}

fn solvers(criterion: &mut Criterion) {
    // So many that what surrounds them hardly counts.
    const SWEEPS: usize = 240;
    let (bodies, contacts) = wall_problem(40, 25);
    let free_merit = free_merit(&bodies, &contacts);
    let mut group = criterion.benchmark_group("solver, per contact point and sweep");
    group.sample_size(20);
    group.throughput(Throughput::Elements((contacts.len() * SWEEPS) as u64));
    let cones = [FrictionCone::Circular, FrictionCone::Box];
    let widths = |cone| [Lanes::Four, Lanes::Eight].map(|lanes| (cone, lanes));
    for (cone, lanes) in cones.into_iter().flat_map(widths) {
        let pgs = Pgs {
            iterations: SWEEPS,
            cone,
            lanes,
            ..Default::default()
        };
        let nncg = Nncg {
            iterations: SWEEPS,
            cone,
            lanes,
            ..Default::default()
        };
        if let Some(problem) = pgs.problem() {
            eprintln!("{problem}");
            continue;
        }
        let solvers: [&dyn PointSolver; 2] = [&pgs, &nncg];
        for solver in solvers {
            let id = BenchmarkId::new(solver.name(), format!("{cone:?}, {lanes:?}"));
            group.bench_function(id, |bencher| {
                bencher.iter_batched_ref(
                    || (bodies.clone(), contacts.clone()),
                    |(bodies, constraints)| {
                        let mut problem = PointProblem {
                            bodies,
                            constraints,
                            grabs: &mut [],
                            joints: &mut [],
                            dt: DT,
                            max_recent_dt: DT,
                            effort: 1.0,
                            free_merit,
                            record_history: false,
                        };
                        black_box(solver.solve(&mut problem))
                    },
                    criterion::BatchSize::LargeInput,
                );
            });
        }
    }
    group.finish();
}

/// The same contacts as patches of four points.
fn patches(contacts: &[PointConstraint]) -> (Vec<PatchConstraint>, Vec<PatchPoint>) {
    let mut points = Vec::new();
    let patch = |contacts: &[PointConstraint]| {
        let first = points.len() as u32;
        let mean = |side: usize| {
            let arms = contacts.iter().map(|c| c.arms[side]);
            arms.sum::<Vec3>() / contacts.len() as f32
        };
        let arms = [mean(0), mean(1)];
        points.extend(contacts.iter().map(|c| PatchPoint {
            offset: c.arms[0] - arms[0],
            ..Default::default()
        }));
        PatchConstraint {
            bodies: contacts[0].bodies,
            normal: contacts[0].normal,
            arms,
            friction: 0.5,
            first,
            count: contacts.len() as u32,
            ..Default::default()
        }
    };
    let patches = contacts
        .chunk_by(|a, b| a.bodies == b.bodies)
        .map(patch)
        .collect();
    (patches, points)
}

/// Soft Step by the width of its lanes, for each contact point and sweep: so many sweeps that what surrounds them hardly counts.
fn soft_step(criterion: &mut Criterion) {
    const SWEEPS: usize = 480;
    let (bodies, contacts) = wall_problem(40, 25);
    let (mut patches, mut points) = patches(&contacts);
    let method = |lanes| SoftStep {
        lanes,
        max_sweeps: SWEEPS,
        max_substep: 1e-5,
        ..Default::default()
    };
    let solve = |method: &SoftStep,
                 bodies: &mut [Body],
                 patches: &mut [PatchConstraint],
                 points: &mut [PatchPoint]| {
        method.solve(&mut PatchProblem {
            bodies,
            patches,
            points,
            grabs: &mut [],
            joints: &mut [],
            surfaces: &[],
            dt: DT,
            max_recent_dt: DT,
            gravity: Vec3::NEG_Y * 9.81,
            effort: 1.0,
            broke: false,
            max_correction_speed: 2.0,
            settling: None,
            stays_awake: false,
            record_history: false,
            threads: 1,
            memory: &mut Memory::default(),
        })
    };
    // The first solve finds what contacts carry, which is no part of a sweep.
    let four = method(Lanes::Four);
    solve(&four, &mut bodies.clone(), &mut patches, &mut points);
    let mut group = criterion.benchmark_group("solver, per contact point and sweep");
    group.sample_size(20);
    group.throughput(Throughput::Elements((points.len() * SWEEPS) as u64));
    for lanes in [Lanes::Four, Lanes::Eight] {
        let method = method(lanes);
        if let Some(problem) = method.problem() {
            eprintln!("{problem}");
            continue;
        }
        let id = BenchmarkId::new("soft-step", format!("{lanes:?}"));
        group.bench_function(id, |bencher| {
            bencher.iter_batched_ref(
                || (bodies.clone(), patches.clone(), points.clone()),
                |(bodies, patches, points)| black_box(solve(&method, bodies, patches, points)),
                criterion::BatchSize::LargeInput,
            );
        });
    }
    group.finish();
}

criterion_group!(benches, systems, solvers, soft_step);
criterion_main!(benches);
