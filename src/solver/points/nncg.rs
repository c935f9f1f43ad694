//! The nonsmooth nonlinear conjugate gradient solver (Silcowitz-Hansen, Niebe, Erleben 2010, "A nonsmooth nonlinear conjugate gradient
//! method for interactive contact force problems").
//!
//! A Gauss–Seidel sweep is a fixed-point iteration; its change r = Δλ is minus the gradient of a merit function ½‖r‖². Fletcher–Reeves
//! makes search directions from these: p ← β p + r with β = ‖r_k‖²/‖r_{k−1}‖², where the sweep itself takes the step r and β p is added. If
//! β exceeds 1, the direction is stale and starts anew.
//!
//! Three points differ from the paper. Sweeps go through the points of a pair back and forth, since a plain sweep is not a symmetric
//! operator, and the directions of a method that needs one go stale at once. The norm is weighted with the diagonal of W, since λ mixes
//! contacts of all masses. The last sweep is a plain one, or β p could leave λ outside the cone or negative.

use super::blocks::{Cone, Conjugate};
use super::{Direction, FrictionCone, Method, PointProblem, PointSolver};
use crate::solver::lanes::F32xN;
use crate::solver::{Lanes, SolveReport};

/// Number of consecutive restarts after which directions do not help, and plain sweeps do the rest.
const GIVE_UP: usize = 8;

/// The nonsmooth nonlinear conjugate gradient solver, which works on points: it converges, at the cost of more sweeps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nncg {
    /// Maximum number of sweeps over all contacts.
    pub iterations: usize,
    /// The shape of the friction cone.
    pub cone: FrictionCone,
    /// Share of last step's impulses that a solve starts from, 0..1; as [`Pgs::warm_start`](super::Pgs::warm_start).
    pub warm_start: f32,
    /// Residual (see [`merit`](super::merit)) below which a solve ends early. The default 0 means never.
    pub tolerance: f32,
    /// Number of pairs of bodies that are relaxed side by side. The result equals that of one after the other, up to rounding.
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
        let mut report = problem.report();
        let mut blocks = Conjugate::<L, C>::of(problem);
        let mut last = f32::INFINITY;
        let mut restarts = 0;
        for k in 0..self.iterations {
            let gradient = blocks.sweep(Direction::of_sweep(k, self.iterations));
            if report.record(gradient.sqrt()) <= self.tolerance || k + 1 == self.iterations {
                break;
            }
            if restarts == GIVE_UP {
                continue;
            }
            let beta = gradient / last;
            last = gradient;
            restarts = if beta > 1.0 { restarts + 1 } else { 0 };
            // In the first sweep β is 0, and a restart makes it 0; without any change it is NaN.
            let fresh = (0.0..=1.0).contains(&beta);
            blocks.turn(if fresh { beta } else { 0.0 });
        }
        blocks.store(problem);
        report
    }
}
