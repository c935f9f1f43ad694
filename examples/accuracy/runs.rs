//! Takes measurements, several at a time.

use crate::{SOLVERS, STEPS};
use std::fmt::{self, Display, Formatter};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;
use support::accuracy::{CASES, Case, Value};

/// A measurement with a solver at a step.
#[derive(Clone, Copy)]
pub struct Job {
    /// What is measured.
    pub case: &'static Case,
    /// Index into [`SOLVERS`].
    pub solver: usize,
    /// Index into [`STEPS`].
    pub step: usize,
}

/// What a job found.
pub struct Record {
    /// The job.
    pub job: Job,
    /// What it measured.
    pub values: Vec<Value>,
}

/// A value that is off by more than its tolerance.
#[derive(Clone, Debug, PartialEq)]
pub struct Missed {
    /// As in [`Value::what`].
    pub what: String,
    /// Name of the solver.
    pub solver: &'static str,
    /// Name of the step.
    pub step: &'static str,
}

impl Display for Missed {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        write!(f, "{}; {}, {}", self.what, self.solver, self.step)
    }
}

impl Record {
    /// What it missed.
    pub fn missed(&self) -> impl Iterator<Item = Missed> {
        let missed = self.values.iter().filter(|value| value.is_missed());
        missed.map(|value| Missed {
            what: value.what.clone(),
            solver: SOLVERS[self.job.solver].0,
            step: STEPS[self.job.step].0,
        })
    }
}

/// The measurements that are wanted. Where the solver of contacts does not matter, only the first one is asked.
pub fn jobs(wanted: impl Fn(&Job) -> bool) -> Vec<Job> {
    let mut jobs = Vec::new();
    for case in &CASES {
        let solvers = if case.solved { SOLVERS.len() } else { 1 };
        let steps = STEPS.len() - usize::from(!case.finest);
        for solver in 0..solvers {
            jobs.extend((0..steps).map(|step| Job { case, solver, step }));
        }
    }
    jobs.retain(wanted);
    jobs
}

/// Takes all measurements, as many at once as there are cores; records come in the order of the jobs.
pub fn run_all(jobs: &[Job]) -> Vec<Record> {
    let next = AtomicUsize::new(0);
    let records: Vec<Mutex<Option<Record>>> = jobs.iter().map(|_| Mutex::new(None)).collect();
    // Short steps take the longest, and come first.
    let mut order: Vec<usize> = (0..jobs.len()).collect();
    order.sort_by_key(|&i| std::cmp::Reverse(jobs[i].step));
    let work = || {
        while let Some(&i) = order.get(next.fetch_add(1, Ordering::Relaxed)) {
            *records[i].lock().expect("no measurement panics") = Some(jobs[i].run());
        }
    };
    let cores = thread::available_parallelism().map_or(1, usize::from);
    thread::scope(|scope| {
        for _ in 0..cores.min(jobs.len()) {
            scope.spawn(work);
        }
    });
    let done = |slot: Mutex<Option<Record>>| slot.into_inner().expect("no measurement panics");
    records.into_iter().filter_map(done).collect()
}

impl Job {
    fn run(self) -> Record {
        let start = std::time::Instant::now();
        let (solver, settings) = SOLVERS[self.solver];
        let (step, dt) = STEPS[self.step];
        let values = (self.case.measure)(settings, dt).list();
        let lines: Vec<String> = values.iter().map(|value| format!("  {value}")).collect();
        let seconds = start.elapsed().as_secs_f32();
        println!(
            "{}, {solver}, {step} ({seconds:.1} s)\n{}",
            self.case.title,
            lines.join("\n")
        );
        Record { job: self, values }
    }
}
