//! The time of every stage of a step, for scenes of increasing size.
//!
//! ```text
//! cargo run --release --example profile -- [--scenes wall:10x10,wall:40x25] [--threads 1] [--trace target/profile/trace.json]
//! ```
//!
//! Prints a table, and writes `profile.csv` and `profile.png` to `target/profile`. A trace opens in <https://ui.perfetto.dev>.

use clap::Parser;
use drystone::settings::{PhysicsThreads, Preset};
use drystone_lab::experiment::Experiment;
use drystone_lab::plots::{Canvas, Stroke, bring_font, legend};
use drystone_lab::scenes::Scene;
use plotters::prelude::*;
use std::error::Error;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;
use tracing_chrome::ChromeLayerBuilder;
use tracing_subscriber::prelude::*;

/// Measures the time of each stage.
#[derive(Parser)]
struct Arguments {
    /// The scenes to step, in the order in which they are shown.
    #[arg(
        long,
        value_delimiter = ',',
        default_value = "wall:10x10,wall:20x15,wall:40x25,wall:100x50"
    )]
    scenes: Vec<Scene>,
    /// Steps of a sixtieth of a second; the median of each stage is told.
    #[arg(long, default_value_t = 200, value_parser = clap::value_parser!(u32).range(1..))]
    steps: u32,
    /// Threads.
    #[arg(long, default_value_t = 1)]
    threads: usize,
    /// Let bodies at rest sleep.
    #[arg(long)]
    sleeping: bool,
    /// Where results go.
    #[arg(long, default_value = "target/profile")]
    out: PathBuf,
    /// Writes a span for every stage of every step, in Chrome's format.
    #[arg(long)]
    trace: Option<PathBuf>,
}

fn main() -> ExitCode {
    match profile(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::from(2)
        }
    }
}

/// The cost of a scene.
struct Cost {
    scene: String,
    bodies: usize,
    step: Duration,
    /// By stage, in the order of a step.
    stages: Vec<(&'static str, Duration)>,
}

fn profile(arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    let out = &arguments.out;
    fs::create_dir_all(out)?;
    bring_font()?;
    // Written when it is dropped.
    let _trace = arguments.trace.as_ref().map(|path| {
        let (layer, guard) = ChromeLayerBuilder::new()
            .file(path)
            .include_args(true)
            .build();
        tracing_subscriber::registry().with(layer).init();
        guard
    });
    let costs = arguments
        .scenes
        .iter()
        .map(|scene| cost(*scene, arguments))
        .collect::<Result<Vec<Cost>, _>>()?;
    println!("{}", table(&costs));
    fs::write(out.join("profile.csv"), csv(&costs))?;
    draw(&costs, &out.join("profile.png"))?;
    println!("profile.csv and profile.png are in {}", out.display());
    Ok(())
}

fn cost(scene: Scene, arguments: &Arguments) -> Result<Cost, Box<dyn Error>> {
    let mut experiment = Experiment::new(scene, Preset::Default);
    experiment.threads = PhysicsThreads::new(arguments.threads)?;
    experiment.sleeping.enabled = arguments.sleeping;
    let outcome = experiment.run(arguments.steps as usize);
    let median = |name: &str| outcome.system_times.get(name).map(|time| time.median);
    Ok(Cost {
        scene: scene.to_string(),
        bodies: outcome.bodies,
        step: outcome.step_time.median,
        stages: STAGES
            .iter()
            .filter_map(|(name, _)| Some((*name, median(name)?)))
            .collect(),
    })
}

/// The stages in the order of a step, and their colours.
const STAGES: [(&str, (u8, u8, u8)); 14] = [
    ("prepare", (130, 130, 130)),
    ("broadphase", (90, 50, 130)),
    ("narrowphase", (170, 90, 170)),
    ("islands", (210, 120, 200)),
    ("friction_error", (240, 150, 40)),
    ("normal_correction", (250, 200, 90)),
    ("forces", (150, 200, 60)),
    ("warm_start", (90, 140, 240)),
    ("solve", (20, 60, 200)),
    ("anchors", (225, 60, 40)),
    ("integration", (60, 160, 60)),
    ("sleeping", (100, 190, 250)),
    ("sensors", (200, 190, 60)),
    ("contact_events", (20, 170, 160)),
];

/// µs a body, as all else is.
fn each(time: Duration, bodies: usize) -> f64 {
    1e6 * time.as_secs_f64() / bodies.max(1) as f64
}

fn table(costs: &[Cost]) -> String {
    let mut text = String::from("µs a body and step, medians\n\n| stage |");
    for cost in costs {
        _ = write!(text, " {} ({}) |", cost.scene, cost.bodies);
    }
    text += "\n|---|";
    text += &"---|".repeat(costs.len());
    for (row, (name, _)) in STAGES.iter().enumerate() {
        _ = write!(text, "\n| {name} |");
        for cost in costs {
            _ = write!(text, " {:.3} |", each(cost.stages[row].1, cost.bodies));
        }
    }
    text += "\n| whole step |";
    for cost in costs {
        _ = write!(text, " {:.3} |", each(cost.step, cost.bodies));
    }
    text + "\n"
}

fn csv(costs: &[Cost]) -> String {
    let mut text = String::from("scene,bodies,stage,ms\n");
    for cost in costs {
        let whole = ("step", cost.step);
        for (stage, time) in cost.stages.iter().copied().chain([whole]) {
            let ms = 1e3 * time.as_secs_f64();
            _ = writeln!(text, "{},{},{stage},{ms:.6}", cost.scene, cost.bodies);
        }
    }
    text
}

/// A bar a scene, its stages on each other.
fn draw(costs: &[Cost], path: &Path) -> Result<(), Box<dyn Error>> {
    const LEGEND: u32 = 110;
    let area = Canvas::new(path, (760, 480 + LEGEND)).into_drawing_area();
    area.fill(&WHITE)?;
    let (above, below) = area.split_vertically(480);
    let whole = |cost: &Cost| -> f64 {
        let stages = cost.stages.iter();
        stages.map(|(_, time)| each(*time, cost.bodies)).sum()
    };
    let highest = costs.iter().map(whole).fold(0.0, f64::max);
    let mut chart = ChartBuilder::on(&above)
        .caption("What a step costs", ("sans-serif", 20))
        .margin(10)
        .x_label_area_size(42)
        .y_label_area_size(72)
        .build_cartesian_2d(0.0..costs.len() as f64, 0.0..highest * 1.1)?;
    let name = |x: &f64| {
        let cost = costs.get(x.floor() as usize);
        let middle = (x.fract() - 0.5).abs() < 1e-6;
        let name = cost.filter(|_| middle).map(|cost| cost.scene.clone());
        name.unwrap_or_default()
    };
    chart
        .configure_mesh()
        .y_desc("µs a body and step")
        .label_style(("sans-serif", 15))
        .axis_desc_style(("sans-serif", 16))
        .disable_x_mesh()
        .light_line_style(WHITE)
        .x_labels(2 * costs.len() + 1)
        .x_label_formatter(&name)
        .draw()?;
    for (i, cost) in costs.iter().enumerate() {
        let (left, right) = (i as f64 + 0.2, i as f64 + 0.8);
        let mut bottom = 0.0;
        for ((_, time), (_, (r, g, b))) in cost.stages.iter().zip(STAGES) {
            let top = bottom + each(*time, cost.bodies);
            let corners = [(left, bottom), (right, top)];
            let color = RGBColor(r, g, b).filled();
            chart.draw_series([Rectangle::new(corners, color)])?;
            bottom = top;
        }
    }
    let strokes = STAGES.map(|(name, color)| {
        let stroke = Stroke {
            color,
            width: 8,
            dashed: false,
        };
        (Some(stroke), name.to_owned())
    });
    legend(&below, 4, strokes)?;
    area.present()?;
    Ok(())
}
