//! Why collisions lose angular momentum under the default solver.

use crate::{SOLVERS, STEPS};
use support::accuracy::{Glance, closed_group, glance};

/// Number of groups, by the seeds of their velocities.
const SEEDS: u64 = 10;

/// Phases of a step in which a glancing hit happens.
const PHASES: usize = 20;

/// What happens at steps of one length.
pub struct Momentum {
    /// Name of the step.
    pub step: &'static str,
    /// s
    pub dt: f32,
    /// Angular momentum lost by each closed group of 24 bodies with the default solver, and with NNCG, as a share of the sum of momenta.
    pub groups: [Vec<f32>; 2],
    /// Phase of a glancing hit of two balls, and angular momentum lost as a share of J u Δt, with the default solver.
    pub glances: Vec<(f32, f32)>,
}

/// Measures at all steps.
pub fn measure() -> Vec<Momentum> {
    let at = |&(step, dt): &(&'static str, f32)| {
        let group = |solver: usize| {
            let settings = SOLVERS[solver].1;
            (1..=SEEDS)
                .map(|seed| closed_group(settings(dt), seed).angular)
                .collect()
        };
        let hit = |i: usize| {
            let phase = (i as f32 + 0.5) / PHASES as f32;
            let Glance { off, most } = glance(SOLVERS[0].1, dt, phase);
            (phase, off / most)
        };
        Momentum {
            step,
            dt,
            groups: [0, 1].map(group),
            glances: (0..PHASES).map(hit).collect(),
        }
    };
    STEPS.iter().map(at).collect()
}

/// The least, the mean and the largest.
pub fn spread(values: impl Iterator<Item = f32> + Clone) -> [f32; 3] {
    let n = values.clone().count().max(1) as f32;
    let least = values.clone().fold(f32::INFINITY, f32::min);
    let most = values.clone().fold(f32::NEG_INFINITY, f32::max);
    [least, values.sum::<f32>() / n, most]
}
