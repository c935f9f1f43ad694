//! Projected Gauss–Seidel: sweep until it is good enough.

use super::{ContactSolver, Direction, Problem, SolveReport};

/// Projected Gauss–Seidel (Erleben 2007), one contact point after the other.
#[derive(Clone, Copy, Debug, Default)]
pub struct Pgs;

impl ContactSolver for Pgs {
    fn name(&self) -> &str {
        "pgs"
    }

    fn solve(&self, problem: &mut Problem) -> SolveReport {
        let mut report = SolveReport::default();
        for _ in 0..problem.iterations {
            let merit = problem.sweep(Direction::Forwards).sqrt();
            if report.record(merit, problem) {
                break;
            }
        }
        report
    }
}
