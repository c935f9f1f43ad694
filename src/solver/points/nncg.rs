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

use super::{Direction, FrictionCone, Grouping, PointProblem, PointSolver};
use crate::solver::SolveReport;
use glam::Vec3;

/// After this many restarts in a row directions don't help, and plain sweeps do the rest.
const GIVE_UP: usize = 8;

/// See the module's text.
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
}

impl Default for Nncg {
    /// The paper's.
    fn default() -> Self {
        Self {
            iterations: 75,
            cone: FrictionCone::Circular,
            warm_start: 0.0,
            tolerance: 0.0,
        }
    }
}

impl PointSolver for Nncg {
    fn name(&self) -> &str {
        "nncg"
    }

    fn problem(&self) -> Option<String> {
        super::problem(self.iterations, self.warm_start, self.tolerance)
    }

    fn warm_start(&self) -> f32 {
        self.warm_start
    }

    fn solve(&self, problem: &mut PointProblem) -> SolveReport {
        let mut report = problem.report();
        let mut directions = vec![Vec3::ZERO; problem.constraints.len()];
        let mut before = vec![Vec3::ZERO; problem.constraints.len()];
        let mut last = f32::INFINITY;
        let mut restarts = 0;
        for k in 1..=self.iterations {
            for (before, contact) in before.iter_mut().zip(&*problem.constraints) {
                *before = contact.impulse;
            }
            let sweep = Direction::of_sweep(k - 1, self.iterations);
            let gradient = problem.sweep(sweep, Grouping::Point, self.cone);
            if report.record(gradient.sqrt()) <= self.tolerance || k == self.iterations {
                break;
            }
            let beta = gradient / last;
            last = gradient;
            restarts = if beta > 1.0 { restarts + 1 } else { 0 };
            if restarts >= GIVE_UP {
                return self.finish(problem, report, k);
            }
            // On the first sweep β is 0, and on a restart it is made so.
            let beta = if beta > 1.0 { 0.0 } else { beta };
            let PointProblem {
                bodies,
                constraints,
                ..
            } = problem;
            for ((contact, before), p) in constraints.iter_mut().zip(&before).zip(&mut directions) {
                let r = contact.impulse - *before;
                let step = beta * *p;
                if beta > 0.0 {
                    contact.add(bodies, step);
                }
                *p = step + r;
            }
        }
        report
    }
}

impl Nncg {
    /// The remaining sweeps without directions.
    fn finish(
        &self,
        problem: &mut PointProblem,
        mut report: SolveReport,
        done: usize,
    ) -> SolveReport {
        for k in done..self.iterations {
            let sweep = Direction::of_sweep(k, self.iterations);
            let change = problem.sweep(sweep, Grouping::Point, self.cone);
            if report.record(change.sqrt()) <= self.tolerance {
                break;
            }
        }
        report
    }
}
