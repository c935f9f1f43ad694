//! Which contacts may be relaxed side by side without changing what a sweep one by one would give: patches, or pairs of bodies with all
//! of their points.
//!
//! A contact goes into the first block that has a free lane and stands after every block in which its two bodies are already.
//! So contacts that share a body keep their order, contacts in one block share none, and the sweep is the sequential one to the
//! bit: the order from the ground up, which decides how fast loads travel, costs nothing. (A colouring of the contact graph would fill
//! them better and converge worse.)
//!
//! They come in *waves*: a contact is of the first wave after those of its bodies' contacts before it. Through a wall a wave is a slanted
//! front, and behind it all is done: taken wave by wave, blocks that share a body stand near each other, where taken in their order the
//! first courses would fill blocks along the whole wall before the next have room. How near decides how closely sweeps can follow each
//! other ([`super::patches`]'s pipeline).

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
        let pairs: Vec<[u32; 2]> = pairs.collect();
        let mut batches = Self {
            lanes,
            slots: Vec::with_capacity(2 * pairs.len()),
            filled: Vec::new(),
        };
        // The first block that may hold a body next; and from each block the way to one with room.
        let mut after = vec![0u32; bodies];
        let mut next: Vec<u32> = Vec::new();
        let mut floor = 0;
        for wave in Waves::of(&pairs, bodies, &moves).iter() {
            let begun = batches.blocks() as u32;
            for &contact in wave {
                let pair = pairs[contact as usize];
                let free = pair.map(|body| after[body as usize]);
                let block = with_room(&mut next, free[0].max(free[1]).max(floor));
                if block as usize == batches.filled.len() {
                    batches.filled.push(0);
                    batches.slots.resize(batches.slots.len() + lanes, 0);
                    next.push(block);
                }
                if batches.fill(block as usize, contact) {
                    next[block as usize] = block + 1;
                }
                for body in pair {
                    if moves(body) {
                        after[body as usize] = block + 1;
                    }
                }
            }
            floor = begun;
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

    /// The contacts of one block, lane by lane.
    pub fn block(&self, block: usize) -> &[u32] {
        &self.slots[block * self.lanes..][..self.filled[block] as usize]
    }

    /// The contacts of each block, lane by lane.
    pub fn iter(&self) -> impl Iterator<Item = &[u32]> + Clone {
        let slots = self.slots.chunks_exact(self.lanes);
        let filled = slots.zip(&self.filled);
        filled.map(|(slots, &filled)| &slots[..filled as usize])
    }
}

/// Contacts by wave, and those of a wave in their order.
struct Waves {
    contacts: Vec<u32>,
    /// Where each wave ends.
    ends: Vec<u32>,
}

impl Waves {
    fn of(pairs: &[[u32; 2]], bodies: usize, moves: impl Fn(u32) -> bool) -> Self {
        let mut after = vec![0u32; bodies];
        let mut waves: Vec<u32> = Vec::with_capacity(pairs.len());
        for pair in pairs {
            let wave = pair.map(|body| after[body as usize]);
            let wave = wave[0].max(wave[1]);
            waves.push(wave);
            for &body in pair.iter().filter(|&&body| moves(body)) {
                after[body as usize] = wave + 1;
            }
        }
        let mut sizes = vec![0u32; waves.iter().max().map_or(0, |&wave| wave as usize + 1)];
        // What could be first and waits for nobody, as what stands on the ground, comes right before the next contact of its bodies.
        let mut before = after;
        before.fill(u32::MAX);
        for (pair, wave) in pairs.iter().zip(&mut waves).rev() {
            let moving = || pair.iter().filter(|&&body| moves(body));
            let latest = moving().map(|&body| before[body as usize]);
            let (least, most) = latest.fold((u32::MAX, 0), |(least, most), wave| {
                (least.min(wave), most.max(wave))
            });
            if most < u32::MAX && least < u32::MAX {
                *wave = least - 1;
            }
            sizes[*wave as usize] += 1;
            moving().for_each(|&body| before[body as usize] = *wave);
        }
        let mut next = 0;
        for size in &mut sizes {
            next += std::mem::replace(size, next);
        }
        let mut contacts = vec![0; pairs.len()];
        for (contact, wave) in (0..).zip(waves) {
            let place = &mut sizes[wave as usize];
            contacts[*place as usize] = contact;
            *place += 1;
        }
        Self {
            contacts,
            ends: sizes,
        }
    }

    fn iter(&self) -> impl Iterator<Item = &[u32]> {
        let starts = std::iter::once(&0).chain(&self.ends);
        let ranges = starts.zip(&self.ends);
        ranges.map(|(&start, &end)| &self.contacts[start as usize..end as usize])
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
