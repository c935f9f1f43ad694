//! The cost of one contact that begins or ends in a wall of 10 000 bricks that is awake: the time of the step with the change, minus that
//! of a step without. The contact is one of the wall's own, or that of two bricks beside it, which are another island.
//!
//! ```text
//! cargo run --release --example one_contact -- [--courses 99] [--at 0.5 | --beside] [--changes 20]
//! ```
//!
//! A system between *narrowphase* and *islands* takes the points out of a manifold and puts them back. Prints the least and the median time
//! of steps in which nothing changes, in which the contact ends and in which it begins, by stage. For counts of instructions instead of
//! times:
//!
//! ```text
//! valgrind --tool=callgrind --collect-atstart=no --toggle-collect='one_contact::begins' target/release/examples/one_contact --changes 1
//! ```

use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use clap::Parser;
use drystone::contact::{ContactPoint, Manifold};
use drystone::prelude::*;
use drystone::settings::{PhysicsThreads, Preset};
use drystone_lab::experiment::{Experiment, Run};
use drystone_lab::scenes::Scene;
use std::time::{Duration, Instant};

/// Measures one contact that begins or ends.
#[derive(Parser)]
struct Arguments {
    /// Bricks in a course.
    #[arg(long, default_value_t = 100)]
    width: u32,
    /// Courses.
    #[arg(long, default_value_t = 99)]
    courses: u32,
    /// Height of the contact, as a share of the wall's.
    #[arg(long, default_value_t = 0.5)]
    at: f32,
    /// The contact is between two bricks that lie on each other beside the wall.
    #[arg(long, conflicts_with = "at")]
    beside: bool,
    /// How often the contact ends and begins.
    #[arg(long, default_value_t = 20)]
    changes: usize,
}

/// The pair whose contact begins and ends, and its points while it has none.
#[derive(Resource)]
struct Toggled {
    pair: Entity,
    points: Vec<ContactPoint>,
    /// Whether it is to have its points in the next step.
    touches: bool,
}

fn toggle(mut toggled: ResMut<Toggled>, mut manifolds: Query<&mut Manifold>) {
    let toggled = &mut *toggled;
    let manifold = manifolds.get(toggled.pair);
    if manifold.is_ok_and(|manifold| manifold.points.is_empty() == toggled.touches)
        && let Ok(mut manifold) = manifolds.get_mut(toggled.pair)
    {
        match toggled.touches {
            true => manifold.points.extend(toggled.points.drain(..)),
            false => toggled.points = manifold.points.drain(..).collect(),
        }
    }
}

/// The dynamic body at this share of the order by height, from the lowest to the highest.
fn brick_at(world: &mut World, share: f32) -> Entity {
    let mut bodies = world.query::<(Entity, &Pose, &RigidBody)>();
    let dynamic = bodies
        .iter(world)
        .filter(|(.., kind)| **kind == RigidBody::Dynamic);
    let mut heights: Vec<_> = dynamic
        .map(|(entity, pose, _)| (pose.position.y, pose.position.x.abs(), entity))
        .collect();
    heights.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    heights[(share * (heights.len() - 1) as f32) as usize].2
}

/// A wall that has come to rest; one thread, nothing asleep.
fn resting_wall(arguments: &Arguments) -> Run {
    let scene = Scene::Wall(arguments.width, arguments.courses);
    let mut experiment = Experiment::new(scene, Preset::Default);
    experiment.threads = PhysicsThreads::new(1).expect("one thread can be had");
    experiment.sleeping.enabled = false;
    let mut run = experiment.start();
    let place = |height| Transform::from_xyz(0.0, height, 20.0);
    let pair = arguments.beside.then(|| {
        [0.25, 0.75].map(|height| {
            let collider = Collider::cuboid(1.0, 0.5, 0.5);
            let brick = (RigidBody::Dynamic, collider, place(height));
            run.world.spawn(brick).id()
        })
    });
    for _ in 0..10 {
        run.step();
    }
    let upper = match pair {
        Some([_, upper]) => upper,
        None => brick_at(&mut run.world, arguments.at),
    };
    let world = &mut run.world;
    let height = |world: &World, body| world.get::<Pose>(body).map(|pose| pose.position.y);
    let top = height(world, upper);
    let mut pairs = world.query::<(Entity, &ContactPair, &Manifold)>();
    let below = pairs.iter(world).find(|(_, pair, manifold)| {
        let [a, b] = pair.bodies;
        let other = if a == upper { b } else { a };
        let touches = pair.bodies.contains(&upper) && !manifold.points.is_empty();
        touches && height(world, other) < top
    });
    let pair = below.expect("it lies on others").0;
    run.world.insert_resource(Toggled {
        pair,
        points: Vec::new(),
        touches: true,
    });
    let mut schedules = run.world.resource_mut::<Schedules>();
    schedules.add_systems(
        PhysicsSchedule,
        toggle
            .after(PhysicsSystems::Narrowphase)
            .before(PhysicsSystems::Islands),
    );
    run
}

/// Takes a step, and returns its time and that of some stages.
fn step(run: &mut Run) -> Vec<Duration> {
    let start = Instant::now();
    drystone::step(&mut run.world, 1.0 / 60.0).expect("the step is positive");
    let whole = start.elapsed();
    let profile = run.world.resource::<Profile>();
    let stages = STAGES.map(|stage| profile.system(stage).unwrap_or_default());
    [whole].into_iter().chain(stages).collect()
}

const STAGES: [&str; 3] = ["islands", "warm_start", "solve"];

/// A step in which nothing changes.
#[inline(never)]
fn rests(run: &mut Run) -> Vec<Duration> {
    step(run)
}

/// A step in which the contact ends.
#[inline(never)]
fn ends(run: &mut Run) -> Vec<Duration> {
    run.world.resource_mut::<Toggled>().touches = false;
    step(run)
}

/// A step in which the contact begins.
#[inline(never)]
fn begins(run: &mut Run) -> Vec<Duration> {
    run.world.resource_mut::<Toggled>().touches = true;
    step(run)
}

/// The least and the median of each column, ms.
fn row(name: &str, times: &[Vec<Duration>]) -> String {
    let columns = (0..=STAGES.len()).map(|column| {
        let mut column: Vec<_> = times.iter().map(|times| times[column]).collect();
        column.sort_unstable();
        let [least, median] = [0, column.len() / 2].map(|at| 1e3 * column[at].as_secs_f64());
        format!(" {least:.3} ({median:.3}) |")
    });
    format!("| {name} |{}", columns.collect::<String>())
}

fn main() {
    let arguments = Arguments::parse();
    let mut run = resting_wall(&arguments);
    let [mut at_rest, mut ended, mut begun] = [(); 3].map(|()| Vec::new());
    for _ in 0..arguments.changes.max(1) {
        rests(&mut run);
        ended.push(ends(&mut run));
        step(&mut run);
        begun.push(begins(&mut run));
        step(&mut run);
        at_rest.push(rests(&mut run));
    }
    println!("least (median), ms\n\n| | step | {} |", STAGES.join(" | "));
    println!("|---|{}", "---|".repeat(STAGES.len() + 1));
    println!("{}", row("nothing changes", &at_rest));
    println!("{}", row("a contact ends", &ended));
    println!("{}", row("a contact begins", &begun));
}
