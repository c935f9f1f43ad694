//! Projected Gauss–Seidel: sweep until it is good enough, back and forth.

use super::{ContactSolver, Direction, Grouping, Problem, SolveReport};

/// Projected Gauss–Seidel (Erleben 2007), one pair of bodies after the other.
#[derive(Clone, Copy, Debug, Default)]
pub struct Pgs;

impl ContactSolver for Pgs {
    fn name(&self) -> &str {
        "pgs"
    }

    fn solve(&self, problem: &mut Problem) -> SolveReport {
        let mut report = SolveReport::default();
        for k in 0..problem.iterations {
            let direction = Direction::of_sweep(k, problem.iterations);
            let merit = problem.sweep(direction, Grouping::Pair).sqrt();
            if report.record(merit, problem) {
                break;
            }
        }
        report
    }
}
