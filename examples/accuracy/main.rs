//! Measures closed-form results and writes `docs/accuracy.md`: reference, tolerance and measured values, over solvers and steps, with
//! plots.
//!
//! `cargo run --release --example accuracy` writes the document. `-- --quick` measures what is cheap with the default solver at 60 Hz,
//! writes nothing, and fails if a value is missed that the document does not have as missed.

mod arches;
mod document;
mod known;
mod momentum;
mod plots;
mod runs;

use clap::Parser;
use drystone_lab::plots::bring_font;
use runs::Missed;
use std::error::Error;
use std::fs;
use std::path::Path;
use std::process::ExitCode;
use support::Lab;
use support::accuracy::{Settings, gauss_seidel};

/// Measures closed-form results.
#[derive(Parser)]
struct Arguments {
    /// Only what is cheap, with the default solver at 60 Hz. Writes nothing, and fails if a value is missed that was not missed before.
    #[arg(long)]
    quick: bool,
    /// Only measurements whose heading begins so. Writes nothing.
    #[arg(long)]
    only: Option<String>,
}

/// A solver by its name.
type Solver = (&'static str, Settings);

/// The default first.
const SOLVERS: [Solver; 3] = [
    ("Soft Step", Lab::shipped),
    ("NNCG", Lab::exact),
    ("PGS", gauss_seidel),
];

/// Steps by their names, s. The last one shows to which value the others converge.
const STEPS: [(&str, f32); 4] = [
    ("0.1 s", 0.1),
    ("1/60 s", 1.0 / 60.0),
    ("1/240 s", 1.0 / 240.0),
    ("1/960 s", 1.0 / 960.0),
];

/// The index of 1/60 s.
const SIXTIETH: usize = 1;

fn main() -> ExitCode {
    match measure(Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

fn measure(Arguments { quick, only }: Arguments) -> Result<(), Box<dyn Error>> {
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs");
    let path = docs.join("accuracy.md");
    let before = fs::read_to_string(&path)?;
    let jobs = runs::jobs(|job| {
        let wanted = only.as_ref();
        let short = job.case.quick && job.solver == 0 && job.step == SIXTIETH;
        (short || !quick) && wanted.is_none_or(|start| job.case.title.starts_with(start))
    });
    let whole = !quick && only.is_none();
    let extra = whole.then(|| (arches::measure(), momentum::measure()));
    let records = runs::run_all(&jobs);
    if let Some((arches, momentum)) = &extra {
        bring_font()?;
        fs::write(&path, document::write(&records, arches, momentum))?;
        plots::draw(&records, arches, momentum, &docs.join("pictures"))?;
    }
    let missed = records.iter().flat_map(|record| record.missed());
    let (known, new): (Vec<Missed>, Vec<Missed>) =
        missed.partition(|missed| known::is_missed(&before, missed));
    println!("{} missed as before, {} newly", known.len(), new.len());
    match new.is_empty() {
        true => Ok(()),
        false => {
            let lines: Vec<String> = new.iter().map(Missed::to_string).collect();
            Err(format!("newly missed:\n{}", lines.join("\n")).into())
        }
    }
}
