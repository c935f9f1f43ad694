//! Settings of the contact solver.

use super::Preset;
use crate::solver::{Nncg, PatchSolver, Pgs, PointSolver, SoftStep};
use bevy_ecs::prelude::*;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::{Reflect, std_traits::ReflectDefault};
use std::fmt;
use std::sync::Arc;

/// The contact solver, and how a step is divided.
#[derive(Resource, Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "bevy_reflect",
    derive(Reflect),
    reflect(Resource, Debug, Default)
)]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[component(clone_behavior = Ignore)]
pub struct SolverSettings {
    /// The contact solver with its settings. Default: [`SoftStep`].
    pub solver: ContactSolver,
    /// Whole steps of Δt/n that one step is cut into, detection included.
    pub outer_substeps: usize,
    /// Whether to record the merit after every sweep, in [`SolveReports`](crate::solve::SolveReports). Default: false.
    pub record_history: bool,
}

impl SolverSettings {
    /// The default settings with another solver.
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

/// The method that computes contact impulses: a built-in one, or one of your own behind one of the two solver traits.
///
/// Point solvers treat each contact point as a constraint, as the paper does. Patch solvers treat all points of a contact face together.
///
/// With the feature `serde`, built-in solvers can be written to files. A solver of your own cannot, because it is code; that is an error.
#[derive(Clone)]
#[cfg_attr(
    feature = "bevy_reflect",
    derive(Reflect),
    reflect(opaque),
    reflect(Clone, Debug, PartialEq)
)]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
pub enum ContactSolver {
    /// Drystone's own patch solver, the default.
    SoftStep(SoftStep),
    /// Projected Gauss–Seidel, a point solver.
    Pgs(Pgs),
    /// The nonsmooth nonlinear conjugate gradient method, a point solver; the one used in the paper.
    Nncg(Nncg),
    /// A patch solver of your own.
    Patches(Arc<dyn PatchSolver>),
    /// A point solver of your own.
    Points(Arc<dyn PointSolver>),
}

impl fmt::Debug for ContactSolver {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::SoftStep(solver) => solver.fmt(f),
            Self::Pgs(solver) => solver.fmt(f),
            Self::Nncg(solver) => solver.fmt(f),
            Self::Patches(solver) => f.debug_tuple("Patches").field(&solver.name()).finish(),
            Self::Points(solver) => f.debug_tuple("Points").field(&solver.name()).finish(),
        }
    }
}

/// A solver by its kind.
#[derive(Clone, Copy)]
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

    /// The name of the solver, for reports.
    pub fn name(&self) -> &str {
        match self.method() {
            Method::Patches(solver) => solver.name(),
            Method::Points(solver) => solver.name(),
        }
    }

    /// Checks the solver's settings. Returns a sentence that says what is wrong with them, or `None` if they are valid.
    pub fn problem(&self) -> Option<String> {
        match self.method() {
            Method::Patches(solver) => solver.problem(),
            Method::Points(solver) => solver.problem(),
        }
    }

    /// Returns true for point solvers, which need [`ContactTargets`](crate::contact::ContactTargets).
    pub fn is_point_solver(&self) -> bool {
        matches!(self.method(), Method::Points(_))
    }
}

/// The same method with the same settings. Solvers of your own are equal if they are the same instance.
impl PartialEq for ContactSolver {
    fn eq(&self, other: &Self) -> bool {
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

/// Run condition: true while the solver is a point solver.
pub fn uses_point_solver(settings: Res<SolverSettings>) -> bool {
    settings.solver.is_point_solver()
}
