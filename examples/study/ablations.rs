//! Part 1: every method on every case with several budgets, compared at equal time.

use crate::baselines;
use crate::cases::{Case, Scope, TIMES, time_step};
use crate::methods::{DEFAULT, METHODS, Method};
use crate::runs::Finding;
use crate::tables::{Table, mm};
use drystone_lab::report::report;
use indicatif::ProgressBar;
use serde_json::Value;

/// A method with a budget on a case.
pub struct Trial {
    pub case: Case,
    pub method: &'static Method,
    pub iterations: usize,
    seeds: u64,
}

/// The result.
pub struct Record {
    pub trial: Trial,
    pub finding: Finding,
}

/// Times are called equal when this much apart: they are measured beside others.
const EQUAL: f64 = 1.1;

/// Everything that will be run.
pub fn trials(scope: Scope) -> Vec<Trial> {
    let mut trials = Vec::new();
    for case in scope.cases() {
        let wanted = |method: &&Method| !scope.baselines || baselines::has(method);
        for method in METHODS.iter().filter(wanted) {
            for iterations in scope.budgets(&case, method) {
                trials.push(Trial {
                    case,
                    method,
                    iterations,
                    seeds: scope.seeds(&case, method, iterations),
                });
            }
        }
    }
    trials
}

/// Runs all, one after the other: their times are compared.
pub fn run(trials: Vec<Trial>, bar: &ProgressBar) -> Vec<Record> {
    let run = |trial: Trial| {
        bar.set_message(format!("{}: {}", trial.case.name(), trial.method.label));
        let experiment = trial.method.experiment(&trial.case, trial.iterations);
        let finding = Finding::of(&experiment, trial.case.seconds, trial.seeds);
        bar.inc(1);
        Record { trial, finding }
    };
    trials.into_iter().map(run).collect()
}

impl Trial {
    /// Whether it has the number of iterations that its method is meant to have.
    pub fn has_own_iterations(&self) -> bool {
        self.iterations == self.method.own_iterations(&self.case)
    }
}

impl Record {
    /// The output of `simulate --json`, a line for each seed, and the method.
    pub fn json(&self) -> impl Iterator<Item = Value> {
        let Trial {
            case,
            method,
            iterations,
            ..
        } = &self.trial;
        (1..).zip(&self.finding.outcomes).map(|(seed, outcome)| {
            let experiment = method.experiment(case, *iterations).with_seed(seed);
            let steps = (case.seconds / case.dt).round() as usize;
            let mut fields = report(method.preset(), &experiment, steps, outcome);
            fields.insert("method".into(), method.label.into());
            Value::Object(fields)
        })
    }
}

/// The records of one case.
pub fn by_case(records: &[Record]) -> impl Iterator<Item = &[Record]> {
    records.chunk_by(|a, b| a.trial.case == b.trial.case)
}

/// Those of one method on a case, by rising iterations.
pub fn of_method<'a>(records: &'a [Record], method: &Method) -> Vec<&'a Record> {
    let of_method = |r: &&Record| r.trial.method.label == method.label;
    records.iter().filter(of_method).collect()
}

/// The tables of part 1: for each step length the results of all methods in the default's time, and the shortest time in which they stand.
pub fn tables(records: &[Record]) -> Vec<Table> {
    let mut tables = Vec::new();
    for (dt, ..) in TIMES {
        let cases: Vec<&[Record]> = by_case(records)
            .filter(|r| r[0].trial.case.dt == dt)
            .collect();
        let seconds = cases.first().map_or(0.0, |r| r[0].trial.case.seconds);
        let step = time_step(dt);
        tables.push(table(
            format!("At equal time, {step}"),
            format!(
                "Drift / sag after {seconds} s in mm, worst of the seeds, with (so many iterations): the most that cost no more than the \
                 default's in the last row, whose milliseconds a step stand there; where even the fewest cost more, those, and how many \
                 times as much. The time of what falls is that of its fall."
            ),
            &cases,
            at_equal_time,
        ));
        tables.push(table(
            format!("At equal iterations, {step}"),
            format!(
                "Drift / sag after {seconds} s in mm, rms speed in mm/s; milliseconds a step. With the preset's or the solver's \
                 iterations: 75 for the paper's solvers and APGD, 10 for AVBD, for Soft Step 16 a sixtieth of a second, and up to 24 \
                 until all is at rest. A dash where that takes too long to be run."
            ),
            &cases,
            at_own_iterations,
        ));
        tables.push(table(
            format!("The least that stands, {step}"),
            format!(
                "Least milliseconds a step with which everything stands for {seconds} s under all seeds, with (so many iterations), and \
                 the drift there in mm."
            ),
            &cases,
            least,
        ));
    }
    tables
}

fn table(
    title: String,
    note: String,
    cases: &[&[Record]],
    cell: fn(&[Record], &Method) -> String,
) -> Table {
    let scenes = cases.iter().map(|r| r[0].trial.case.scene.to_string());
    let was_run = |method: &&Method| {
        let records = cases.iter().copied().flatten();
        records
            .into_iter()
            .any(|r| r.trial.method.label == method.label)
    };
    let row = |method: &Method| {
        let cells = cases.iter().map(|records| cell(records, method));
        [method.label.to_owned()].into_iter().chain(cells).collect()
    };
    Table {
        title,
        note,
        columns: ["method".to_owned()].into_iter().chain(scenes).collect(),
        rows: METHODS.iter().filter(was_run).map(row).collect(),
    }
}

/// The default with its own iterations.
fn default(records: &[Record]) -> Option<&Record> {
    let is_default = |r: &&Record| r.trial.method.label == DEFAULT && r.trial.has_own_iterations();
    records.iter().find(is_default)
}

/// A method with the most iterations that cost no more than the default's on a case, or with the fewest if even those cost more.
pub fn affordable<'a>(records: &'a [Record], method: &Method) -> Option<&'a Record> {
    let default = default(records)?;
    if method.label == DEFAULT {
        return Some(default);
    }
    let own = of_method(records, method);
    let limit = default.finding.ms * EQUAL;
    let most = own.iter().rfind(|r| r.finding.ms <= limit);
    most.or(own.first()).copied()
}

fn at_equal_time(records: &[Record], method: &Method) -> String {
    let (Some(default), Some(record)) = (default(records), affordable(records, method)) else {
        return "–".into();
    };
    let Record { trial, finding } = record;
    let time = if method.label == DEFAULT {
        format!(", {:.3} ms", finding.ms)
    } else if finding.ms <= default.finding.ms * EQUAL {
        String::new()
    } else {
        format!(", {:.1} ×", finding.ms / default.finding.ms)
    };
    let figures = || format!("{} / {}", mm(finding.drift), mm(finding.sag));
    let figures = finding.fate().unwrap_or_else(figures);
    format!("{figures} ({}{time})", trial.iterations)
}

fn at_own_iterations(records: &[Record], method: &Method) -> String {
    let own = of_method(records, method);
    let meant = own.iter().find(|r| r.trial.has_own_iterations());
    meant.map_or("–".into(), |Record { finding, .. }| {
        let (drift, sag) = (mm(finding.drift), mm(finding.sag));
        let jitter = 1e3 * finding.rms_speed;
        let figures = || format!("{drift} / {sag}, {jitter:.2}");
        let figures = finding.fate().unwrap_or_else(figures);
        format!("{figures}; {:.3} ms", finding.ms)
    })
}

fn least(records: &[Record], method: &Method) -> String {
    let own = of_method(records, method);
    let least = own.iter().find(|r| r.finding.stands());
    least.map_or("–".into(), |Record { trial, finding }| {
        let drift = mm(finding.drift);
        format!("{:.3} ms ({}): {drift}", finding.ms, trial.iterations)
    })
}
