//! Solving the contacts of an island by a solver of their kind, and storing their impulses.

use crate::pair::{ContactImpulses, Manifold};
use crate::settings::Method;
use crate::solver::{Body, GrabConstraint, JointConstraint, SolveReport};
use crate::warm_start::{Rows, SolveContext};

impl Rows {
    /// Solves an island with a multiple of the usual number of sweeps; `broke` says whether some of its bodies have just broken off others.
    pub(super) fn solve(
        &mut self,
        method: Method,
        bodies: &mut [Body],
        grabs: &mut [GrabConstraint],
        joints: &mut [JointConstraint],
        (effort, broke, context): (f32, bool, &SolveContext),
    ) -> SolveReport {
        match (self, method) {
            (Self::Patches(rows), Method::Patches(solver)) => {
                rows.solve(solver, bodies, grabs, joints, (effort, broke, context))
            }
            (Self::Points(rows), Method::Points(solver)) => {
                rows.solve(solver, bodies, grabs, joints, (effort, context))
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
