//! Reruns the paper's experiments: the rows of its Table 1 on stacks, walls and the task of its Figure 1, and draws its
//! Figures 1, 3 and 4.
//!
//! ```text
//! cargo run --release --example paper
//! ```
//!
//! Writes `report.html`, which has everything in one file, and `runs.jsonl`, plots and pictures to `target/paper`, and prints a table.

mod claims;
mod figures;
mod html;
mod machine;
mod numbers;
mod plots;
mod prototype;
mod report;
mod rows;
mod runs;
mod table;

use clap::Parser;
use drystone_lab::output;
use drystone_lab::plots::bring_font;
use drystone_lab::scenes::Scene;
use rows::ROWS;
use runs::Job;
use std::error::Error;
use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

/// Reruns the paper's experiments.
#[derive(Parser)]
struct Arguments {
    /// Fewer scenes and 12 s instead of 60 s simulated: ends within a minute.
    #[arg(long)]
    quick: bool,
    /// Where results go.
    #[arg(long, default_value = "target/paper")]
    out: PathBuf,
}

const STACKS: [Scene; 3] = [Scene::Stack(3), Scene::Stack(5), Scene::Stack(10)];
const WALLS: [Scene; 3] = [Scene::Wall(3, 3), Scene::Wall(6, 6), Scene::Wall(10, 10)];
const TASK: Scene = Scene::Pressed(5);

fn main() -> ExitCode {
    match rerun(Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::from(2)
        }
    }
}

fn rerun(Arguments { quick, out }: Arguments) -> Result<(), Box<dyn Error>> {
    let mut lines = output::begin(&out)?;
    bring_font()?;

    let (scenes, seconds) = if quick {
        println!("quick: fewer scenes, 12 s simulated instead of 60 s");
        (vec![STACKS[1], WALLS[0], WALLS[2], TASK], 12.0)
    } else {
        ([&STACKS[..], &WALLS[..], &[TASK]].concat(), 60.0)
    };
    let on_all_rows = |&scene: &Scene| {
        ROWS.iter().map(move |row| Job {
            scene,
            row,
            seconds,
        })
    };
    let jobs: Vec<Job> = scenes.iter().flat_map(on_all_rows).collect();
    let start = Instant::now();
    let records = runs::run_all(&jobs);
    let took = start.elapsed();

    for record in &records {
        writeln!(lines, "{}", record.json())?;
    }
    plots::draw(&records, &out)?;
    figures::draw(&records, &out)?;
    report::write(&records, took, &out)?;
    table::print(&records);
    println!(
        "\n{}, runs.jsonl, plots, figures and frames are in {}",
        report::FILE,
        out.display()
    );
    Ok(())
}
