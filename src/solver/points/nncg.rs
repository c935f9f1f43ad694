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

use super::{ContactSolver, Direction, Grouping, Problem, SolveReport};
use glam::Vec3;

/// After this many restarts in a row directions don't help, and plain sweeps do the rest.
const GIVE_UP: usize = 8;

/// See the module's text.
#[derive(Clone, Copy, Debug, Default)]
pub struct Nncg;

impl ContactSolver for Nncg {
    fn name(&self) -> &str {
        "nncg"
    }

    fn solve(&self, problem: &mut Problem) -> SolveReport {
        let mut report = SolveReport::default();
        let mut directions = vec![Vec3::ZERO; problem.contacts.len()];
        let mut before = vec![Vec3::ZERO; problem.contacts.len()];
        let mut last = f32::INFINITY;
        let mut restarts = 0;
        for k in 1..=problem.iterations {
            for (before, contact) in before.iter_mut().zip(problem.contacts.iter()) {
                *before = contact.impulse;
            }
            let sweep = Direction::of_sweep(k - 1, problem.iterations);
            let gradient = problem.sweep(sweep, Grouping::Point);
            if report.record(gradient.sqrt(), problem) || k == problem.iterations {
                break;
            }
            let beta = gradient / last;
            last = gradient;
            restarts = if beta > 1.0 { restarts + 1 } else { 0 };
            if restarts >= GIVE_UP {
                return finish(problem, report, k);
            }
            // On the first sweep β is 0, and on a restart it is made so.
            let beta = if beta > 1.0 { 0.0 } else { beta };
            let Problem {
                bodies, contacts, ..
            } = problem;
            for ((contact, before), p) in contacts.iter_mut().zip(&before).zip(&mut directions) {
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

/// The remaining sweeps without directions.
fn finish(problem: &mut Problem, mut report: SolveReport, done: usize) -> SolveReport {
    for k in done..problem.iterations {
        let sweep = Direction::of_sweep(k, problem.iterations);
        let merit = problem.sweep(sweep, Grouping::Point).sqrt();
        if report.record(merit, problem) {
            break;
        }
    }
    report
}
