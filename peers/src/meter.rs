//! The measurements of an engine, the same for all.

use crate::body::Body;
use crate::engine::Engine;
use crate::joint::{self, Joint};
use crate::overlap;
use drystone::prelude::{Pose, Vec3};
use drystone_lab::experiment::Spread;
use drystone_lab::metrics::Displacement;
use std::time::{Duration, Instant};

/// An engine under way, and what was gathered of it.
pub struct Metered<'a, E> {
    pub engine: E,
    joints: &'a [Joint],
    start: Vec<Pose>,
    dt: f32,
    times: Vec<Duration>,
    fell_at: Option<f32>,
    mean_squares: Vec<f32>,
    /// By step: the largest distance of a joint's anchors, m.
    stretches: Vec<f32>,
}

/// The result of an engine.
pub struct Outcome {
    /// Statistics of the time of whole steps.
    pub step_time: Spread,
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
    /// Largest distance of a joint's anchors in any step and in the last second, m; none without joints.
    pub stretch: Option<[f32; 2]>,
}

impl<'a, E: Engine> Metered<'a, E> {
    pub fn new(engine: E, bodies: &[Body], joints: &'a [Joint], dt: f32) -> Self {
        Self {
            engine,
            joints,
            start: bodies.iter().map(|body| body.pose).collect(),
            dt,
            times: Vec::new(),
            fell_at: None,
            mean_squares: Vec::new(),
            stretches: Vec::new(),
        }
    }

    /// Takes so many steps; nothing but they are timed.
    pub fn steps(&mut self, count: usize) {
        for _ in 0..count {
            let begin = Instant::now();
            self.engine.step();
            self.times.push(begin.elapsed());
            self.look();
        }
    }

    fn look(&mut self) {
        let poses = self.engine.poses();
        if Displacement::between(&self.start, &poses).has_fallen() {
            let now = self.times.len() as f32 * self.dt;
            self.fell_at.get_or_insert(now);
        }
        self.mean_squares
            .push(mean_square(&self.engine.velocities()));
        self.stretches.push(joint::stretch(self.joints, &poses));
    }

    pub fn outcome(&self, bodies: &[Body]) -> Outcome {
        let poses = self.engine.poses();
        let steps = self.mean_squares.len();
        let last_second = ((1.0 / self.dt).round() as usize).clamp(1, steps.max(1));
        let tail = &self.mean_squares[steps.saturating_sub(last_second)..];
        Outcome {
            step_time: spread(&self.times),
            settled_time: mean(&self.times[steps / 3..]),
            fell_at: self.fell_at,
            displacement: Displacement::between(&self.start, &poses),
            rms_speed: (tail.iter().sum::<f32>() / tail.len().max(1) as f32).sqrt(),
            overlap: overlap::deepest(bodies, &poses),
            stretch: (!self.joints.is_empty()).then(|| {
                let largest = |of: &[f32]| of.iter().copied().fold(0.0, f32::max);
                [0, steps.saturating_sub(last_second)]
                    .map(|first| largest(&self.stretches[first..]))
            }),
        }
    }
}

fn mean_square(velocities: &[Vec3]) -> f32 {
    let sum: f32 = velocities.iter().map(|v| v.length_squared()).sum();
    sum / velocities.len().max(1) as f32
}

fn mean(times: &[Duration]) -> Duration {
    times.iter().sum::<Duration>() / times.len().max(1) as u32
}

/// Median and 95th percentile.
fn spread(times: &[Duration]) -> Spread {
    let mut sorted = times.to_vec();
    sorted.sort_unstable();
    let at = |share: f32| {
        let index = (sorted.len() as f32 * share) as usize;
        let last = sorted.len().saturating_sub(1);
        sorted.get(index.min(last)).copied().unwrap_or_default()
    };
    Spread {
        median: at(0.5),
        p95: at(0.95),
    }
}
