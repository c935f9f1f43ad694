//! The measurements of an engine, the same for all.

mod clock;
mod energy;
mod overlap;

pub use overlap::Overlaps;

use crate::engine::Engine;
use crate::joint::{self, Joint};
use crate::scene::Start;
use clock::Clock;
use drystone::prelude::{Pose, RigidBody, Velocity};
use drystone_lab::experiment::Spread;
use drystone_lab::metrics::Displacement;
use energy::{Energy, Masses};
use std::time::Duration;

/// Overlaps and energy are measured after every so many steps.
const SAMPLE: usize = 10;

/// An engine under way, and what was gathered of it.
pub struct Metered<'a, E> {
    pub engine: E,
    joints: &'a [Joint],
    overlaps: Overlaps<'a>,
    masses: Masses,
    clock: Clock,
    start: Vec<Pose>,
    dt: f32,
    times: Vec<Duration>,
    fell_at: Option<f32>,
    mean_squares: Vec<f32>,
    /// By step: the largest distance of a joint's anchors, m.
    stretches: Vec<f32>,
    /// Deepest at every sample so far, m.
    deepest: f32,
    /// Largest kinetic energy at every sample so far, J.
    liveliest: f64,
    /// At the start.
    energy: Energy,
}

/// The result of an engine.
pub struct Outcome {
    /// Statistics of the time of whole steps.
    pub step_time: Spread,
    /// Mean and largest times.
    pub busy_time: BusyTime,
    /// Mean time of the steps after the first third, in which a scene settles.
    pub settled_time: Duration,
    /// When something first fell, by [`Displacement::has_fallen`], s.
    pub fell_at: Option<f32>,
    /// Worst body at the end against its start.
    pub displacement: Displacement,
    /// Root mean square over dynamic bodies and the last second, m/s; NaN where one is lost.
    pub rms_speed: f32,
    /// Deepest at the end, m; infinite where a body is lost.
    pub overlap: f32,
    /// Deepest after every tenth step and at the end, m.
    pub overlap_during: f32,
    /// Energy at the end minus that at the start, as a share of the largest kinetic energy.
    pub energy_gain: f64,
    /// Largest distance of a joint's anchors in any step and in the last second, m; none without joints.
    pub stretch: Option<[f32; 2]>,
}

impl<'a, E: Engine> Metered<'a, E> {
    pub fn new(engine: E, start: &Start<'a>) -> Self {
        let &Start {
            bodies,
            joints,
            gravity,
            conditions,
        } = start;
        let masses = Masses::new(bodies, gravity);
        let poses: Vec<Pose> = bodies.iter().map(|body| body.pose).collect();
        let moving = bodies.iter().filter(|body| body.kind == RigidBody::Dynamic);
        let velocities: Vec<Velocity> = moving.map(|body| body.velocity).collect();
        let energy = masses.energy(&poses, &velocities);
        Self {
            engine,
            joints,
            overlaps: Overlaps::new(bodies, joints),
            masses,
            clock: Clock::of(conditions.threads),
            start: poses,
            dt: conditions.dt,
            times: Vec::new(),
            fell_at: None,
            mean_squares: Vec::new(),
            stretches: Vec::new(),
            deepest: 0.0,
            liveliest: energy.kinetic,
            energy,
        }
    }

    /// Takes so many steps; nothing but they are timed.
    pub fn steps(&mut self, count: usize) {
        for _ in 0..count {
            let begin = self.clock.now();
            self.engine.step();
            self.times.push(self.clock.now() - begin);
            self.look();
        }
    }

    fn look(&mut self) {
        let poses = self.engine.poses();
        let velocities = self.engine.velocities();
        if Displacement::between(&self.start, &poses).has_fallen() {
            let now = self.times.len() as f32 * self.dt;
            self.fell_at.get_or_insert(now);
        }
        self.mean_squares.push(mean_square(&velocities));
        self.stretches.push(joint::stretch(self.joints, &poses));
        if self.times.len().is_multiple_of(SAMPLE) {
            self.deepest = self.deepest.max(self.overlaps.deepest(&poses));
            let kinetic = self.masses.energy(&poses, &velocities).kinetic;
            self.liveliest = self.liveliest.max(kinetic);
        }
    }

    pub fn outcome(&self) -> Outcome {
        let poses = self.engine.poses();
        let steps = self.mean_squares.len();
        let last_second = ((1.0 / self.dt).round() as usize).clamp(1, steps.max(1));
        let tail = &self.mean_squares[steps.saturating_sub(last_second)..];
        let overlap = self.overlaps.deepest(&poses);
        let energy = self.masses.energy(&poses, &self.engine.velocities());
        // Where nothing moves, a share of the weights.
        let scale = self.liveliest.max(1e-3 * self.energy.potential.abs());
        Outcome {
            step_time: spread(&self.times),
            busy_time: BusyTime::of(&self.times),
            settled_time: mean(&self.times[steps / 3..]),
            fell_at: self.fell_at,
            displacement: Displacement::between(&self.start, &poses),
            rms_speed: (tail.iter().sum::<f32>() / tail.len().max(1) as f32).sqrt(),
            overlap,
            overlap_during: overlap.max(self.deepest),
            energy_gain: (energy.total() - self.energy.total()) / scale,
            stretch: (!self.joints.is_empty()).then(|| {
                let largest = |of: &[f32]| of.iter().copied().fold(0.0, f32::max);
                [0, steps.saturating_sub(last_second)]
                    .map(|first| largest(&self.stretches[first..]))
            }),
        }
    }
}

/// Times of steps as the table of busy scenes has them. The first step, in which all is new, does not count, as in Box3D's benchmark.
#[derive(Clone, Copy, Debug, Default)]
pub struct BusyTime {
    pub mean: Duration,
    /// 99 % of all steps are shorter.
    pub p99: Duration,
    pub largest: Duration,
    /// Mean of the last fifth of all steps.
    pub last: Duration,
}

impl BusyTime {
    fn of(times: &[Duration]) -> Self {
        let times = &times[times.len().min(1)..];
        Self {
            mean: mean(times),
            p99: at_share(times, 0.99),
            largest: at_share(times, 1.0),
            last: mean(&times[times.len() - times.len().div_ceil(5)..]),
        }
    }
}

fn mean_square(velocities: &[Velocity]) -> f32 {
    let sum: f32 = velocities.iter().map(|v| v.linear.length_squared()).sum();
    sum / velocities.len().max(1) as f32
}

fn mean(times: &[Duration]) -> Duration {
    times.iter().sum::<Duration>() / times.len().max(1) as u32
}

/// The time that a share of all steps does not exceed.
fn at_share(times: &[Duration], share: f32) -> Duration {
    let mut sorted = times.to_vec();
    sorted.sort_unstable();
    let index = (sorted.len() as f32 * share) as usize;
    let last = sorted.len().saturating_sub(1);
    sorted.get(index.min(last)).copied().unwrap_or_default()
}

/// Median and 95th percentile.
fn spread(times: &[Duration]) -> Spread {
    Spread {
        median: at_share(times, 0.5),
        p95: at_share(times, 0.95),
    }
}
