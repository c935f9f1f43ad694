//! Which patches may be relaxed side by side without changing what a sweep one by one would give.
//!
//! A patch goes into the first block that has a free lane and stands after every block in which its two bodies are already.
//! So patches that share a body keep their order, patches in one block share none, and the sweep is the sequential one to the
//! bit: the order from the ground up, which decides how fast loads travel, costs nothing. A wall fills its blocks along a
//! slanted front. (A colouring of the contact graph would fill them better and converge worse.)

use crate::solver::PatchProblem;

/// For each patch its block and lane; and how many blocks there are.
#[derive(Default)]
pub struct Batches {
    pub places: Vec<(u32, u8)>,
    pub blocks: usize,
}

impl Batches {
    /// Of the patches of a problem, into blocks of so many lanes.
    pub fn of(lanes: usize, problem: &PatchProblem) -> Self {
        let bodies = &*problem.bodies;
        let patches = problem.patches.iter().map(|patch| patch.bodies);
        let moves = |body: u32| bodies[body as usize].inverse_mass > 0.0;
        Self::new(lanes, patches, bodies.len(), moves)
    }

    /// Into blocks of so many lanes. Bodies of each patch in the order of the sweep; `moves` tells which bodies contacts can change, the only ones that must
    /// not be shared.
    fn new(
        lanes: usize,
        patches: impl Iterator<Item = [u32; 2]>,
        bodies: usize,
        moves: impl Fn(u32) -> bool,
    ) -> Self {
        let mut places = Vec::with_capacity(patches.size_hint().0);
        // The first block that may hold a body next; how full each block is; and from each block the way to one with room.
        let mut after = vec![0u32; bodies];
        let mut filled: Vec<u8> = Vec::new();
        let mut next: Vec<u32> = Vec::new();
        for pair in patches {
            let free = pair
                .iter()
                .map(|&body| after[body as usize])
                .max()
                .unwrap_or(0);
            let block = with_room(&mut next, free);
            if block as usize == filled.len() {
                filled.push(0);
                next.push(block);
            }
            let fill = &mut filled[block as usize];
            places.push((block, *fill));
            *fill += 1;
            if *fill as usize == lanes {
                next[block as usize] = block + 1;
            }
            for body in pair {
                if moves(body) {
                    after[body as usize] = block + 1;
                }
            }
        }
        Self {
            places,
            blocks: filled.len(),
        }
    }
}

/// The first block from `block` on that is not full.
fn with_room(next: &mut [u32], mut block: u32) -> u32 {
    while let Some(&onward) = next.get(block as usize)
        && onward != block
    {
        if let Some(&further) = next.get(onward as usize) {
            next[block as usize] = further;
        }
        block = onward;
    }
    block
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patches_that_share_a_body_keep_their_order_and_never_share_a_block() {
        let mut rng = fastrand::Rng::with_seed(1);
        let pairs: Vec<[u32; 2]> = (0..2000)
            .map(|_| {
                let a = rng.u32(1..200);
                [a, (a + rng.u32(1..9)).min(200)]
            })
            .filter(|[a, b]| a != b)
            .collect();
        for lanes in [4, 8] {
            let batches = Batches::new(lanes, pairs.iter().copied(), 201, |_| true);
            let mut fill = vec![0; batches.blocks];
            for (i, one) in pairs.iter().enumerate() {
                let (block, lane) = batches.places[i];
                assert_eq!(lane, fill[block as usize]);
                fill[block as usize] += 1;
                for (j, other) in pairs[..i].iter().enumerate() {
                    if one.iter().any(|body| other.contains(body)) {
                        assert!(batches.places[j].0 < block, "{other:?} before {one:?}");
                    }
                }
            }
            assert!(fill.iter().all(|&n| n as usize <= lanes));
        }
    }

    #[test]
    fn what_nothing_moves_may_be_shared() {
        for lanes in [4, 8] {
            let on_ground = (1..=16).map(|body| [0, body]);
            let batches = Batches::new(lanes, on_ground, 17, |body| body != 0);
            assert_eq!(batches.blocks, 16 / lanes);
        }
    }
}
