//! Which contacts may be relaxed side by side without changing what a sweep one by one would give: patches, or pairs of bodies with all
//! of their points.
//!
//! A contact goes into the first block that has a free lane and stands after every block in which its two bodies are already.
//! So contacts that share a body keep their order, contacts in one block share none, and the sweep is the sequential one to the
//! bit: the order from the ground up, which decides how fast loads travel, costs nothing. A wall fills its blocks along a
//! slanted front. (A colouring of the contact graph would fill them better and converge worse.)

use super::Body;

/// The contacts of each block.
pub struct Batches {
    lanes: usize,
    /// By block and lane; those of a block are filled from the first on.
    slots: Vec<u32>,
    filled: Vec<u8>,
}

impl Batches {
    /// Of contacts between such pairs, in the order of the sweep, into blocks of so many lanes.
    pub fn of(lanes: usize, pairs: impl Iterator<Item = [u32; 2]>, bodies: &[Body]) -> Self {
        let moves = |body: u32| bodies[body as usize].inverse_mass > 0.0;
        Self::new(lanes, pairs, bodies.len(), moves)
    }

    /// The same; `moves` tells which bodies contacts can change, the only ones that must not be shared.
    fn new(
        lanes: usize,
        pairs: impl Iterator<Item = [u32; 2]>,
        bodies: usize,
        moves: impl Fn(u32) -> bool,
    ) -> Self {
        let mut batches = Self {
            lanes,
            slots: Vec::with_capacity(2 * pairs.size_hint().0),
            filled: Vec::new(),
        };
        // The first block that may hold a body next; and from each block the way to one with room.
        let mut after = vec![0u32; bodies];
        let mut next: Vec<u32> = Vec::new();
        for (contact, pair) in pairs.enumerate() {
            let free = pair
                .iter()
                .map(|&body| after[body as usize])
                .max()
                .unwrap_or(0);
            let block = with_room(&mut next, free);
            if block as usize == batches.filled.len() {
                batches.filled.push(0);
                batches.slots.resize(batches.slots.len() + lanes, 0);
                next.push(block);
            }
            if batches.fill(block as usize, contact as u32) {
                next[block as usize] = block + 1;
            }
            for body in pair {
                if moves(body) {
                    after[body as usize] = block + 1;
                }
            }
        }
        batches
    }

    /// Whether the block is full with it.
    fn fill(&mut self, block: usize, contact: u32) -> bool {
        let fill = &mut self.filled[block];
        self.slots[block * self.lanes + *fill as usize] = contact;
        *fill += 1;
        *fill as usize == self.lanes
    }

    /// How many blocks there are.
    pub fn blocks(&self) -> usize {
        self.filled.len()
    }

    /// Whether the mean block holds so many contacts.
    #[cfg(target_arch = "x86_64")]
    pub fn holds(&self, contacts: usize) -> bool {
        let all: usize = self.filled.iter().map(|&filled| filled as usize).sum();
        all >= contacts * self.blocks()
    }

    /// The contacts of each block, lane by lane.
    pub fn iter(&self) -> impl Iterator<Item = &[u32]> + Clone {
        let slots = self.slots.chunks_exact(self.lanes);
        let filled = slots.zip(&self.filled);
        filled.map(|(slots, &filled)| &slots[..filled as usize])
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
    fn contacts_that_share_a_body_keep_their_order_and_never_share_a_block() {
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
            let mut block_of = vec![usize::MAX; pairs.len()];
            for (block, contacts) in batches.iter().enumerate() {
                assert!((1..=lanes).contains(&contacts.len()));
                for &contact in contacts {
                    block_of[contact as usize] = block;
                }
            }
            for (i, one) in pairs.iter().enumerate() {
                assert!(block_of[i] < batches.blocks(), "{one:?} is in no block");
                for (j, other) in pairs[..i].iter().enumerate() {
                    if one.iter().any(|body| other.contains(body)) {
                        assert!(block_of[j] < block_of[i], "{other:?} before {one:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn what_nothing_moves_may_be_shared() {
        for lanes in [4, 8] {
            let on_ground = (1..=16).map(|body| [0, body]);
            let batches = Batches::new(lanes, on_ground, 17, |body| body != 0);
            assert_eq!(batches.blocks(), 16 / lanes);
        }
    }
}
