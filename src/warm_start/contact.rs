//! A touching pair, as its island gathers it. Its impulses have as many entries as its manifold has points and patches.

use crate::body::BodyState;
use crate::contact::{ContactImpulses, ContactPair, ContactTargets, Impulse, Manifold};
use crate::settings::StepTime;

/// One pair with points in an island that is solved.
pub(crate) struct SolverContact<'a> {
    pub island: u32,
    pub pair: &'a ContactPair,
    pub manifold: &'a Manifold,
    pub targets: &'a ContactTargets,
    pub impulses: &'a ContactImpulses,
    /// Its contacts were found anew, or its impulses are not those that the last solve left.
    pub changed: bool,
}

/// What a contact is sorted by: its island, then the body higher up, then the other, so that all supports of a brick are visited
/// together. Bodies stand in their problem in the order of their ranks; what is not in it stands still, comes before them, and goes
/// in spawn order.
pub(super) fn sort_key(island: u32, bodies: [&BodyState; 2], local: [u32; 2]) -> u128 {
    const MOVES: u64 = 1 << 63;
    let rank = |i: usize| match local[i] {
        u32::MAX => bodies[i].spawn_order.0 & !MOVES,
        local => MOVES | local as u64,
    };
    let (one, other) = (rank(0), rank(1));
    // The higher is in the problem, or the contact would be in none.
    let higher = one.max(other) as u32;
    (island as u128) << 96 | (higher as u128) << 64 | one.min(other) as u128
}

impl Impulse {
    /// The normal impulse to start from, N·s.
    #[inline]
    pub(super) fn start_normal(&self, time: &StepTime) -> f32 {
        start_impulse(self.warm_normal, self.load, time)
    }
}

/// An impulse, N·s, from the forces with which the last step ended and that act at rest, N. What a point carries at rest acts as long
/// as the step; what is more or less than that stopped or lost something, and would do so again and again in a step that is longer
/// than the last.
#[inline]
pub(super) fn start_impulse(warm: f32, load: f32, time: &StepTime) -> f32 {
    (load * time.dt + (warm - load) * time.carried()).max(0.0)
}
