//! The contribution of each part of the method, from the paper to the default, at equal time; the paper's open questions; and solvers from
//! the literature beside both.
//!
//! ```text
//! cargo run --release --example study -- [--quick] [--baselines] [--out target/study]
//! ```
//!
//! Writes `study.md`, `study.json`, `runs.jsonl` and a plot for each case to `target/study`. All but times is the same in every run.

mod ablations;
mod baselines;
mod cases;
mod methods;
mod plots;
mod questions;
mod runs;
mod tables;

use cases::Scope;
use clap::Parser;
use drystone_lab::output;
use drystone_lab::plots::bring_font;
use indicatif::{ProgressBar, ProgressStyle};
use questions::Question;
use serde_json::Value;
use std::error::Error;
use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use tables::Table;

/// Measures the contribution of each part of the method.
#[derive(Parser)]
struct Arguments {
    /// Fewer scenes, shorter, one seed: ends within a minute.
    #[arg(long)]
    quick: bool,
    /// Only the solvers from the literature beside the paper's and the default; not the paper's questions.
    #[arg(long)]
    baselines: bool,
    /// Where results go.
    #[arg(long, default_value = "target/study")]
    out: PathBuf,
}

fn main() -> ExitCode {
    match measure(Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::from(2)
        }
    }
}

fn measure(
    Arguments {
        quick,
        baselines,
        out,
    }: Arguments,
) -> Result<(), Box<dyn Error>> {
    let lines = output::begin(&out)?;
    bring_font()?;
    // All of it on one thread of rayon's, so that no step is handed over to another.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let study = pool.install(|| study(Scope { quick, baselines }));
    study.write(lines, &out)?;
    println!(
        "\nplots, study.md, study.json and runs.jsonl are in {}",
        out.display()
    );
    Ok(())
}

struct Study {
    records: Vec<ablations::Record>,
    tables: Vec<Table>,
}

fn study(scope: Scope) -> Study {
    let trials = ablations::trials(scope);
    let questions = match scope.baselines {
        true => Vec::new(),
        false => questions::questions(),
    };
    let cells: usize = questions.iter().map(Question::cells).sum();
    let style = "{elapsed:>4} {wide_bar} {pos}/{len}, {msg}";
    let style = ProgressStyle::with_template(style).expect("the template is valid");
    let length = (trials.len() + cells) as u64 + baselines::cells();
    let bar = ProgressBar::new(length).with_style(style);
    let answers: Vec<Table> = questions.iter().map(|q| q.answer(scope, &bar)).collect();
    let records = ablations::run(trials, &bar);
    let baselines = vec![baselines::table(&records, &bar)];
    bar.finish_and_clear();
    let tables = [ablations::tables(&records), baselines, answers].concat();
    Study { records, tables }
}

impl Study {
    fn write(&self, mut lines: File, out: &Path) -> Result<(), Box<dyn Error>> {
        plots::draw(&self.records, out)?;
        for line in self.records.iter().flat_map(ablations::Record::json) {
            writeln!(lines, "{line}")?;
        }
        let tables: Vec<Value> = self.tables.iter().map(Table::json).collect();
        let json = serde_json::to_string_pretty(&tables)?;
        fs::write(out.join("study.json"), json)?;
        let sections: Vec<String> = self.tables.iter().map(Table::to_string).collect();
        let text = sections.join("\n");
        fs::write(out.join("study.md"), &text)?;
        println!("{text}");
        Ok(())
    }
}
