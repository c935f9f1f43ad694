//! The contacts of an island in the form that its solver takes.

use super::{PatchRows, PointRows, SolveContext, SolverContact};
use crate::settings::Method;
use crate::solver::Body;

/// The contacts of an island, as patches or as points.
pub(crate) enum Rows {
    Patches(PatchRows),
    Points(PointRows),
}

impl Default for Rows {
    fn default() -> Self {
        Self::Patches(PatchRows::default())
    }
}

impl Rows {
    /// Makes them those for a solver. They are empty if the last one was of another kind.
    pub fn suit(&mut self, method: Method) {
        match (&*self, method) {
            (Self::Patches(_), Method::Patches(_)) | (Self::Points(_), Method::Points(_)) => {}
            (_, Method::Patches(_)) => *self = Self::Patches(PatchRows::default()),
            (_, Method::Points(_)) => *self = Self::Points(PointRows::default()),
        }
    }

    pub fn clear(&mut self) {
        match self {
            Self::Patches(rows) => rows.clear(),
            Self::Points(rows) => rows.clear(),
        }
    }

    /// Number of contact points.
    pub fn points(&self) -> usize {
        match self {
            Self::Patches(rows) => rows.points.len(),
            Self::Points(rows) => rows.constraints.len(),
        }
    }

    /// Takes the contacts of an island, between bodies at `ends`. Impulses are still forces, N. If the rows hold those of the last step,
    /// which were of the same pairs between the same bodies, unchanged rows may be kept.
    pub fn refresh(
        &mut self,
        contacts: &[SolverContact],
        ends: &[[u32; 2]],
        bodies: &[Body],
        context: &SolveContext,
    ) {
        match self {
            Self::Patches(rows) => rows.refresh(contacts, ends, context),
            Self::Points(rows) => rows.refresh(contacts, ends, bodies, context),
        }
    }

    /// Sets the impulses that contacts start from.
    pub fn warm_start(&mut self, contacts: &[SolverContact], context: &SolveContext) {
        match self {
            Self::Patches(rows) => rows.warm_start(context),
            Self::Points(rows) => rows.warm_start(contacts, context),
        }
    }

    /// The sum of the normal impulses that a contact starts from, N·s.
    pub fn start_impulse(&self, contact: usize) -> f32 {
        match self {
            Self::Patches(rows) => rows.start_impulse(contact),
            Self::Points(rows) => rows.start_impulse(contact),
        }
    }
}
