//! A touching pair as part of the problem of its island. Its impulses have as many entries as its manifold has points and patches.

use crate::body::{BodyState, BodyTable};
use crate::children::PatchSurface;
use crate::contact::{
    ContactImpulses, ContactPair, ContactTargets, Impulse, Manifold, ManifoldPatch,
};
use crate::settings::StepTime;

/// One pair with points, in an island that is solved.
pub(crate) struct SolverContact<'a> {
    pub island: u32,
    pub pair: &'a ContactPair,
    pub manifold: &'a Manifold,
    pub targets: &'a ContactTargets,
    pub impulses: &'a ContactImpulses,
    /// Whether the contacts were detected anew, or the impulses differ from those that the last solve stored.
    pub changed: bool,
    pub table: &'a BodyTable,
}

impl SolverContact<'_> {
    /// The combined coefficients of a patch.
    #[inline]
    pub(super) fn surface(&self, patch: &ManifoldPatch) -> PatchSurface {
        self.pair.surface(patch, self.table)
    }
}

/// The sort key of a contact: its island, then its higher body, then its lower body, so that all supports of a brick are visited together.
/// Bodies of the problem are ordered by rank. Static and kinematic bodies are not in it: they come before the others, in spawn order.
pub(super) fn sort_key(island: u32, bodies: [&BodyState; 2], local: [u32; 2]) -> u128 {
    const MOVES: u64 = 1 << 63;
    let rank = |i: usize| match local[i] {
        u32::MAX => bodies[i].spawn_order.0 & !MOVES,
        local => MOVES | local as u64,
    };
    let (one, other) = (rank(0), rank(1));
    // The higher body is always in the problem, because a contact without a body in the problem is not solved.
    let higher = one.max(other) as u32;
    (island as u128) << 96 | (higher as u128) << 64 | one.min(other) as u128
}

impl Impulse {
    /// The normal impulse to start from, N·s.
    #[inline]
    pub(super) fn start_normal(&self, time: &StepTime) -> f32 {
        start_impulse(self.normal_force, self.rest_force, time)
    }
}

/// The impulse to start from, N·s, from the forces (N) at the end of the last step (`warm`) and at rest (`load`). The force at rest acts as
/// long as the step. The difference between the two accelerated or stopped a body; in a step that is longer than the last it acts only as long
/// as the last one did, or it would do so again.
#[inline]
pub(super) fn start_impulse(warm: f32, load: f32, time: &StepTime) -> f32 {
    (load * time.dt + (warm - load) * time.carried()).max(0.0)
}
