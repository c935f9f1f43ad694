//! Runs scenes under rows, several at a time, and keeps every moment for plots and pictures.

use crate::rows::Row;
use drystone::body::Pose;
use drystone::collider::Collider;
use drystone::grab::Grab;
use drystone::settings::{PhysicsThreads, Preset};
use drystone_lab::experiment::{Experiment, Outcome, Run, Sample};
use drystone_lab::report::report;
use drystone_lab::scenes::{Phase, Scene};
use glam::Vec3;
use indicatif::{ProgressBar, ProgressStyle};
use serde_json::Value;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

/// A scene under a row.
#[derive(Clone, Copy)]
pub struct Job {
    /// The scene.
    pub scene: Scene,
    /// Under what.
    pub row: &'static Row,
    /// For how long, s; a scene with a hand runs until its script ends.
    pub seconds: f32,
}

/// A step as it was.
pub struct Moment {
    /// Its measures.
    pub sample: Sample,
    /// Poses of the watched bodies.
    pub poses: Vec<Pose>,
    /// The point at which the hand holds a body, m.
    pub hand: Option<Vec3>,
    /// The action of the hand.
    pub phase: Option<Phase>,
}

/// The result of a job.
pub struct Record {
    /// The job.
    pub job: Job,
    /// As `simulate` reports it.
    pub outcome: Outcome,
    /// Shapes of the bodies watched.
    pub colliders: Vec<Collider>,
    /// Every step.
    pub moments: Vec<Moment>,
}

/// Runs all jobs, as many at once as there are cores; records come in the order of the jobs.
///
/// Plain threads rather than a rayon loop: a rayon worker that waits for another pool's step takes up the next job
/// meanwhile, and the step's time would count that job in.
pub fn run_all(jobs: &[Job]) -> Vec<Record> {
    let bar = ProgressBar::new(jobs.len() as u64).with_style(
        ProgressStyle::with_template("{elapsed:>4} {wide_bar} {pos}/{len} runs, {msg}")
            .expect("the template is valid"),
    );
    // The longest first, so that no core waits for a late one.
    let mut order: Vec<usize> = (0..jobs.len()).collect();
    let size = |i: &usize| match jobs[*i].scene {
        Scene::Wall(w, h) => w * h,
        Scene::Stack(n) | Scene::Pressed(n) => n,
        _ => 0,
    };
    order.sort_by_key(|i| std::cmp::Reverse(size(i)));
    let next = AtomicUsize::new(0);
    let records: Vec<Mutex<Option<Record>>> = jobs.iter().map(|_| Mutex::new(None)).collect();
    let work = || {
        let threads = PhysicsThreads::new(1).expect("the system gives a thread a core");
        while let Some(&i) = order.get(next.fetch_add(1, Ordering::Relaxed)) {
            let job = jobs[i];
            bar.set_message(format!("{} under row {}", job.scene, job.row.id));
            let record = job.run(threads.clone());
            *records[i].lock().expect("no run panics") = Some(record);
            bar.inc(1);
        }
    };
    let cores = thread::available_parallelism().map_or(1, usize::from);
    thread::scope(|scope| {
        for _ in 0..cores.min(jobs.len()) {
            scope.spawn(work);
        }
    });
    bar.finish_and_clear();
    let done = |slot: Mutex<Option<Record>>| slot.into_inner().expect("no run panics");
    records.into_iter().filter_map(done).collect()
}

impl Job {
    fn run(self, threads: PhysicsThreads) -> Record {
        let experiment = Experiment {
            threads,
            ..self.row.experiment(self.scene)
        };
        let mut run = experiment.start();
        let seconds = run.hand().map_or(self.seconds, |hand| hand.duration());
        let shape = |&body| run.world.get::<Collider>(body).cloned();
        let colliders = run.bodies.iter().filter_map(shape).collect();
        let steps = (seconds / experiment.dt).round() as usize;
        let moments = (0..steps).map(|_| Moment::next(&mut run)).collect();
        Record {
            job: Self { seconds, ..self },
            outcome: run.outcome(),
            colliders,
            moments,
        }
    }
}

impl Moment {
    fn next(run: &mut Run) -> Self {
        let sample = run.step();
        let held = run.bodies.iter().find_map(|&body| {
            let grab = run.world.get::<Grab>(body)?;
            let pose = run.world.get::<Pose>(body)?;
            Some(pose.transform_point(grab.local_point))
        });
        Self {
            sample,
            poses: run.poses(),
            hand: held,
            phase: run.phase(),
        }
    }
}

impl Record {
    /// The step that ended nearest to this time, s.
    pub fn at(&self, time: f32) -> &Moment {
        let off = |m: &&Moment| (m.sample.time - time).abs();
        let nearest = self.moments.iter().min_by(|a, b| off(a).total_cmp(&off(b)));
        nearest.expect("every run has steps")
    }

    /// A line of `runs.jsonl`: the output of `simulate --json`, and the row.
    pub fn json(&self) -> Value {
        let experiment = self.job.row.experiment(self.job.scene);
        let mut fields = report(
            Preset::Paper,
            &experiment,
            self.moments.len(),
            &self.outcome,
        );
        fields.insert("row".into(), self.job.row.id.into());
        fields.insert("label".into(), self.job.row.label.into());
        Value::Object(fields)
    }
}
