//! How a solve went.

/// Begun with what the free motion misses ([`SolveReport::new`]), and told of every sweep.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SolveReport {
    /// Sweeps taken.
    pub sweeps: usize,
    /// The merit of the last sweep, relative to the free motion's. See [`merit`](super::merit).
    pub residual: f32,
    /// The residual after each sweep, if asked for.
    pub history: Vec<f32>,
    free_merit: f32,
    records: bool,
}

impl SolveReport {
    /// Of a solve whose free motion has this merit, √J. Keeps a history if it `records`.
    pub fn new(free_merit: f32, records: bool) -> Self {
        Self {
            free_merit,
            records,
            ..Default::default()
        }
    }

    /// Of a solve that is over: the merits of the free motion and of the last of so many sweeps, √J.
    pub fn of(free_merit: f32, sweeps: usize, merit: f32) -> Self {
        let mut report = Self::new(free_merit, false);
        report.record(merit);
        Self { sweeps, ..report }
    }

    /// Notes a sweep whose merit was √(Σ Wᵢᵢ Δλᵢ²) = `merit`, √J; returns the residual.
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
