//! The nonsmooth nonlinear conjugate gradient solver (Silcowitz-Hansen, Niebe, Erleben 2010, "A nonsmooth nonlinear conjugate gradient
//! method for interactive contact force problems").
//!
//! A Gauss–Seidel sweep is a fixed-point iteration. Its change r = Δλ is treated as the negative gradient of a merit function ½‖r‖². The
//! method of Fletcher and Reeves builds search directions from these changes: p ← β p + r with β = ‖r_k‖²/‖r_{k−1}‖². The sweep itself
//! takes the step r, and β p is added afterwards. If β exceeds 1 the direction has become useless, and the method restarts.
//!
//! Three things differ from the paper. First, the direction of sweeps through the points of a pair alternates. The method needs a symmetric
//! operator, which a plain sweep is not, and would restart at once. Second, the norm is weighted with the diagonal of W, because contacts
//! have very different masses. Third, the last sweep is a plain one, because β p may make λ negative or move it out of the friction cone.

use super::blocks::{Cone, Conjugate};
use super::{Direction, FrictionCone, Method, PointProblem, PointSolver};
use crate::lanes::F32xN;
use crate::{Lanes, SolveReport};
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::{Reflect, std_traits::ReflectDefault};

/// Number of consecutive restarts after which the method continues with plain sweeps.
const MAX_RESTARTS: usize = 8;

/// The nonsmooth nonlinear conjugate gradient solver, a point solver. It converges, at the cost of more sweeps.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect), reflect(Debug, Default))]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Nncg {
    /// Maximum number of sweeps over all contacts.
    pub iterations: usize,
    /// The shape of the friction cone.
    pub cone: FrictionCone,
    /// Share of the last step's impulses that a solve starts from, 0..1. See [`Pgs::warm_start`](super::Pgs::warm_start).
    pub warm_start: f32,
    /// Residual (see [`merit`](super::merit)) below which a solve ends early. The default 0 means never.
    pub tolerance: f32,
    /// Number of pairs of bodies that are relaxed at once. It changes results only by rounding.
    pub lanes: Lanes,
}

impl Default for Nncg {
    /// The settings of the paper.
    fn default() -> Self {
        Self {
            iterations: 75,
            cone: FrictionCone::Circular,
            warm_start: 0.0,
            tolerance: 0.0,
            lanes: Lanes::Auto,
        }
    }
}

impl PointSolver for Nncg {
    fn name(&self) -> &str {
        "nncg"
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

impl Method for Nncg {
    fn solve_as<L: F32xN, C: Cone>(&self, problem: &mut PointProblem) -> SolveReport {
        let iterations = problem.sweeps(self.iterations);
        if problem.has_locks() {
            return problem.sweep_alone(iterations, self.tolerance, self.cone);
        }
        let mut report = problem.report();
        let mut blocks = Conjugate::<L, C>::of(problem);
        let mut last = f32::INFINITY;
        let mut restarts = 0;
        for k in 0..iterations {
            let gradient = blocks.sweep(Direction::of_sweep(k, iterations));
            if report.record(gradient.sqrt()) <= self.tolerance || k + 1 == iterations {
                break;
            }
            if restarts == MAX_RESTARTS {
                continue;
            }
            let beta = gradient / last;
            last = gradient;
            restarts = if beta > 1.0 { restarts + 1 } else { 0 };
            // β is 0 in the first sweep, and NaN if nothing changed.
            let fresh = (0.0..=1.0).contains(&beta);
            blocks.turn(if fresh { beta } else { 0.0 });
        }
        blocks.store(problem);
        report
    }
}
