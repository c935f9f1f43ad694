//! Runs an experiment under several seeds and keeps the worst of each figure.

use drystone::body::Velocity;
use drystone_lab::experiment::{Experiment, Outcome};
use drystone_lab::scenes::Scene;

/// The result of an experiment, the worst of all seeds.
#[derive(Clone, Debug)]
pub struct Finding {
    /// When the first fell, s.
    pub fell_at: Option<f32>,
    /// m
    pub drift: f32,
    /// m
    pub sag: f32,
    /// m/s
    pub rms_speed: f32,
    /// Speed of the body that was placed first, m/s.
    pub speed: f32,
    /// A step's median time, that of the seed least disturbed by the rest of the machine, ms.
    pub ms: f64,
    /// The outcome of each seed.
    pub outcomes: Vec<Outcome>,
}

impl Finding {
    /// Runs `seeds` times for so many seconds; a fallen structure is not simulated to the end.
    pub fn of(experiment: &Experiment, seconds: f32, seeds: u64) -> Self {
        let mut finding = Self {
            fell_at: None,
            drift: 0.0,
            sag: 0.0,
            rms_speed: 0.0,
            speed: 0.0,
            ms: f64::INFINITY,
            outcomes: Vec::new(),
        };
        for seed in 1..=seeds {
            let (outcome, speed) = run(&experiment.clone().with_seed(seed), seconds);
            finding.drift = finding.drift.max(outcome.displacement.drift);
            finding.sag = finding.sag.max(outcome.displacement.sag);
            finding.rms_speed = finding.rms_speed.max(outcome.rms_speed);
            finding.speed = finding.speed.max(speed);
            let ms = 1e3 * outcome.step_time.median.as_secs_f64();
            finding.ms = finding.ms.min(ms);
            finding.fell_at = match (finding.fell_at, outcome.fell_at) {
                (Some(a), Some(b)) => Some(a.min(b)),
                (a, b) => a.or(b),
            };
            finding.outcomes.push(outcome);
        }
        finding
    }

    /// Nothing fell.
    pub fn stands(&self) -> bool {
        self.fell_at.is_none()
    }

    /// When it fell, in words.
    pub fn fate(&self) -> Option<String> {
        self.fell_at.map(|time| format!("falls {time:.1} s"))
    }
}

/// Steps that are taken even if all has fallen: the first ones take longer than the rest.
const TIMED: usize = 30;

fn run(experiment: &Experiment, seconds: f32) -> (Outcome, f32) {
    let travels = matches!(experiment.scene, Scene::Rolling | Scene::Sliding);
    let mut run = experiment.start();
    for step in 1..=(seconds / experiment.dt).round() as usize {
        let fallen = run.step().displacement.has_fallen() && !travels;
        if fallen && step >= TIMED {
            break;
        }
    }
    let velocity = run
        .bodies
        .first()
        .and_then(|&b| run.world.get::<Velocity>(b));
    let speed = velocity.map_or(0.0, |v| v.linear.length());
    (run.outcome(), speed)
}
