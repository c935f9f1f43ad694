//! A pair that is solved. Its impulses have as many entries as its manifold has points and patches; who gathers and stores them goes through
//! the patches that have points.

use crate::body::BodyState;
use crate::contact::{ContactImpulses, ContactPair, ContactTargets, Impulse, Manifold};
use crate::settings::StepTime;

/// One pair with points in an island that is awake.
pub(super) struct Touch<'a> {
    pub island: u32,
    pub pair: &'a ContactPair,
    pub manifold: &'a Manifold,
    pub targets: &'a ContactTargets,
    pub impulses: &'a mut ContactImpulses,
    /// Its contacts were found anew, or its impulses are not those that the last solve left.
    pub changed: bool,
}

/// What a touch is sorted by: its island, then the body higher up, then the other, so that all supports of a brick are visited
/// together. Bodies stand in their problem in the order of their ranks; what is not in it stands still, comes before them, and goes
/// by age.
pub(super) fn place(island: u32, bodies: [&BodyState; 2], local: [u32; 2]) -> u128 {
    const MOVES: u64 = 1 << 63;
    let rank = |i: usize| match local[i] {
        u32::MAX => bodies[i].age.0 & !MOVES,
        local => MOVES | local as u64,
    };
    let (one, other) = (rank(0), rank(1));
    // The higher is in the problem, or the touch would be in none.
    let higher = one.max(other) as u32;
    (island as u128) << 96 | (higher as u128) << 64 | one.min(other) as u128
}

impl Impulse {
    /// λ_n, N·s.
    #[inline]
    pub(super) fn normal_to_start_from(&self, time: &StepTime) -> f32 {
        to_start_from(self.warm_normal, self.load, time)
    }
}

/// An impulse, N·s, from the forces with which the last step ended and that act at rest, N. What a point carries at rest acts as long
/// as the step; what is more or less than that stopped or lost something, and would do so again and again in a step that is longer
/// than the last.
#[inline]
pub(super) fn to_start_from(warm: f32, load: f32, time: &StepTime) -> f32 {
    (load * time.dt + (warm - load) * time.carried()).max(0.0)
}
