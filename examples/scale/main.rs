//! The cost of worlds of many bricks: asleep, awake, static, and while bricks are added beside them.
//!
//! ```text
//! cargo run --release --example scale -- [--bricks 100000] [--threads 1]
//! cargo run --release --example scale -- --weight
//! cargo run --release --example scale -- --million [--threads 0]
//! ```
//!
//! Prints tables, and writes `scale.csv` and `scale.png`, the cost of a wall that is awake over its size, to `target/scale`. `--weight`
//! measures only the memory of walls that are awake and then fall asleep. `--million` measures towns of a hundred to a million bricks
//! asleep instead, and writes `town.csv` and `town.png`.

mod town;

use bevy_app::App;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use clap::Parser;
use drystone::prelude::*;
use drystone::settings::PhysicsThreads;
use drystone_lab::plots::{Canvas, bring_font};
use plotters::prelude::*;
use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};
use std::alloc::System;
use std::error::Error;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

mod weight;

#[global_allocator]
static MEMORY: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

/// Measures worlds of many bricks.
#[derive(Parser)]
struct Arguments {
    /// In the largest worlds.
    #[arg(long, default_value_t = 100_000, value_parser = clap::value_parser!(u32).range(1000..))]
    bricks: u32,
    /// Threads; 0 for all. One by default; all while a town gets ready.
    #[arg(long)]
    threads: Option<usize>,
    /// Measures towns of up to a million bricks.
    #[arg(long)]
    million: bool,
    /// Measures a town of so many walls, and prints a row of `town.csv`.
    #[arg(long)]
    town: Option<u32>,
    /// Steps for the largest wall that is awake; smaller ones take more.
    #[arg(long, default_value_t = 10)]
    steps: u32,
    /// Measure only what a brick weighs while it is awake, and after it has fallen asleep.
    #[arg(long)]
    weight: bool,
    /// Where results go.
    #[arg(long, default_value = "target/scale")]
    out: PathBuf,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let measured = match arguments.town {
        Some(walls) => town::measure_one(walls, &arguments),
        None if arguments.million => town::measure(&arguments),
        None => measure(&arguments),
    };
    match measured {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::from(2)
        }
    }
}

fn measure(arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    if arguments.weight {
        println!("{}", weight::measure(arguments)?);
        return Ok(());
    }
    fs::create_dir_all(&arguments.out)?;
    bring_font()?;
    println!("{}", crowd(arguments)?);
    println!("{}", standing(arguments)?);
    let walls = awake(arguments)?;
    println!(
        "| a wall awake | ms a step | µs a brick | kB a brick | allocations a step |\n|---|---|---|---|---|"
    );
    let mut csv = String::from("bricks,step_ms,kilobytes_a_brick,allocations_a_step\n");
    for wall in &walls {
        let Wall {
            bricks,
            step,
            kilobytes,
            allocations,
        } = wall;
        let each = 1e3 * step / *bricks as f64;
        println!("| {bricks} bricks | {step:.3} | {each:.2} | {kilobytes:.2} | {allocations} |");
        writeln!(csv, "{bricks},{step:.6},{kilobytes:.4},{allocations}")?;
    }
    fs::write(arguments.out.join("scale.csv"), csv)?;
    draw(&walls, &arguments.out.join("scale.png"))?;
    println!(
        "\nscale.csv and scale.png are in {}",
        arguments.out.display()
    );
    Ok(())
}

/// A world, and how it is stepped.
struct Site {
    app: App,
}

/// A brick, m.
const BRICK: Vec3 = Vec3::new(1.0, 0.5, 0.5);

/// The walls that the bricks of a crowd stand in: in a course, and courses.
const CROWD: [u32; 2] = [40, 25];

impl Site {
    fn new(threads: usize, sleeping: bool) -> Result<Self, Box<dyn Error>> {
        let mut app = App::new();
        app.add_plugins(DrystonePlugins::default());
        let world = app.world_mut();
        world.insert_resource(PhysicsThreads::new(threads)?);
        world.resource_mut::<SleepSettings>().enabled = sleeping;
        world.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
        Ok(Self { app })
    }

    /// A wall in running bond, in a plane of constant z.
    fn wall(&mut self, [width, courses]: [u32; 2], z: f32, asleep: bool) -> Vec<Entity> {
        let collider = Collider::cuboid(BRICK.x, BRICK.y, BRICK.z);
        let bricks = (0..courses).flat_map(|course| {
            let shift = 0.5 * (course % 2) as f32;
            (0..width).map(move |i| Vec3::new(i as f32 + shift, course as f32 + 0.5, z))
        });
        let bricks: Vec<_> = bricks
            .map(|at| {
                let place = Transform::from_translation(at * BRICK.with_z(1.0));
                let sleeping = Sleeping {
                    asleep,
                    ..Default::default()
                };
                (RigidBody::Dynamic, collider.clone(), place, sleeping)
            })
            .collect();
        self.app.world_mut().spawn_batch(bricks).collect()
    }

    /// ms
    fn step(&mut self) -> f64 {
        let start = Instant::now();
        drystone::step(self.app.world_mut(), 1.0 / 60.0).expect("the step is as long as it may be");
        1e3 * start.elapsed().as_secs_f64()
    }

    /// Takes `count` steps. Returns their median time and the longest, ms.
    fn steps(&mut self, count: u32) -> [f64; 2] {
        let mut times: Vec<f64> = (0..count).map(|_| self.step()).collect();
        times.sort_by(f64::total_cmp);
        [times[times.len() / 2], times[times.len() - 1]]
    }
}

/// Many walls that sleep, and edits beside them.
fn crowd(arguments: &Arguments) -> Result<String, Box<dyn Error>> {
    let memory = Region::new(MEMORY);
    let mut site = Site::new(arguments.threads.unwrap_or(1), true)?;
    let count = arguments.bricks / (CROWD[0] * CROWD[1]);
    let walls: Vec<_> = (0..count)
        .map(|i| site.wall(CROWD, 3.0 * i as f32, true))
        .collect();
    site.steps(5);
    let stats = memory.change();
    let bytes = stats.bytes_allocated - stats.bytes_deallocated;
    let bricks = walls.iter().flatten().count();
    let mut text = format!("| {bricks} bricks asleep in {count} walls | ms |\n|---|---|\n");
    let [median, longest] = site.steps(50);
    writeln!(
        text,
        "| a step, all of them asleep | {median:.3} (longest {longest:.3}) |"
    )?;
    writeln!(
        text,
        "| memory, kB a brick | {:.2} |",
        1e-3 * bytes as f64 / bricks as f64
    )?;

    let top = walls[0][walls[0].len() - 1];
    let push = ExternalImpulse {
        linear: Vec3::Y * 10.0,
        ..Default::default()
    };
    site.app.world_mut().entity_mut(top).insert(push);
    let first = site.step();
    let [median, longest] = site.steps(20);
    writeln!(
        text,
        "| a brick of one wall is pushed: the first step | {first:.3} |"
    )?;
    writeln!(
        text,
        "| that wall awake | {median:.3} (longest {longest:.3}) |"
    )?;
    let mut alone = Site::new(arguments.threads.unwrap_or(1), false)?;
    alone.wall(CROWD, 0.0, false);
    alone.steps(5);
    let [median, _] = alone.steps(20);
    writeln!(
        text,
        "| such a wall awake, alone in the world | {median:.3} |"
    )?;
    drop(alone);
    for _ in 0..200 {
        site.step();
    }
    let [median, longest] = site.steps(20);
    writeln!(
        text,
        "| it sleeps again | {median:.3} (longest {longest:.3}) |"
    )?;

    let start = Instant::now();
    let new = site.wall(CROWD, -10.0, true);
    let spawned = 1e3 * start.elapsed().as_secs_f64();
    let first = site.step();
    let [_, longest] = site.steps(20);
    writeln!(
        text,
        "| {} bricks are spawned beside them, asleep: spawning, the next step, the longest after | {spawned:.3}, {first:.3}, \
         {longest:.3} |",
        new.len()
    )?;
    let start = Instant::now();
    for &brick in &new {
        site.app.world_mut().despawn(brick);
    }
    let gone = 1e3 * start.elapsed().as_secs_f64();
    let first = site.step();
    let [_, longest] = site.steps(20);
    writeln!(
        text,
        "| they are despawned: despawning, the next step, the longest after | {gone:.3}, {first:.3}, {longest:.3} |"
    )?;
    Ok(text)
}

/// Static bricks in a field, and a hundred dynamic ones asleep on them.
fn standing(arguments: &Arguments) -> Result<String, Box<dyn Error>> {
    let mut site = Site::new(arguments.threads.unwrap_or(1), true)?;
    let side = (arguments.bricks as f32).sqrt() as u32;
    let collider = Collider::cuboid(BRICK.x, BRICK.y, BRICK.z);
    for (x, z) in (0..side).flat_map(|x| (0..side).map(move |z| (x, z))) {
        let at = Vec3::new(2.0 * x as f32, 0.25, 2.0 * z as f32);
        let world = site.app.world_mut();
        world.spawn((
            RigidBody::Static,
            collider.clone(),
            Transform::from_translation(at),
        ));
        if z == 0 && x < 100 {
            let place = Transform::from_translation(at + Vec3::Y * 0.5);
            let sleeping = Sleeping {
                asleep: true,
                ..Default::default()
            };
            world.spawn((RigidBody::Dynamic, collider.clone(), place, sleeping));
        }
    }
    site.steps(5);
    let [median, longest] = site.steps(50);
    Ok(format!(
        "| {} static bricks and 100 asleep on them | ms |\n|---|---|\n| a step | {median:.3} (longest {longest:.3}) |\n",
        side * side
    ))
}

/// A wall that is awake.
struct Wall {
    bricks: usize,
    /// ms
    step: f64,
    kilobytes: f64,
    /// In a step.
    allocations: usize,
}

/// Walls of growing size.
fn awake(arguments: &Arguments) -> Result<Vec<Wall>, Box<dyn Error>> {
    let largest = (arguments.bricks as f32).log10().floor() as u32;
    let sizes = [[10, 10], [40, 25], [200, 50], [1000, 100], [5000, 200]];
    let mut walls = Vec::new();
    for (size, exponent) in sizes.into_iter().zip(2..=largest) {
        let memory = Region::new(MEMORY);
        let mut site = Site::new(arguments.threads.unwrap_or(1), false)?;
        let bricks = site.wall(size, 0.0, false).len();
        let steps = arguments.steps * (largest - exponent + 1);
        site.steps(5);
        let stats = memory.change();
        let [step, _] = site.steps(steps);
        let region = Region::new(MEMORY);
        site.step();
        walls.push(Wall {
            bricks,
            step,
            kilobytes: 1e-3 * (stats.bytes_allocated - stats.bytes_deallocated) as f64
                / bricks as f64,
            allocations: region.change().allocations + region.change().reallocations,
        });
    }
    Ok(walls)
}

/// A plot with two logarithmic axes, in which a cost proportional to the number of bricks is a straight line.
fn draw(walls: &[Wall], path: &Path) -> Result<(), Box<dyn Error>> {
    let area = Canvas::new(path, (640, 480)).into_drawing_area();
    area.fill(&WHITE)?;
    let (Some(first), Some(last)) = (walls.first(), walls.last()) else {
        return Ok(());
    };
    let bricks = 0.7 * first.bricks as f64..1.4 * last.bricks as f64;
    let times = 0.5 * first.step..2.0 * last.step;
    let mut chart = ChartBuilder::on(&area)
        .caption("A wall awake, one step of 1/60 s", ("sans-serif", 20))
        .margin(12)
        .x_label_area_size(46)
        .y_label_area_size(72)
        .build_cartesian_2d(bricks.log_scale(), times.log_scale())?;
    chart
        .configure_mesh()
        .x_desc("bricks")
        .y_desc("ms a step")
        .label_style(("sans-serif", 15))
        .axis_desc_style(("sans-serif", 16))
        .draw()?;
    let points = || walls.iter().map(|wall| (wall.bricks as f64, wall.step));
    let blue = RGBColor(20, 60, 200);
    chart.draw_series(LineSeries::new(points(), blue.stroke_width(3)))?;
    chart.draw_series(points().map(|point| Circle::new(point, 5, blue.filled())))?;
    area.present()?;
    Ok(())
}
