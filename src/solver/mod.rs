//! Contact solvers on plain slices: this folder knows neither the ECS nor shapes.
//!
//! A [`Problem`] is one island: bodies with velocities and inverse inertias, and contact points, each with a bound on its
//! normal velocity and a demand on its tangential one. A [`ContactSolver`] finds impulses λ so that
//!
//! - w_n ≥ b_n, λ_n ≥ 0, λ_n (w_n − b_n) = 0 for each normal, and
//! - λ_t is the vector inside the friction cone ‖λ_t‖ ≤ μ λ_n that brings w_t nearest to b_t,
//!
//! and changes the velocities by them. [`Pgs`] and [`Nncg`] are the paper's two; [`ContactSolver`] is open for others:
//!
//! ```
//! use drystone::solver::{ContactSolver, Direction, Grouping, Problem, SolveReport};
//! use drystone::settings::SolverSettings;
//! use std::sync::Arc;
//!
//! /// Plain Gauss–Seidel, three sweeps, whatever was asked for.
//! struct ThreeSweeps;
//!
//! impl ContactSolver for ThreeSweeps {
//!     fn name(&self) -> &str {
//!         "three-sweeps"
//!     }
//!
//!     fn solve(&self, problem: &mut Problem) -> SolveReport {
//!         let mut report = SolveReport::default();
//!         for _ in 0..3 {
//!             let merit = problem.sweep(Direction::Forwards, Grouping::Pair).sqrt();
//!             report.record(merit, problem);
//!         }
//!         report
//!     }
//! }
//!
//! let settings = SolverSettings { solver: Arc::new(ThreeSweeps), ..Default::default() };
//! assert_eq!(settings.solver.name(), "three-sweeps");
//! ```

use glam::Vec3;

pub mod merit;
mod nncg;
mod patch;
mod pgs;
mod rows;
mod soft_step;

pub use nncg::Nncg;
pub use patch::{Patch, PatchPoint, Slip};
pub use pgs::Pgs;
pub use rows::{Body, Contact, ContactInput, tangents};
pub use soft_step::{Lanes, SoftStep};

/// A method that finds contact impulses. Must be deterministic; islands are solved side by side.
pub trait ContactSolver: Send + Sync {
    /// A short name for reports.
    fn name(&self) -> &str;

    /// What it works on: which of a problem's lists are filled for it.
    fn rows(&self) -> Rows {
        Rows::Points
    }

    /// What is wrong with its own settings, as a sentence; it is not asked to solve then.
    fn problem(&self) -> Option<String> {
        None
    }

    /// Changes impulses and velocities of `problem` towards a solution.
    fn solve(&self, problem: &mut Problem) -> SolveReport;
}

/// The unknowns that a solver works on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rows {
    /// λ_n and λ_t of every point: [`Problem::contacts`], with velocities that hold this step's forces and the impulses that
    /// contacts start with. Bodies then move with the velocities found.
    Points,
    /// λ_n of every point, but one friction force and one twist for a patch: [`Problem::patches`] and [`Problem::points`]. Such a
    /// solver takes substeps of its own: it begins at [`Body::start`], and says in [`Body::motion`] how bodies moved.
    Patches,
}

/// The set that the friction impulses of one point are projected to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FrictionCone {
    /// ‖λ_t‖ ≤ μ λ_n
    #[default]
    Circular,
    /// |λ_t1|, |λ_t2| ≤ μ λ_n on two fixed tangents: cheaper to reason about, up to √2 too strong along the diagonal.
    Box,
}

/// One island, ready to be solved. Contacts have been prepared ([`Contact::prepare`]) and velocities hold the effect of the
/// impulses they start with.
pub struct Problem<'a> {
    /// All bodies of the island, and copies of the static and kinematic ones it touches.
    pub bodies: &'a mut [Body],
    /// All contact points, in the order in which they are swept.
    pub contacts: &'a mut [Contact],
    /// All patches, in the order in which they are swept, for a solver of [`Rows::Patches`].
    pub patches: &'a mut [Patch],
    /// The points of all patches.
    pub points: &'a mut [PatchPoint],
    /// Length of the step, s.
    pub dt: f32,
    /// The longest of recent steps, s; not shorter than this one. What is as stiff as the step allows must not become stiffer for one
    /// that is short by chance.
    pub longest: f32,
    /// Acceleration of free fall, m/s².
    pub gravity: Vec3,
    /// Fastest correction of an error of position, m/s.
    pub max_correction_speed: f32,
    /// The shape of the friction cone.
    pub cone: FrictionCone,
    /// Sweeps, at most.
    pub iterations: usize,
    /// Stop when the merit falls below this.
    pub tolerance: f32,
    /// The merit of the free motion, √J; what residuals are relative to. See [`merit`].
    pub free_merit: f32,
    /// Keep [`SolveReport::history`].
    pub record_history: bool,
}

impl Problem<'_> {
    /// One projected Gauss–Seidel sweep over all contacts, pair after pair: Σ Wᵢᵢ Δλᵢ², J.
    pub fn sweep(&mut self, direction: Direction, grouping: Grouping) -> f32 {
        let (bodies, cone) = (&mut *self.bodies, self.cone);
        let mut change = 0.0;
        for pair in self.contacts.chunk_by_mut(|a, b| a.bodies == b.bodies) {
            match grouping {
                Grouping::Pair => {
                    direction.visit(pair, |c| change += c.relax_normal(bodies));
                    direction.visit(pair, |c| change += c.relax_friction(bodies, cone));
                }
                Grouping::Point => direction.visit(pair, |c| {
                    change += c.relax_normal(bodies);
                    change += c.relax_friction(bodies, cone);
                }),
            }
        }
        change
    }

    /// A merit of Σ Wᵢᵢ Δλᵢ² = `merit`² relative to that of the free motion.
    pub fn relative(&self, merit: f32) -> f32 {
        if self.free_merit > 0.0 {
            merit / self.free_merit
        } else {
            0.0
        }
    }
}

/// The way through the points of a pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// In the order in which they stand: deepest first.
    Forwards,
    /// In the reverse.
    Backwards,
}

impl Direction {
    /// That of sweep `k` of `n`, counted from 0: back and forth, the last one forwards.
    ///
    /// Always the same way, and the first points of each manifold keep more than their share of the load, which makes stacks rock
    /// and the directions of conjugate gradients go stale.
    pub fn of_sweep(k: usize, n: usize) -> Self {
        if (n - k) % 2 == 1 {
            Self::Forwards
        } else {
            Self::Backwards
        }
    }

    fn visit(self, pair: &mut [Contact], relax: impl FnMut(&mut Contact)) {
        match self {
            Self::Forwards => pair.iter_mut().for_each(relax),
            Self::Backwards => pair.iter_mut().rev().for_each(relax),
        }
    }
}

/// When the friction of a pair is relaxed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Grouping {
    /// After the normals of all its points. Friction is bounded by what the points carry, and the first ones would be bounded by
    /// a load that they are about to hand on: better for few plain sweeps.
    Pair,
    /// After the normal of each point: smoother, better under conjugate gradients.
    Point,
}

/// How a solve went.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SolveReport {
    /// Sweeps taken.
    pub sweeps: usize,
    /// The merit of the last sweep, relative to the free motion's.
    pub residual: f32,
    /// The residual after each sweep, if asked for.
    pub history: Vec<f32>,
}

impl SolveReport {
    /// Notes a sweep whose merit was √(Σ Wᵢᵢ Δλᵢ²) = `merit`. True when it was good enough to stop.
    pub fn record(&mut self, merit: f32, problem: &Problem) -> bool {
        self.sweeps += 1;
        self.residual = problem.relative(merit);
        if problem.record_history {
            self.history.push(self.residual);
        }
        self.residual <= problem.tolerance
    }
}
