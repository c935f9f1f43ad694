//! Reports of solves.

#[cfg(feature = "bevy_reflect")]
use bevy_reflect::{Reflect, std_traits::ReflectDefault};
/// The report of a solve: created from the merit of the free motion ([`SolveReport::new`]), then updated after every sweep.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect), reflect(Debug, Default))]
pub struct SolveReport {
    /// Number of sweeps.
    pub sweeps: usize,
    /// The merit of the last sweep, relative to that of the free motion. See [`merit`](super::merit).
    pub residual: f32,
    /// The residual after each sweep, if requested.
    pub history: Vec<f32>,
    free_merit: f32,
    records: bool,
}

impl SolveReport {
    /// A report for a free motion with this merit, √J. It keeps a history if it `records`.
    pub fn new(free_merit: f32, records: bool) -> Self {
        Self {
            free_merit,
            records,
            ..Default::default()
        }
    }

    /// The report of a finished solve, from the merits of the free motion and of the last of `sweeps` sweeps, √J.
    pub fn of(free_merit: f32, sweeps: usize, merit: f32) -> Self {
        let mut report = Self::new(free_merit, false);
        report.record(merit);
        Self { sweeps, ..report }
    }

    /// Records a sweep whose merit √(Σ Wᵢᵢ Δλᵢ²) is `merit`, √J; returns the residual.
    pub fn record(&mut self, merit: f32) -> f32 {
        self.sweeps += 1;
        self.residual = match self.free_merit > 0.0 {
            true => merit / self.free_merit,
            false => 0.0,
        };
        if self.records {
            self.history.push(self.residual);
        }
        self.residual
    }
}
