//! Projected Gauss–Seidel: sweeps in alternating directions until the residual is small enough.

use super::blocks::{Blocks, Cone};
use super::{Direction, FrictionCone, Method, PointProblem, PointSolver};
use crate::lanes::F32xN;
use crate::{Lanes, SolveReport};
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::{Reflect, std_traits::ReflectDefault};

/// The projected Gauss–Seidel solver (Erleben 2007), which relaxes one pair of bodies after the other.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect), reflect(Debug, Default))]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Pgs {
    /// Maximum number of sweeps over all contacts.
    pub iterations: usize,
    /// The shape of the friction cone.
    pub cone: FrictionCone,
    /// Share of the last step's impulses that a solve starts from, 0..1. Default: 0, as in the paper. Warm starts are unstable if solves do
    /// not converge, because the same velocities contain the correction of positions.
    pub warm_start: f32,
    /// Residual (see [`merit`](super::merit)) below which a solve ends early. The default 0 means never.
    pub tolerance: f32,
    /// Number of pairs of bodies that are relaxed at once. It changes results only by rounding.
    pub lanes: Lanes,
}

impl Default for Pgs {
    /// The settings of the paper.
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
        let iterations = problem.sweeps(self.iterations);
        if problem.has_locks() {
            return problem.sweep_alone(iterations, self.tolerance, self.cone);
        }
        let mut report = problem.report();
        let mut blocks = Blocks::<L, C>::of(problem);
        for k in 0..iterations {
            let direction = Direction::of_sweep(k, iterations);
            let change = blocks.sweep(direction);
            if report.record(change.sqrt()) <= self.tolerance {
                break;
            }
        }
        blocks.store(problem);
        report
    }
}
