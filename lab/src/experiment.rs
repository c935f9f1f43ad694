//! A scene under given settings, stepped without an app around it, and measured: what `simulate`, `paper`, the benches and the
//! acceptance tests all run.

use crate::metrics::{self, Displacement, Gaps};
use crate::scenes::{Built, Hand, Phase, Scene, SceneOptions};
use bevy_app::App;
use bevy_ecs::prelude::*;
use drystone::DrystonePlugins;
use drystone::body::Pose;
use drystone::profile::Profile;
use drystone::schedule::step;
use drystone::settings::{
    NarrowphaseSettings, PhysicsThreads, Preset, SleepSettings, SolverSettings,
    StabilizationSettings,
};
use drystone::solve::SolveReports;
use std::collections::BTreeMap;
use std::time::Duration;

/// A scene with everything that determines its result.
#[derive(Clone)]
pub struct Experiment {
    /// The scene.
    pub scene: Scene,
    /// How it is laid out.
    pub options: SceneOptions,
    /// Length of a step, s.
    pub dt: f32,
    /// Stabilization.
    pub stabilization: StabilizationSettings,
    /// Settings of the narrowphase.
    pub narrowphase: NarrowphaseSettings,
    /// Solver.
    pub solver: SolverSettings,
    /// Sleeping.
    pub sleeping: SleepSettings,
    /// Threads.
    pub threads: PhysicsThreads,
}

/// A world with drystone's defaults and no bodies, without an app.
pub(crate) fn empty_world() -> World {
    let mut app = App::new();
    app.add_plugins(DrystonePlugins::default());
    std::mem::take(app.world_mut())
}

impl Experiment {
    /// A scene under a preset. [`Preset::Paper`] has the prototype's noise and gaps.
    pub fn new(scene: Scene, preset: Preset) -> Self {
        let mut options = SceneOptions::default();
        if preset == Preset::Paper {
            options.noise_position = 0.002;
            options.noise_angle = 0.01;
            options.lateral_gap = 0.036;
        }
        Self {
            scene,
            options,
            dt: preset.dt(),
            stabilization: preset.stabilization(),
            narrowphase: preset.narrowphase(),
            solver: preset.solver(),
            sleeping: preset.sleeping(),
            threads: PhysicsThreads::default(),
        }
    }

    /// This with other noise.
    pub fn with_seed(mut self, seed: u64) -> Self {
        self.options.seed = seed;
        self
    }

    /// A world with these settings and no bodies.
    pub fn world(&self) -> World {
        let mut world = empty_world();
        world.insert_resource(self.stabilization);
        world.insert_resource(self.narrowphase);
        world.insert_resource(self.solver.clone());
        world.insert_resource(self.sleeping);
        world.insert_resource(self.threads.clone());
        world
    }

    /// Builds the scene; vertical gaps are the method's ideal distance.
    pub fn start(&self) -> Run {
        let mut world = self.world();
        let options = SceneOptions {
            vertical_gap: self.stabilization.rest_distance().max(0.0),
            ..self.options
        };
        let Built { bodies, hand } = self.scene.build(&mut world, &options);
        let mut run = Run {
            world,
            bodies,
            hand,
            stays: self.scene.stays(),
            dt: self.dt,
            time: 0.0,
            start: Vec::new(),
            energy_start: 0.0,
            energy_scale: 0.0,
            meter: Meter::default(),
        };
        run.start = run.start_poses();
        run
    }

    /// Runs for so many steps and measures.
    pub fn run(&self, steps: usize) -> Outcome {
        let mut run = self.start();
        for _ in 0..steps {
            run.step();
        }
        run.outcome()
    }

    /// Runs for so many seconds and measures.
    pub fn run_seconds(&self, seconds: f32) -> Outcome {
        self.run((seconds / self.dt).round() as usize)
    }
}

/// An experiment under way.
pub struct Run {
    /// The world.
    pub world: World,
    /// The bodies to watch.
    pub bodies: Vec<Entity>,
    hand: Option<Hand>,
    stays: bool,
    dt: f32,
    time: f32,
    start: Vec<Pose>,
    energy_start: f64,
    energy_scale: f64,
    meter: Meter,
}

/// The measurements collected during a run.
#[derive(Default)]
struct Meter {
    fell_at: Option<f32>,
    energy_gain: f64,
    penetration_max: f32,
    gaps: Gaps,
    speeds: Vec<f32>,
    sweeps: Vec<usize>,
    residual: f32,
    step_times: Vec<Duration>,
    system_times: BTreeMap<&'static str, Vec<Duration>>,
}

/// One moment of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// s
    pub time: f32,
    /// Against the start.
    pub displacement: Displacement,
    /// Statistics of the distances of contact points.
    pub gaps: Gaps,
    /// m/s
    pub rms_speed: f32,
    /// Mechanical energy gained since the start, as a share of the initial energy.
    pub energy_gain: f64,
}

impl Run {
    /// Seconds simulated.
    pub fn time(&self) -> f32 {
        self.time
    }

    /// Poses of the watched bodies: the initial poses before the first step, and then those of [`metrics::watch`], which are NaN for bodies
    /// that are despawned or quarantined.
    pub fn poses(&self) -> Vec<Pose> {
        if self.time == 0.0 {
            return self.start.clone();
        }
        let pose = |&body: &Entity| metrics::watch(&self.world, body).0;
        self.bodies.iter().map(pose).collect()
    }

    fn start_poses(&self) -> Vec<Pose> {
        let placed = |&body: &Entity| {
            let transform = self
                .world
                .get::<bevy_transform::components::Transform>(body);
            transform.map_or_else(Pose::default, |t| Pose {
                position: t.translation,
                rotation: t.rotation,
            })
        };
        self.bodies.iter().map(placed).collect()
    }

    /// The scripted hand, where the scene has one.
    pub fn hand(&self) -> Option<&Hand> {
        self.hand.as_ref()
    }

    /// Takes one step and measures.
    pub fn step(&mut self) -> Sample {
        if let Some(hand) = &self.hand {
            hand.act(&mut self.world, self.time);
        }
        step(&mut self.world, self.dt).expect("the experiment's time step is positive");
        self.time += self.dt;
        self.measure()
    }

    fn measure(&mut self) -> Sample {
        if self.meter.step_times.is_empty() {
            self.energy_start = metrics::energy(&mut self.world);
            // Heights and speeds at the start, so that the gain is a share of something.
            let kinetic = metrics::kinetic_energy(&mut self.world);
            self.energy_scale = (self.energy_start.abs() + kinetic).max(1.0);
        }
        // While a hand builds, nothing is to stand yet, and energy is put in.
        let building = self
            .hand
            .as_ref()
            .is_some_and(|hand| self.time <= hand.pressing_begins());
        if building {
            self.start = self.poses();
            self.energy_start = metrics::energy(&mut self.world);
        }
        let poses = self.poses();
        let displacement = Displacement::between(&self.start, &poses);
        let gaps = metrics::gaps(&mut self.world);
        let rms_speed = metrics::rms_speed(&mut self.world);
        let gained = metrics::energy(&mut self.world) - self.energy_start;
        let energy_gain = match gained.is_finite() {
            true => gained / self.energy_scale,
            false => f64::INFINITY,
        };

        let meter = &mut self.meter;
        let fell = match self.stays {
            true => displacement.has_fallen(),
            false => poses.iter().any(is_lost),
        };
        if fell {
            meter.fell_at.get_or_insert(self.time);
        }
        meter.energy_gain = meter.energy_gain.max(energy_gain);
        meter.gaps = gaps;
        if self.time > 1.0 {
            meter.penetration_max = meter.penetration_max.max(gaps.penetration_max);
        }
        meter.speeds.push(rms_speed);
        let reports = &self.world.resource::<SolveReports>().0;
        let worst = reports.iter().max_by_key(|r| r.contacts);
        meter.sweeps.push(worst.map_or(0, |r| r.report.sweeps));
        meter.residual = worst.map_or(0.0, |r| r.report.residual);
        let profile = self.world.resource::<Profile>();
        meter.step_times.push(profile.step);
        for (name, time) in profile.systems() {
            meter.system_times.entry(name).or_default().push(time);
        }
        Sample {
            time: self.time,
            displacement,
            gaps,
            rms_speed,
            energy_gain,
        }
    }

    /// The current action of the hand, if there is one.
    pub fn phase(&self) -> Option<Phase> {
        self.hand.as_ref().map(|hand| hand.phase(self.time))
    }

    /// The result so far.
    pub fn outcome(&self) -> Outcome {
        let meter = &self.meter;
        let last_second = ((1.0 / self.dt).round() as usize).clamp(1, meter.speeds.len().max(1));
        let tail = &meter.speeds[meter.speeds.len().saturating_sub(last_second)..];
        let squares: f32 = tail.iter().map(|v| v * v).sum();
        let displacement = Displacement::between(&self.start, &self.poses());
        Outcome {
            stands: meter.fell_at.is_none(),
            fell_at: meter.fell_at,
            displacement,
            penetration_max: meter.penetration_max,
            penetration_end: meter.gaps.penetration_max,
            penetration_mean: meter.gaps.penetration_mean,
            ideal_error_max: meter.gaps.ideal_error_max,
            rms_speed: (squares / tail.len().max(1) as f32).sqrt(),
            energy_gain: meter.energy_gain,
            residual: meter.residual,
            sweeps_median: median(&meter.sweeps).unwrap_or_default(),
            bodies: self.bodies.len(),
            contacts: meter.gaps.points,
            step_time: Spread::of(&meter.step_times),
            system_times: meter
                .system_times
                .iter()
                .map(|(name, times)| (*name, Spread::of(times)))
                .collect(),
        }
    }
}

/// Nowhere, or with its centre in the ground, which is level in all scenes that are to move.
fn is_lost(pose: &Pose) -> bool {
    !(pose.is_finite() && pose.position.y > 0.0)
}

/// Median and 95th percentile of times.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spread {
    /// Half of all are shorter.
    pub median: Duration,
    /// 95 % are shorter.
    pub p95: Duration,
}

impl Spread {
    fn of(times: &[Duration]) -> Self {
        let mut sorted = times.to_vec();
        sorted.sort_unstable();
        let at = |share: f32| {
            let index = (sorted.len() as f32 * share) as usize;
            sorted
                .get(index.min(sorted.len().saturating_sub(1)))
                .copied()
                .unwrap_or_default()
        };
        Self {
            median: at(0.5),
            p95: at(0.95),
        }
    }
}

fn median<T: Copy + Ord>(values: &[T]) -> Option<T> {
    let mut sorted = values.to_vec();
    sorted.sort_unstable();
    sorted.get(sorted.len() / 2).copied()
}

/// The result of an experiment.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// Returns true if no body has fallen ([`metrics::FALLEN`]) at any time. In scenes that are meant to move ([`Scene::stays`]): if no
    /// body is lost, despawned, quarantined, or below the ground.
    pub stands: bool,
    /// When something first fell or was lost, s.
    pub fell_at: Option<f32>,
    /// Worst body at the end against its start. Scenes start with the method's ideal gaps, so sag is free of them.
    pub displacement: Displacement,
    /// Deepest overlap of real surfaces after the first second, m.
    pub penetration_max: f32,
    /// Deepest overlap of real surfaces at the end, m.
    pub penetration_end: f32,
    /// Mean overlap at the end, m.
    pub penetration_mean: f32,
    /// Largest distance of a loaded point from the ideal at the end, m.
    pub ideal_error_max: f32,
    /// Root mean square over bodies and the last second, m/s.
    pub rms_speed: f32,
    /// Largest gain of mechanical energy against the start, as a share of the initial energy.
    pub energy_gain: f64,
    /// The residual of the last solve of the largest island.
    pub residual: f32,
    /// Sweeps of the largest island.
    pub sweeps_median: usize,
    /// Bodies watched.
    pub bodies: usize,
    /// Contact points at the end.
    pub contacts: usize,
    /// Statistics of the time of whole steps.
    pub step_time: Spread,
    /// Statistics of the time of each system.
    pub system_times: BTreeMap<&'static str, Spread>,
}
