//! Projected Gauss–Seidel: sweep until it is good enough, back and forth.

use super::blocks::{Blocks, Cone};
use super::{Direction, FrictionCone, Method, PointProblem, PointSolver};
use crate::solver::lanes::F32xN;
use crate::solver::{Lanes, SolveReport};

/// Projected Gauss–Seidel (Erleben 2007), one pair of bodies after the other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pgs {
    /// Sweeps over all contacts, at most.
    pub iterations: usize,
    /// The shape of the friction cone.
    pub cone: FrictionCone,
    /// Share of last step's impulses that a solve starts from, 0..1. With position feedback in the same velocities it is unstable when
    /// under-converged, so the paper's setting, and the default, is 0.
    pub warm_start: f32,
    /// A solve ends early when its residual (see [`merit`](super::merit)) falls below this. 0, the default: never.
    pub tolerance: f32,
    /// How many pairs of bodies are relaxed side by side; the result is that of one after the other to rounding.
    pub lanes: Lanes,
}

impl Default for Pgs {
    /// The paper's.
    fn default() -> Self {
        Self {
            iterations: 12,
            cone: FrictionCone::Circular,
            warm_start: 0.0,
            tolerance: 0.0,
            lanes: Lanes::Auto,
        }
    }
}

impl PointSolver for Pgs {
    fn name(&self) -> &str {
        "pgs"
    }

    fn problem(&self) -> Option<String> {
        super::problem(self.iterations, self.warm_start, self.tolerance, self.lanes)
    }

    fn warm_start(&self) -> f32 {
        self.warm_start
    }

    fn solve(&self, problem: &mut PointProblem) -> SolveReport {
        self.solve_in(self.lanes, self.cone, problem)
    }
}

impl Method for Pgs {
    fn solve_as<L: F32xN, C: Cone>(&self, problem: &mut PointProblem) -> SolveReport {
        let mut report = problem.report();
        let mut blocks = Blocks::<L, C>::of(problem);
        for k in 0..self.iterations {
            let direction = Direction::of_sweep(k, self.iterations);
            let change = blocks.sweep(direction);
            if report.record(change.sqrt()) <= self.tolerance {
                break;
            }
        }
        blocks.store(problem);
        report
    }
}
