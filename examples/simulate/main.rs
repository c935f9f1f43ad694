//! The headless workhorse: any scene under any setting, one JSON line a seed.
//!
//! ```text
//! cargo run --release --example simulate -- --scene wall:10x10 --preset paper --steps 600 --seeds 1,2,3 --json
//! ```

mod arguments;

use arguments::Arguments;
use clap::Parser;
use drystone_lab::report::report;
use serde_json::{Map, Value};
use std::io::Write;
use std::process::ExitCode;

fn table(out: &mut impl Write, fields: &Map<String, Value>) -> std::io::Result<()> {
    for (name, value) in fields {
        match value {
            Value::Object(rows) => {
                writeln!(out, "{name}:")?;
                for (name, value) in rows {
                    match (value.get("ms_median"), value.get("ms_p95")) {
                        (Some(median), Some(p95)) => {
                            writeln!(out, "  {name:<24} {median:>9} ms   95 %: {p95} ms")?;
                        }
                        _ => writeln!(out, "  {name:<24} {value}")?,
                    }
                }
            }
            _ => writeln!(out, "{name:<26} {value}")?,
        }
    }
    writeln!(out)
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let experiment = match arguments.experiment() {
        Ok(experiment) => experiment,
        Err(error) => {
            eprintln!("{error}");
            return ExitCode::from(2);
        }
    };
    let mut out = std::io::stdout().lock();
    for &seed in &arguments.seeds {
        let experiment = experiment.clone().with_seed(seed);
        let outcome = experiment.run(arguments.steps);
        let fields = report(arguments.preset(), &experiment, arguments.steps, &outcome);
        let written = if arguments.json {
            writeln!(out, "{}", Value::Object(fields))
        } else {
            table(&mut out, &fields)
        };
        if written.is_err() {
            // The reader of the output has closed it.
            return ExitCode::SUCCESS;
        }
    }
    ExitCode::SUCCESS
}
