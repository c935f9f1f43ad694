//! The nonsmooth nonlinear conjugate gradient solver (Silcowitz-Hansen, Niebe, Erleben 2010, "A nonsmooth nonlinear
//! conjugate gradient method for interactive contact force problems").
//!
//! A Gauss–Seidel sweep is a fixed-point iteration; what it changes, r = Δλ, is minus the gradient of a merit function
//! ½‖r‖². Fletcher–Reeves makes search directions from these: p ← β p + r with β = ‖r_k‖²/‖r_{k−1}‖², where the sweep itself
//! takes the step r and β p is added. A β above 1 says that the direction has gone stale, and it starts anew.
//!
//! Three things differ from the paper. Sweeps go through the points of a pair back and forth, since a plain sweep is no
//! symmetric operator, and the directions of a method made for such go stale at once. The norm is weighed with the
//! diagonal of W, since λ mixes contacts of all masses. And the last sweep is a plain one, or λ could leave the cone or turn
//! negative by what β p added.

use super::blocks::{Cone, Conjugate};
use super::{Direction, FrictionCone, Method, PointProblem, PointSolver};
use crate::solver::lanes::F32xN;
use crate::solver::{Lanes, SolveReport};

/// After this many restarts in a row directions don't help, and plain sweeps do the rest.
const GIVE_UP: usize = 8;

/// The nonsmooth nonlinear conjugate gradient solver, which works on points: it converges, at the price of more sweeps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nncg {
    /// Sweeps over all contacts, at most.
    pub iterations: usize,
    /// The shape of the friction cone.
    pub cone: FrictionCone,
    /// Share of last step's impulses that a solve starts from, 0..1; as [`Pgs::warm_start`](super::Pgs::warm_start).
    pub warm_start: f32,
    /// A solve ends early when its residual (see [`merit`](super::merit)) falls below this. 0, the default: never.
    pub tolerance: f32,
    /// How many pairs of bodies are relaxed side by side; the result is that of one after the other to rounding.
    pub lanes: Lanes,
}

impl Default for Nncg {
    /// The paper's.
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
            // On the first sweep β is 0, and on a restart it is made so; where nothing changes any more it is no number.
            let fresh = (0.0..=1.0).contains(&beta);
            blocks.turn(if fresh { beta } else { 0.0 });
        }
        blocks.store(problem);
        report
    }
}
