//! A touching pair as part of the problem of its island. The user may have changed the lengths of its lists; an entry that is missing
//! counts as zero.

use crate::body::BodyTable;
use crate::pair::{
    ContactImpulses, ContactPair, ContactTargets, Impulse, Manifold, ManifoldPatch, PatchSurface,
};
use crate::settings::StepTime;

/// One pair with points, in an island that is solved.
pub(crate) struct SolverContact<'a> {
    pub pair: &'a ContactPair,
    pub manifold: &'a Manifold,
    pub targets: &'a ContactTargets,
    pub impulses: &'a ContactImpulses,
    pub table: &'a BodyTable,
}

impl SolverContact<'_> {
    /// The combined coefficients of a patch.
    #[inline]
    pub(super) fn surface(&self, patch: &ManifoldPatch) -> PatchSurface {
        self.pair.surface(patch, self.table)
    }
}

impl Impulse {
    /// The normal impulse to start from, N·s.
    #[inline]
    pub(super) fn start_normal(&self, time: &StepTime) -> f32 {
        start_impulse(self.normal_force, self.rest_force, time)
    }
}

/// The impulse to start from, N·s, from the forces (N) at the end of the last step (`warm`) and at rest (`load`). The force at rest acts as
/// long as the step. The difference between the two accelerated or stopped a body; in a step that is longer than the last it acts only as
/// long as the last one did, or it would do so again.
#[inline]
pub(super) fn start_impulse(warm: f32, load: f32, time: &StepTime) -> f32 {
    (load * time.dt + (warm - load) * time.carried()).max(0.0)
}
