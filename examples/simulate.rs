//! The headless workhorse: any scene under any setting, one JSON line a seed.
//!
//! ```text
//! cargo run --release --example simulate -- --scene wall:10x10 --preset paper --steps 600 --seeds 1,2,3 --json
//! ```

mod report;

use clap::{Parser, ValueEnum};
use drystone::experiment::Experiment;
use drystone::scenes::{KNOWN, Scene};
use drystone::settings::{AnchorRule, Classifier, NormalStabilization, PhysicsThreads, Preset};
use drystone::solver::{FrictionCone, Nncg, Pgs};
use serde_json::{Map, Value};
use std::io::Write;
use std::process::ExitCode;
use std::sync::Arc;

/// Simulates a scene and prints what became of it.
#[derive(Parser)]
#[command(after_help = format!("Scenes: {KNOWN}"))]
struct Arguments {
    /// What to simulate.
    #[arg(long)]
    scene: Scene,
    /// Where the settings start from; every other option changes one of them.
    #[arg(long, value_enum, default_value = "default")]
    preset: PresetName,
    /// Length of a step, s.
    #[arg(long)]
    dt: Option<f32>,
    /// How many steps.
    #[arg(long, default_value_t = 600)]
    steps: usize,
    /// Contact solver.
    #[arg(long, value_enum)]
    solver: Option<SolverName>,
    /// Sweeps a solve, at most.
    #[arg(long)]
    iterations: Option<usize>,
    /// Substeps a step.
    #[arg(long)]
    substeps: Option<usize>,
    /// Normal stabilization.
    #[arg(long, value_enum)]
    normal: Option<NormalName>,
    /// Friction stabilization.
    #[arg(long, value_enum)]
    friction_stabilization: Option<Switch>,
    /// Where anchors come from.
    #[arg(long, value_enum)]
    anchors: Option<AnchorName>,
    /// What counts as sticking.
    #[arg(long, value_enum)]
    classifier: Option<ClassifierName>,
    /// Shape of the friction cone.
    #[arg(long, value_enum)]
    friction: Option<ConeName>,
    /// Share of last step's impulses that a solve starts from, 0 to 1.
    #[arg(long, value_parser = share)]
    warm_start: Option<f32>,
    /// Threads; rayon's default if not given.
    #[arg(long)]
    threads: Option<usize>,
    /// Whether bodies at rest sleep.
    #[arg(long, value_enum)]
    sleeping: Option<Switch>,
    /// Seeds of the noise, one run each.
    #[arg(long, value_delimiter = ',', default_value = "1")]
    seeds: Vec<u64>,
    /// Gap between neighbours in a course, m.
    #[arg(long)]
    gap: Option<f32>,
    /// Noise on the start poses, m and rad, such as 0.002,0.01.
    #[arg(long, value_delimiter = ',', num_args = 1)]
    noise: Option<Vec<f32>>,
    /// One JSON line a seed instead of a table.
    #[arg(long)]
    json: bool,
}

/// A command-line name for each value of a setting.
macro_rules! names {
    ($name:ident: $($variant:ident),+) => {
        #[derive(ValueEnum, Clone, Copy, PartialEq)]
        enum $name { $($variant),+ }
    };
}

names!(PresetName: Default, Paper);
names!(SolverName: Pgs, Nncg);
names!(NormalName: None, Baumgarte, BaumgarteOneSided, Envelope);
names!(Switch: On, Off);
names!(AnchorName: Literal, Persistent, PairPose, Trackless);
names!(ClassifierName: PerPoint, Any, All, Sum, Hysteresis);
names!(ConeName: Cone, Box);

fn share(text: &str) -> Result<f32, String> {
    match text.parse() {
        Ok(x) if (0.0..=1.0).contains(&x) => Ok(x),
        _ => Err("must be between 0 and 1".into()),
    }
}

/// Table 1: the error reduction of the Baumgarte rows.
const BAUMGARTE_GAIN: f32 = 0.5;

impl Arguments {
    fn preset(&self) -> Preset {
        match self.preset {
            PresetName::Default => Preset::Default,
            PresetName::Paper => Preset::Paper,
        }
    }

    fn experiment(&self) -> Result<Experiment, String> {
        let mut experiment = Experiment::new(self.scene, self.preset());
        if let Some(dt) = self.dt {
            if !(dt.is_finite() && dt > 0.0) {
                return Err(format!("--dt {dt}: a step must be longer than nothing"));
            }
            experiment.dt = dt;
        }
        let solver = &mut experiment.solver;
        match self.solver {
            Some(SolverName::Pgs) => solver.solver = Arc::new(Pgs),
            Some(SolverName::Nncg) => solver.solver = Arc::new(Nncg),
            None => {}
        }
        solver.iterations = self.iterations.unwrap_or(solver.iterations);
        solver.substeps = self.substeps.unwrap_or(solver.substeps).max(1);
        solver.warm_start = self.warm_start.unwrap_or(solver.warm_start);
        match self.friction {
            Some(ConeName::Cone) => solver.cone = FrictionCone::Circular,
            Some(ConeName::Box) => solver.cone = FrictionCone::Box,
            None => {}
        }
        let stabilization = &mut experiment.stabilization;
        let gain = BAUMGARTE_GAIN;
        match self.normal {
            Some(NormalName::None) => stabilization.normal = NormalStabilization::None,
            Some(NormalName::Baumgarte) => {
                stabilization.normal = NormalStabilization::Baumgarte { gain }
            }
            Some(NormalName::BaumgarteOneSided) => {
                stabilization.normal = NormalStabilization::BaumgarteOneSided { gain };
            }
            Some(NormalName::Envelope) => stabilization.normal = NormalStabilization::Envelope,
            None => {}
        }
        let friction = &mut stabilization.friction;
        if let Some(switch) = self.friction_stabilization {
            friction.enabled = switch == Switch::On;
        }
        match self.anchors {
            Some(AnchorName::Literal) => friction.anchors = AnchorRule::Literal,
            Some(AnchorName::Persistent) => friction.anchors = AnchorRule::Persistent,
            Some(AnchorName::PairPose) => friction.anchors = AnchorRule::PairPose,
            Some(AnchorName::Trackless) => friction.anchors = AnchorRule::Trackless,
            None => {}
        }
        match self.classifier {
            Some(ClassifierName::PerPoint) => friction.classifier = Classifier::PerPoint,
            Some(ClassifierName::Any) => friction.classifier = Classifier::Any,
            Some(ClassifierName::All) => friction.classifier = Classifier::All,
            Some(ClassifierName::Sum) => friction.classifier = Classifier::Sum,
            Some(ClassifierName::Hysteresis) => friction.classifier = Classifier::Hysteresis,
            None => {}
        }
        if let Some(switch) = self.sleeping {
            experiment.sleeping.enabled = switch == Switch::On;
        }
        if let Some(n) = self.threads {
            experiment.threads =
                PhysicsThreads::new(n).map_err(|e| format!("--threads {n}: {e}"))?;
        }
        experiment.options.lateral_gap = self.gap.unwrap_or(experiment.options.lateral_gap);
        if let Some(noise) = &self.noise {
            let [position, angle] = noise[..] else {
                return Err("--noise takes two numbers, metres and radians: 0.002,0.01".into());
            };
            experiment.options.noise_position = position;
            experiment.options.noise_angle = angle;
        }
        Ok(experiment)
    }
}

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
        let fields = report::report(arguments.preset(), &experiment, arguments.steps, &outcome);
        let written = if arguments.json {
            writeln!(out, "{}", Value::Object(fields))
        } else {
            table(&mut out, &fields)
        };
        if written.is_err() {
            // Whoever read us has gone.
            return ExitCode::SUCCESS;
        }
    }
    ExitCode::SUCCESS
}
