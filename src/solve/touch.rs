//! The pairs that are solved, in the order of their solve.

use super::Pairs;
use crate::body::{BodyState, BodyTable};
use crate::contact::{ContactImpulses, ContactPair, ContactTargets, Impulse, Manifold};
use crate::islands::Islands;
use crate::settings::StepTime;

/// One pair with points in an island that is awake.
pub(super) struct Touch<'a> {
    pub island: u32,
    /// See [`place`].
    place: u128,
    pub pair: &'a ContactPair,
    pub manifold: &'a Manifold,
    pub targets: &'a ContactTargets,
    pub impulses: &'a mut ContactImpulses,
}

/// All of them, island after island. `local` as in [`Places`](super::Places).
pub(super) fn touches<'a>(
    table: &BodyTable,
    islands: &Islands,
    local: &[u32],
    pairs: &'a mut Pairs,
) -> Vec<Touch<'a>> {
    let mut touches: Vec<Touch> = Vec::with_capacity(pairs.iter().len());
    for (pair, manifold, targets, impulses) in pairs {
        let [Some(a), Some(b)] = pair.slots.map(|slot| table.get(slot)) else {
            continue;
        };
        let awake = |slot: &&u32| local[**slot as usize] != u32::MAX;
        if !manifold.points.is_empty()
            && let Some(island) = pair.slots.iter().find(awake).and_then(|s| islands.of(*s))
        {
            let island = island as u32;
            touches.push(Touch {
                island,
                place: place(island, [a, b], pair.slots.map(|slot| local[slot as usize])),
                pair,
                manifold,
                targets,
                impulses: impulses.into_inner(),
            });
        }
    }
    touches.sort_unstable_by_key(|touch| touch.place);
    touches
}

/// What a touch is sorted by: its island, then the body higher up, then the other, so that all supports of a brick are visited
/// together. Bodies stand in their problem in the order of their ranks; what is not in it stands still, comes before them, and goes
/// by age.
fn place(island: u32, bodies: [&BodyState; 2], local: [u32; 2]) -> u128 {
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
    /// λ_n, N·s. What the point carries at rest is a force, and acts as long as the step; what is more or less than that stopped or
    /// lost something, and would do so again and again in a step that is longer than the last.
    pub(super) fn normal_to_start_from(&self, time: &StepTime) -> f32 {
        let passing = self.warm_normal - self.load;
        (self.load * time.dt + passing * time.carried()).max(0.0)
    }
}
