//! Which solver finds the impulses.

use super::Preset;
use crate::solver::{Nncg, PatchSolver, Pgs, PointSolver, SoftStep};
use bevy_ecs::prelude::*;
use std::sync::Arc;

/// Which solver, and how a step is cut.
#[derive(Resource, Clone)]
pub struct SolverSettings {
    /// Drystone's own with their settings, or a user's.
    pub solver: ContactSolver,
    /// Whole steps of Δt/n that one step is cut into, detection included.
    pub outer_substeps: usize,
    /// Keep the merit after every sweep (see [`crate::solve::SolveReports`]).
    pub record_history: bool,
}

impl SolverSettings {
    /// The default settings with this solver.
    pub fn new(solver: impl Into<ContactSolver>) -> Self {
        Self {
            solver: solver.into(),
            ..Default::default()
        }
    }
}

impl Default for SolverSettings {
    fn default() -> Self {
        Preset::Default.solver()
    }
}

/// A method that finds contact impulses, of one of two kinds.
#[derive(Clone)]
pub enum ContactSolver {
    /// The default.
    SoftStep(SoftStep),
    /// Projected Gauss–Seidel, by points.
    Pgs(Pgs),
    /// The nonsmooth nonlinear conjugate gradient method, by points.
    Nncg(Nncg),
    /// A user's own, by patches.
    Patches(Arc<dyn PatchSolver>),
    /// A user's own, by points.
    Points(Arc<dyn PointSolver>),
}

/// The kind of a solver, and it.
pub(crate) enum Method<'a> {
    Patches(&'a (dyn PatchSolver + 'static)),
    Points(&'a (dyn PointSolver + 'static)),
}

impl ContactSolver {
    pub(crate) fn method(&self) -> Method<'_> {
        match self {
            Self::SoftStep(solver) => Method::Patches(solver),
            Self::Patches(solver) => Method::Patches(&**solver),
            Self::Pgs(solver) => Method::Points(solver),
            Self::Nncg(solver) => Method::Points(solver),
            Self::Points(solver) => Method::Points(&**solver),
        }
    }

    /// A short name for reports.
    pub fn name(&self) -> &str {
        match self.method() {
            Method::Patches(solver) => solver.name(),
            Method::Points(solver) => solver.name(),
        }
    }

    /// What is wrong with its settings, as a sentence.
    pub fn problem(&self) -> Option<String> {
        match self.method() {
            Method::Patches(solver) => solver.problem(),
            Method::Points(solver) => solver.problem(),
        }
    }

    /// True where it works on points, so that their bounds and demands ([`ContactTargets`](crate::contact::ContactTargets)) are
    /// to be found for it.
    pub fn is_by_points(&self) -> bool {
        matches!(self.method(), Method::Points(_))
    }

    /// The same method with the same settings.
    pub(crate) fn is_same(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::SoftStep(a), Self::SoftStep(b)) => a == b,
            (Self::Pgs(a), Self::Pgs(b)) => a == b,
            (Self::Nncg(a), Self::Nncg(b)) => a == b,
            (Self::Patches(a), Self::Patches(b)) => Arc::ptr_eq(a, b),
            (Self::Points(a), Self::Points(b)) => Arc::ptr_eq(a, b),
            _ => false,
        }
    }
}

impl From<SoftStep> for ContactSolver {
    fn from(solver: SoftStep) -> Self {
        Self::SoftStep(solver)
    }
}

impl From<Pgs> for ContactSolver {
    fn from(solver: Pgs) -> Self {
        Self::Pgs(solver)
    }
}

impl From<Nncg> for ContactSolver {
    fn from(solver: Nncg) -> Self {
        Self::Nncg(solver)
    }
}

/// Run condition: the solver is one of points.
pub fn solves_points(settings: Res<SolverSettings>) -> bool {
    settings.solver.is_by_points()
}
