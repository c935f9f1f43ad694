//! The command line: its options, and the experiment that they describe. A value out of bounds is refused with the option,
//! the value and the bounds.

use clap::builder::RangedU64ValueParser;
use clap::{Parser, ValueEnum};
use drystone::settings::{
    AnchorRule, Classifier, ContactSolver, NormalStabilization, PhysicsThreads, Preset,
};
use drystone::solver::{FrictionCone, Lanes, Nncg, Pgs, SoftStep};
use drystone_lab::experiment::Experiment;
use drystone_lab::scenes::{Ground, KNOWN, Scene};
use drystone_lab::solvers::{Apgd, Avbd};
use std::f32::consts::PI;
use std::ops::RangeInclusive;

/// Sweeps of a solver of points where nothing else is said.
const BY_POINTS: usize = 24;

/// Simulates a scene and prints the result.
#[derive(Parser)]
#[command(after_help = format!("Scenes: {KNOWN}"))]
pub struct Arguments {
    /// The scene to simulate.
    #[arg(long)]
    scene: Scene,
    /// The initial settings; every other option changes one of them.
    #[arg(long, value_enum, default_value = "default")]
    preset: PresetName,
    /// Length of a step, s.
    #[arg(long, value_parser = number(STEP), allow_hyphen_values = true)]
    dt: Option<f32>,
    /// How many steps.
    #[arg(long, default_value_t = 600, value_parser = count(1_000_000_000))]
    pub steps: usize,
    /// Contact solver.
    #[arg(long, value_enum)]
    solver: Option<SolverName>,
    /// Sweeps a solve, at most.
    #[arg(long, value_parser = count(100_000))]
    iterations: Option<usize>,
    /// Substeps a step.
    #[arg(long, value_parser = count(1000))]
    substeps: Option<usize>,
    /// Normal stabilization.
    #[arg(long, value_enum)]
    normal: Option<NormalName>,
    /// Friction stabilization.
    #[arg(long, value_enum)]
    friction_stabilization: Option<Switch>,
    /// How anchors are chosen.
    #[arg(long, value_enum)]
    anchors: Option<AnchorName>,
    /// The rule that decides whether a contact sticks.
    #[arg(long, value_enum)]
    classifier: Option<ClassifierName>,
    /// Shape of the friction cone.
    #[arg(long, value_enum)]
    friction: Option<ConeName>,
    /// Share of last step's impulses that a solve starts from, 0 to 1.
    #[arg(long, value_parser = number(0.0..=1.0), allow_hyphen_values = true)]
    warm_start: Option<f32>,
    /// Contacts that are relaxed side by side.
    #[arg(long, value_enum, default_value = "auto")]
    lanes: LanesName,
    /// Threads; rayon's default if not given.
    #[arg(long, value_parser = count(256))]
    threads: Option<usize>,
    /// Whether bodies at rest sleep.
    #[arg(long, value_enum)]
    sleeping: Option<Switch>,
    /// Seeds of the noise, one run each.
    #[arg(long, value_delimiter = ',', default_value = "1")]
    pub seeds: Vec<u64>,
    /// The ground of the scene: half-space, mesh, height-field.
    #[arg(long, default_value_t)]
    ground: Ground,
    /// Gap between neighbours in a course, m.
    #[arg(long, value_parser = number(LENGTH), allow_hyphen_values = true)]
    gap: Option<f32>,
    /// Noise on the start poses, m and rad, such as 0.002,0.01.
    #[arg(long, value_name = "M,RAD", value_parser = noise, allow_hyphen_values = true)]
    noise: Option<Noise>,
    /// One JSON line a seed instead of a table.
    #[arg(long)]
    pub json: bool,
}

/// s
const STEP: RangeInclusive<f32> = 1e-6..=1.0;
/// Range of noise and gaps, m. A scene falls apart if they are longer than a brick.
const LENGTH: RangeInclusive<f32> = 0.0..=1.0;
/// rad
const ANGLE: RangeInclusive<f32> = 0.0..=PI;

/// At the start, either way.
#[derive(Clone, Copy)]
struct Noise {
    /// m
    position: f32,
    /// rad
    angle: f32,
}

fn count(most: u64) -> RangedU64ValueParser<usize> {
    RangedU64ValueParser::new().range(1..=most)
}

fn number(allowed: RangeInclusive<f32>) -> impl Fn(&str) -> Result<f32, String> + Clone {
    move |text| match text.trim().parse() {
        Ok(x) if allowed.contains(&x) => Ok(x),
        _ => Err(format!(
            "must be a number from {} to {}",
            allowed.start(),
            allowed.end()
        )),
    }
}

fn noise(text: &str) -> Result<Noise, String> {
    let (position, angle) = text
        .split_once(',')
        .ok_or("must be two numbers, metres and radians, such as 0.002,0.01")?;
    Ok(Noise {
        position: number(LENGTH)(position).map_err(|why| format!("metres {why}"))?,
        angle: number(ANGLE)(angle).map_err(|why| format!("radians {why}"))?,
    })
}

/// A command-line name for each value of a setting.
macro_rules! names {
    ($name:ident: $($variant:ident),+) => {
        #[derive(ValueEnum, Clone, Copy, PartialEq)]
        enum $name { $($variant),+ }
    };
}

names!(PresetName: Default, Paper);
names!(SolverName: SoftStep, Pgs, Nncg, Avbd, Apgd);
names!(NormalName: None, Baumgarte, BaumgarteOneSided, Envelope);
names!(Switch: On, Off);
names!(AnchorName: Literal, Persistent, PairPose, Trackless);
names!(ClassifierName: PerPoint, Any, All, Sum, Hysteresis);
names!(ConeName: Cone, Box);
names!(LanesName: Auto, Four, Eight);

/// Table 1: the error reduction of the Baumgarte rows.
const BAUMGARTE_GAIN: f32 = 0.5;

impl Arguments {
    pub fn preset(&self) -> Preset {
        match self.preset {
            PresetName::Default => Preset::Default,
            PresetName::Paper => Preset::Paper,
        }
    }

    fn solver_name(&self) -> SolverName {
        let own = match self.preset {
            PresetName::Default => SolverName::SoftStep,
            PresetName::Paper => SolverName::Nncg,
        };
        self.solver.unwrap_or(own)
    }

    /// Refuses what the solver from the literature leaves out, which would be ignored otherwise.
    fn refuse_missing(&self) -> Result<(), String> {
        match self.solver_name() {
            SolverName::Avbd if !self.scene.has_contacts_only() => Err(format!(
                "--solver avbd has contacts only, and {} has joints or a hand",
                self.scene
            )),
            SolverName::Avbd if self.warm_start.is_some() => {
                Err("--warm-start is not for --solver avbd, which has a rule of its own".into())
            }
            SolverName::Avbd | SolverName::Apgd if self.friction == Some(ConeName::Box) => {
                Err("--friction box is not for --solver avbd or apgd: their cones are round".into())
            }
            _ => Ok(()),
        }
    }

    fn contact_solver(&self) -> ContactSolver {
        let (sweeps, warm_start) = match self.preset {
            PresetName::Default => (BY_POINTS, 0.3),
            PresetName::Paper => (Nncg::default().iterations, 0.0),
        };
        let iterations = self.iterations.unwrap_or(sweeps);
        let warm_start = self.warm_start.unwrap_or(warm_start);
        let cone = match self.friction {
            Some(ConeName::Box) => FrictionCone::Box,
            Some(ConeName::Cone) | None => FrictionCone::Circular,
        };
        let tolerance = 0.0;
        let lanes = match self.lanes {
            LanesName::Auto => Lanes::Auto,
            LanesName::Four => Lanes::Four,
            LanesName::Eight => Lanes::Eight,
        };
        match self.solver_name() {
            SolverName::SoftStep => {
                let default = SoftStep::default();
                let max_sweeps = self.iterations.unwrap_or(default.max_sweeps);
                let soft_step = SoftStep {
                    max_sweeps,
                    lanes,
                    ..default
                };
                soft_step.into()
            }
            SolverName::Pgs => {
                let pgs = Pgs {
                    iterations,
                    cone,
                    warm_start,
                    tolerance,
                    lanes,
                };
                pgs.into()
            }
            SolverName::Nncg => {
                let nncg = Nncg {
                    iterations,
                    cone,
                    warm_start,
                    tolerance,
                    lanes,
                };
                nncg.into()
            }
            SolverName::Avbd => {
                let default = Avbd::default();
                let avbd = Avbd {
                    iterations: self.iterations.unwrap_or(default.iterations),
                    ..default
                };
                avbd.into()
            }
            SolverName::Apgd => {
                let apgd = Apgd {
                    iterations,
                    warm_start,
                    tolerance,
                };
                apgd.into()
            }
        }
    }

    /// # Errors
    /// If the operating system gives no threads, or if the solver leaves out what the scene or an option needs.
    pub fn experiment(&self) -> Result<Experiment, String> {
        self.refuse_missing()?;
        let mut experiment = Experiment::new(self.scene, self.preset());
        experiment.dt = self.dt.unwrap_or(experiment.dt);
        let solver = &mut experiment.solver;
        solver.solver = self.contact_solver();
        solver.outer_substeps = self.substeps.unwrap_or(solver.outer_substeps);
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
        experiment.options.ground = self.ground;
        experiment.options.lateral_gap = self.gap.unwrap_or(experiment.options.lateral_gap);
        if let Some(Noise { position, angle }) = self.noise {
            experiment.options.noise_position = position;
            experiment.options.noise_angle = angle;
        }
        Ok(experiment)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(options: &[&str]) -> Result<Arguments, clap::Error> {
        let given = ["simulate", "--scene", "stack:2"].iter().chain(options);
        Arguments::try_parse_from(given)
    }

    #[track_caller]
    fn refuses(options: &[&str], allowed: &str) {
        let error = parse(options).err().expect("it is out of bounds");
        let text = error.to_string();
        assert_eq!(error.exit_code(), 2, "{text}");
        for part in options.iter().chain([&allowed]) {
            assert!(text.contains(part), "{part} is not in: {text}");
        }
    }

    #[test]
    fn what_is_out_of_bounds_is_refused_with_option_value_and_bounds() {
        for bad in [
            "nan,nan", "0.1,inf", "-1,0", "1e9,0", "0,4", "0.1", "a,b", "0,0,0",
        ] {
            refuses(&["--noise", bad], "must be");
        }
        for bad in ["nan", "inf", "-inf", "-1", "1e9", "x"] {
            refuses(&["--gap", bad], "from 0 to 1");
        }
        for bad in ["nan", "inf", "-0.1", "0", "1e-30", "10"] {
            refuses(&["--dt", bad], "from 0.000001 to 1");
        }
        for bad in ["nan", "-0.1", "1.1"] {
            refuses(&["--warm-start", bad], "from 0 to 1");
        }
        refuses(&["--iterations", "0"], "1..=100000");
        refuses(&["--iterations", "100001"], "1..=100000");
        refuses(&["--substeps", "0"], "1..=1000");
        refuses(&["--steps", "0"], "1..=1000000000");
        refuses(&["--threads", "0"], "1..=256");
        refuses(&["--threads", "100000"], "1..=256");
        refuses(&["--solver", "gauss"], "soft-step, pgs, nncg, avbd, apgd");
        refuses(&["--ground", "sand"], "half-space, mesh, height-field");
    }

    #[test]
    fn absurd_scenes_are_refused() {
        for name in ["wall:1000000x1000000", "stack:1000000", "heap:1000000"] {
            let error = Arguments::try_parse_from(["simulate", "--scene", name]);
            let error = error.err().expect("it is too large");
            let text = error.to_string();
            assert_eq!(error.exit_code(), 2, "{text}");
            assert!(
                text.contains("--scene") && text.contains(name) && text.contains("200000 bodies"),
                "{text}"
            );
        }
    }

    #[test]
    fn what_is_within_bounds_is_taken() {
        let options = [
            "--solver=soft-step",
            "--noise=0.002,0.01",
            "--gap=0.036",
            "--dt=0.1",
            "--iterations=12",
            "--substeps=2",
            "--threads=2",
            "--warm-start=0.5",
            "--lanes=four",
            "--ground=mesh",
        ];
        let experiment = parse(&options).unwrap().experiment().unwrap();
        let ContactSolver::SoftStep(soft_step) = experiment.solver.solver else {
            panic!("{}", experiment.solver.solver.name());
        };
        assert_eq!((soft_step.max_sweeps, soft_step.lanes), (12, Lanes::Four));
        assert_eq!(experiment.solver.outer_substeps, 2);
        assert_eq!(experiment.options.noise_position, 0.002);
        assert_eq!(experiment.options.noise_angle, 0.01);
        assert_eq!(experiment.options.lateral_gap, 0.036);
        assert_eq!(experiment.options.ground, Ground::Mesh);
        assert_eq!((experiment.dt, experiment.threads.count()), (0.1, 2));
    }

    #[test]
    fn what_a_solver_from_the_literature_leaves_out_is_refused() {
        for (scene, options, part) in [
            ("chain:3", ["--solver=avbd", "--json"], "joints"),
            ("pressed:3", ["--solver=avbd", "--json"], "hand"),
            (
                "stack:2",
                ["--solver=avbd", "--warm-start=0.5"],
                "--warm-start",
            ),
            (
                "stack:2",
                ["--solver=apgd", "--friction=box"],
                "--friction box",
            ),
        ] {
            let given = ["simulate", "--scene", scene].into_iter().chain(options);
            let arguments = Arguments::try_parse_from(given).unwrap();
            let error = arguments.experiment().err().expect("it is left out");
            assert!(error.contains(part), "{error}");
        }
        let given = ["simulate", "--scene", "chain:3", "--solver=apgd"];
        assert!(
            Arguments::try_parse_from(given)
                .unwrap()
                .experiment()
                .is_ok()
        );
    }

    #[test]
    fn every_solver_holds_a_stack_under_every_preset() {
        for preset in ["--preset=default", "--preset=paper"] {
            for solver in ["soft-step", "pgs", "nncg", "avbd", "apgd"] {
                let solver = format!("--solver={solver}");
                let experiment = parse(&[preset, &solver]).unwrap().experiment().unwrap();
                assert!(solver.ends_with(experiment.solver.solver.name()));
                assert!(experiment.run(30).stands, "{preset} {solver}");
            }
        }
    }
}
