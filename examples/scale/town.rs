//! Towns of up to a million bricks asleep: how long they take until they are ready, what a brick weighs, what a step and a ray cost, and
//! what it costs to play on one of the walls.
//!
//! Each town is measured in a process of its own, so that its memory is that of the process.

use super::{Arguments, Site};
use bevy_ecs::entity::Entity;
use drystone::prelude::*;
use drystone::settings::PhysicsThreads;
use drystone::streaming;
use drystone_lab::memory;
use drystone_lab::play::{Script, Session};
use drystone_lab::plots::{Canvas, bring_font};
use drystone_lab::town;
use plotters::coord::Shift;
use plotters::prelude::*;
use std::error::Error;
use std::fs;
use std::path::Path;
use std::process::Command;
use std::time::Instant;

/// Numbers of walls of the towns. The first wall is small.
const TOWNS: [u32; 5] = [0, 1, 10, 100, 1000];

/// Bricks in a course, and courses.
const WALL: [u32; 2] = [40, 25];
const SMALL: [u32; 2] = [10, 10];

/// Distance between the walls of a street, m.
const APART: f32 = 3.0;

/// Names of the columns.
const HEAD: &str = "bricks,spawn_ms,first_step_ms,later_steps_ms,kilobytes_a_brick,peak_kilobytes_a_brick,step_ms,ray_us,play_ms,\
    play_p99_ms,play_longest_ms,play_awake,out_and_in_ms";

/// What was measured of a town; in the order of [`HEAD`].
type Row = [f64; 13];

/// Measures all towns, and draws them.
pub fn measure(arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    fs::create_dir_all(&arguments.out)?;
    bring_font()?;
    let threads = arguments.threads.unwrap_or(0);
    let mut rows: Vec<Row> = Vec::new();
    let mut csv = format!("{HEAD}\n");
    println!(
        "| bricks | spawned + first step, s | the two steps after, ms | kB a brick, at its peak | a step, ms | a ray, µs | play: mean, \
         p99, longest, ms | awake | 1 000 out and in, ms |\n|---|---|---|---|---|---|---|---|---|"
    );
    for walls in TOWNS {
        let town = Command::new(std::env::current_exe()?)
            .args(["--town", &walls.to_string()])
            .args(["--threads", &threads.to_string()])
            .output()?;
        if !town.status.success() {
            return Err(String::from_utf8_lossy(&town.stderr).into());
        }
        let line = String::from_utf8(town.stdout)?;
        csv.push_str(&line);
        let numbers: Result<Vec<f64>, _> = line.trim().split(',').map(str::parse).collect();
        let row: Row = numbers?
            .try_into()
            .map_err(|numbers| format!("{numbers:?}"))?;
        let [
            bricks,
            spawn,
            first,
            later,
            kilobytes,
            peak,
            step,
            ray,
            mean,
            p99,
            longest,
            awake,
            out_and_in,
        ] = row;
        println!(
            "| {bricks} | {:.3} | {later:.1} | {kilobytes:.2}, {peak:.2} | {step:.3} | {ray:.2} | {mean:.3}, {p99:.2}, {longest:.2} | \
             {awake:.0} | {out_and_in:.2} |",
            1e-3 * (spawn + first)
        );
        rows.push(row);
    }
    fs::write(arguments.out.join("town.csv"), csv)?;
    draw(&rows, &arguments.out.join("town.png"))?;
    println!("\ntown.csv and town.png are in {}", arguments.out.display());
    Ok(())
}

/// Measures one town, and prints its row.
pub fn measure_one(walls: u32, arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    let before = memory::resident()?;
    let wall = if walls == 0 { SMALL } else { WALL };
    let walls = walls.max(1);
    let mut site = Site::new(arguments.threads.unwrap_or(0), true)?;
    let start = Instant::now();
    let bricks = town::build(site.app.world_mut(), wall, walls, APART)?;
    let spawn = 1e3 * start.elapsed().as_secs_f64();
    let count = bricks.len() as f64;
    let first = site.step();
    let later = site.step() + site.step();
    let kilobytes = (memory::resident()? - before) / count;
    let peak = (memory::peak()? - before) / count;
    site.app
        .world_mut()
        .insert_resource(PhysicsThreads::new(1)?);
    let [step, _] = site.steps(200);
    let ray = rays(&mut site, wall);
    let out_and_in = stream(&mut site, &bricks)?;
    let world = std::mem::take(site.app.world_mut());
    let mut session = Session::new(world, Script::Build(wall), 1, 1.0 / 60.0);
    session.steps(600);
    let cost = session.cost();
    let millis = |time: std::time::Duration| 1e3 * time.as_secs_f64();
    let row: Row = [
        count,
        spawn,
        first,
        later,
        kilobytes,
        peak,
        step,
        ray,
        millis(cost.mean),
        millis(cost.p99),
        millis(cost.longest),
        cost.awake.into(),
        out_and_in,
    ];
    let row: Vec<String> = row.iter().map(f64::to_string).collect();
    println!("{}", row.join(","));
    Ok(())
}

/// The mean time of a ray through the first wall, µs.
fn rays(site: &mut Site, [columns, courses]: [u32; 2]) -> f64 {
    const RAYS: u32 = 20_000;
    let mut rng = fastrand::Rng::with_seed(1);
    let mut hits = 0;
    let time = spatial_query(site.app.world_mut(), |query| {
        let start = Instant::now();
        for _ in 0..RAYS {
            let x = (rng.f32() - 0.5) * columns as f32;
            let y = rng.f32() * 0.5 * courses as f32;
            let ray = Ray3d::new(Vec3::new(x, y, 20.0), Dir3::NEG_Z);
            let hit = query.cast_ray(ray, 100.0, &QueryFilter::default());
            hits += u32::from(matches!(hit, Ok(Some(_))));
        }
        start.elapsed()
    });
    assert!(hits > RAYS / 2, "{hits} rays hit the wall");
    1e6 * time.as_secs_f64() / f64::from(RAYS)
}

/// The median time to take the last thousand bricks out and to put them back, with a step after each, ms.
fn stream(site: &mut Site, bricks: &[Entity]) -> Result<f64, Box<dyn Error>> {
    let some = &bricks[bricks.len().saturating_sub(1000)..];
    let mut times = Vec::new();
    for _ in 0..11 {
        let start = Instant::now();
        let world = site.app.world_mut();
        let region = streaming::take_out(world, some.iter().copied())?;
        site.step();
        let left_out = streaming::put_back(site.app.world_mut(), region);
        site.step();
        times.push(1e3 * start.elapsed().as_secs_f64());
        assert!(left_out.is_empty());
    }
    times.sort_by(f64::total_cmp);
    Ok(times[times.len() / 2])
}

/// Draws step, time and memory over the number of bricks.
fn draw(rows: &[Row], path: &Path) -> Result<(), Box<dyn Error>> {
    let area = Canvas::new(path, (1080, 380)).into_drawing_area();
    area.fill(&WHITE)?;
    let charts = area.split_evenly((1, 3));
    let of = |value: fn(&Row) -> f64| -> Vec<(f64, f64)> {
        rows.iter().map(|row| (row[0], value(row))).collect()
    };
    chart(&charts[0], "a step, all asleep", "ms", &of(|row| row[6]))?;
    chart(
        &charts[1],
        "until ready",
        "s",
        &of(|row| 1e-3 * (row[1] + row[2])),
    )?;
    chart(&charts[2], "memory", "kB a brick", &of(|row| row[4]))?;
    area.present()?;
    Ok(())
}

type Panel<'a> = DrawingArea<Canvas<'a>, Shift>;

/// A chart with two logarithmic axes.
fn chart(
    area: &Panel,
    caption: &str,
    unit: &str,
    points: &[(f64, f64)],
) -> Result<(), Box<dyn Error>> {
    let least = points.iter().map(|point| point.1).fold(f64::MAX, f64::min);
    let most = points.iter().map(|point| point.1).fold(0.0, f64::max);
    let (first, last) = (points[0].0, points[points.len() - 1].0);
    let mut chart = ChartBuilder::on(area)
        .caption(caption, ("sans-serif", 18))
        .margin(8)
        .margin_right(28)
        .x_label_area_size(42)
        .y_label_area_size(58)
        .build_cartesian_2d(
            (0.7 * first..1.4 * last).log_scale(),
            (0.5 * least..2.0 * most).log_scale(),
        )?;
    chart
        .configure_mesh()
        .x_desc("bricks")
        .y_desc(unit)
        .x_labels(5)
        .x_label_formatter(&f64::to_string)
        .y_labels(5)
        .y_label_formatter(&|value| format!("{}", (1e4 * value).round() / 1e4))
        .label_style(("sans-serif", 13))
        .axis_desc_style(("sans-serif", 15))
        .draw()?;
    let blue = RGBColor(20, 60, 200);
    let points = || points.iter().copied();
    chart.draw_series(LineSeries::new(points(), blue.stroke_width(3)))?;
    chart.draw_series(points().map(|point| Circle::new(point, 5, blue.filled())))?;
    Ok(())
}
