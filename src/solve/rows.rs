//! Solving the contacts of an island by a solver of their kind, and storing their impulses.

use crate::pair::{ContactImpulses, Manifold};
use crate::settings::Method;
use crate::solver::{Body, GrabConstraint, JointConstraint, SolveReport};
use crate::warm_start::{PatchRows, Rows, SolveContext};

impl Rows {
    /// Solves an island with a multiple of the usual number of sweeps.
    pub(super) fn solve(
        &mut self,
        method: Method,
        bodies: &mut [Body],
        grabs: &mut [GrabConstraint],
        joints: &mut [JointConstraint],
        effort_and_context: (f32, &SolveContext),
    ) -> SolveReport {
        match (self, method) {
            (Self::Patches(rows), Method::Patches(solver)) => {
                rows.solve(solver, bodies, grabs, joints, effort_and_context)
            }
            (Self::Points(rows), Method::Points(solver)) => {
                rows.solve(solver, bodies, grabs, joints, effort_and_context)
            }
            (Self::Patches(_), Method::Points(_)) | (Self::Points(_), Method::Patches(_)) => {
                unreachable!("the stage *warm start* gathers rows for the solver that it prepares")
            }
        }
    }

    /// Returns true if an island with this many contacts is best solved together with others.
    pub(super) fn is_small(&self, contacts: usize) -> bool {
        match self {
            Self::Patches(rows) => rows.is_small(contacts),
            Self::Points(_) => false,
        }
    }

    /// Solves several small islands without grabs and joints, with the usual effort.
    pub(super) fn solve_each(
        method: Method,
        islands: &mut [(&mut Self, &mut [Body])],
        context: &SolveContext,
    ) -> Vec<SolveReport> {
        let mut patches = Vec::with_capacity(islands.len());
        for (rows, bodies) in islands.iter_mut() {
            match rows {
                Self::Patches(rows) => patches.push((rows, &mut **bodies)),
                Self::Points(_) => unreachable!("islands of points are not small"),
            }
        }
        match method {
            Method::Patches(solver) => PatchRows::solve_each(solver, &mut patches, context),
            Method::Points(_) => unreachable!("islands of points are not small"),
        }
    }

    /// Writes the impulses of a contact to its pair. Returns false, and leaves the pair's impulses in an unspecified state, if its manifold
    /// has other patches or points than those that were gathered.
    pub(crate) fn store(
        &self,
        contact: usize,
        manifold: &Manifold,
        to: &mut ContactImpulses,
        dt: f32,
    ) -> bool {
        match self {
            Self::Patches(rows) => rows.store(contact, manifold, to, dt),
            Self::Points(rows) => rows.store(contact, manifold, to, dt),
        }
    }
}
