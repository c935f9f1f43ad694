//! One table of time and steadiness: the standard scenes in all engines, as Markdown, CSV and a plot.

mod plot;
mod text;

pub use text::{Updated, mm, ms};

use crate::compare::{self, Comparison};
use crate::meter::Outcome;
use crate::run::{RunArguments, count};
use clap::Args;
use drystone_lab::scenes::Scene;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Walls, a pyramid, a stack, a heap, an arch, and a weight on a stack.
const STANDARD: &str =
    "wall:10x10,wall:40x25,wall:100x50,pyramid:50,stack:20,heap:1000,arch:15,massratio:100";

/// The scenes that are run, and the output folder.
#[derive(Args)]
pub struct Table {
    /// The scenes, in the order in which they are shown.
    #[arg(long, value_delimiter = ',', default_value = STANDARD)]
    scenes: Vec<Scene>,
    #[command(flatten)]
    run: RunArguments,
    /// How often each comparison is run; of times and ratios the median is told.
    #[arg(long, default_value_t = 3, value_parser = count)]
    runs: usize,
    /// The folder in which `table.md`, `table.csv` and `table.png` are written.
    #[arg(long, default_value = "target/peers")]
    out: PathBuf,
    /// Where a copy of the plot goes.
    #[arg(long)]
    picture: Option<PathBuf>,
    /// A Markdown file in which the table takes the place of what is between `<!-- peers table -->` and `<!-- end -->`.
    #[arg(long)]
    update: Option<PathBuf>,
}

/// The results of a scene in all engines.
struct Row {
    scene: Scene,
    bodies: usize,
    /// Drystone first.
    cells: Vec<Cell>,
}

/// The result of a scene in one engine.
struct Cell {
    engine: &'static str,
    /// Medians over the runs.
    median: Duration,
    p95: Duration,
    /// Drystone's time over this one's.
    ratio: f64,
    /// Of the first run. Every run ends alike, unless an engine does not with several threads.
    outcome: Outcome,
}

impl Table {
    /// # Errors
    /// If an engine cannot have a scene, or something cannot be written: before anything is run, as far as that can be told.
    pub fn make(&self) -> Result<(), String> {
        let out = &self.out;
        fs::create_dir_all(out).map_err(|why| cannot_write(out, &why))?;
        let updated = self
            .update
            .as_deref()
            .map(|path| text::Updated::read(path, "peers table"))
            .transpose()?;
        let mut rows = Vec::new();
        for &scene in &self.scenes {
            eprintln!("{scene} …");
            rows.push(self.row(scene)?);
        }
        let markdown = text::markdown(&rows, &self.conditions());
        print!("{markdown}");
        let write =
            |path: &Path, what: &str| fs::write(path, what).map_err(|why| cannot_write(path, &why));
        write(&out.join("table.md"), &markdown)?;
        write(&out.join("table.csv"), &text::csv(&rows, &self.run))?;
        let picture = out.join("table.png");
        plot::draw(&rows, &self.conditions(), &picture)
            .map_err(|why| cannot_write(&picture, &*why))?;
        if let Some(path) = &self.picture {
            fs::copy(&picture, path).map_err(|why| cannot_write(path, &why))?;
        }
        if let Some(updated) = updated {
            write(updated.path, &updated.with(&markdown))?;
        }
        eprintln!("table.md, table.csv and table.png are in {}", out.display());
        Ok(())
    }

    fn row(&self, scene: Scene) -> Result<Row, String> {
        let run = |_| {
            let comparison = compare::compare(scene, 1, &self.run)?;
            match comparison.refused.first() {
                None => Ok(comparison),
                Some(why) => Err(format!("--scenes {scene}: {why}")),
            }
        };
        let mut runs = (0..self.runs).map(run).collect::<Result<Vec<_>, _>>()?;
        let cells: Vec<_> = (0..runs[0].engines.len())
            .map(|i| {
                let over = |of: &dyn Fn(&Comparison) -> f64| median(runs.iter().map(of).collect());
                let time = |of: fn(&Outcome) -> Duration| {
                    let seconds = |run: &Comparison| of(&run.engines[i].outcome).as_secs_f64();
                    Duration::from_secs_f64(over(&seconds))
                };
                let median = time(|outcome| outcome.step_time.median);
                let p95 = time(|outcome| outcome.step_time.p95);
                (median, p95, over(&|run| run.ratio(&run.engines[i])))
            })
            .collect();
        let first = runs.swap_remove(0);
        let cells = first.engines.into_iter().zip(cells);
        let cells = cells.map(|(entry, (median, p95, ratio))| Cell {
            engine: entry.name,
            median,
            p95,
            ratio,
            outcome: entry.outcome,
        });
        Ok(Row {
            scene,
            bodies: first.bodies,
            cells: cells.collect(),
        })
    }

    /// In a line, for who reads the figures elsewhere.
    fn conditions(&self) -> String {
        let first = self.scenes[0];
        let course = self.run.course(first);
        let conditions = self.run.conditions(first);
        let threads = match conditions.threads {
            1 => "one thread".to_owned(),
            n => format!("{n} threads"),
        };
        let (steps, turn, runs) = (course.steps, course.turn, self.runs);
        let dt = 1e3 * conditions.dt;
        let runs = match runs {
            1 => "one run".to_owned(),
            n => format!("medians of {n} runs"),
        };
        let machine = processor();
        format!("{steps} steps of {dt:.1} ms in turns of {turn}, {threads}, {runs}, {machine}")
    }
}

/// The middle one.
pub fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// As the operating system names it.
pub fn processor() -> String {
    let info = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let line = info
        .lines()
        .find_map(|line| line.strip_prefix("model name"));
    let name = line.and_then(|rest| rest.split_once(':'));
    name.map_or("unknown processor", |(_, name)| name.trim())
        .to_owned()
}

/// The message for a file that cannot be written.
pub fn cannot_write(path: &Path, why: &dyn std::fmt::Display) -> String {
    format!("{}: cannot be written: {why}", path.display())
}
