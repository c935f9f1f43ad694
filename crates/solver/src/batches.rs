//! Batches: blocks of contacts that are relaxed side by side, with the result of a sweep one by one. Contacts are patches, or pairs of
//! bodies with all of their points.
//!
//! A contact goes into the first block that has a free lane and stands after every block that already holds one of its two bodies. So
//! contacts that share a body keep their order, contacts in one block share none, and the sweep is the sequential one to the bit: the order
//! from the ground up, which decides how fast loads travel, costs nothing. (A colouring of the contact graph would fill the blocks better
//! and converge worse.)
//!
//! Contacts come in *waves*: the wave of a contact is the first one after those of all earlier contacts of its bodies. Through a wall a
//! wave is a slanted front, and everything behind it is done. In the order of waves, blocks that share a body stand near each other; in the
//! plain order, the first courses would fill blocks along the whole wall before the next courses find room. The distance decides how
//! closely sweeps can follow each other ([`super::patches`]'s pipeline).
//!
//! Several contacts of one heavy body may stand in one block, if many light bodies touch it ([`rounds`](super::rounds)).
//!
//! Contacts in a row, as in a stack, fill one lane in a block, since each round_places for the one before. There the sequence of blocks is
//! *skewed*: cut into segments of the same length, which lie side by side, each one sweep behind the segment before it
//! ([`super::patches`]'s segments).

use super::Body;
use super::rounds::{RoundEnds, RoundPlace, Rounds};

/// The contacts of each block.
pub struct Batches {
    lanes: usize,
    segments: usize,
    /// Number of lanes of a segment.
    share: usize,
    /// By block and lane: the contact there, or [`NO_CONTACT`].
    slots: Vec<u32>,
    contacts: usize,
    rounds: Rounds,
}

/// The slot of a lane without a contact.
const NO_CONTACT: u32 = u32::MAX;

/// A sequence of blocks is skewed if its sweeps then take less than this share of the time.
const SKEWED_TIME_SHARE: f32 = 0.85;

/// Relative time of a visit to a block whose lanes are full and in different sweeps, compared with a block with one to half as many lanes
/// in one sweep: in a wall of 10 × 10 140 ns instead of 111.
const MIXED_LANES_COST: f32 = 1.3;

/// Typical number of sweeps in a step.
const TYPICAL_SWEEPS: usize = 16;

impl Batches {
    /// Sorts contacts between these pairs of bodies, in the order of the sweep, into blocks of `lanes` lanes.
    pub fn of(lanes: usize, pairs: impl Iterator<Item = [u32; 2]>, bodies: &[Body]) -> Self {
        let pairs: Vec<[u32; 2]> = pairs.collect();
        Self::with(lanes, &pairs, bodies, Rounds::default())
    }

    /// Like [`of`](Self::of), with rounds where there are any.
    pub fn in_rounds(lanes: usize, pairs: impl Iterator<Item = [u32; 2]>, bodies: &[Body]) -> Self {
        let pairs: Vec<[u32; 2]> = pairs.collect();
        let rounds = Rounds::of(pairs.iter().copied(), bodies);
        Self::with(lanes, &pairs, bodies, rounds)
    }

    fn with(lanes: usize, pairs: &[[u32; 2]], bodies: &[Body], rounds: Rounds) -> Self {
        let moves = |body: u32| bodies[body as usize].inverse_mass > 0.0;
        let waves = Waves::of(pairs, bodies.len(), moves, &rounds);
        Self::new(lanes, pairs, &waves, bodies.len(), moves, rounds)
    }

    /// Like [`in_rounds`](Self::in_rounds), but skewed where that is faster. Blocks with rounds are not skewed: the body with so many
    /// contacts is in all of them.
    pub fn skewed(lanes: usize, pairs: impl Iterator<Item = [u32; 2]>, bodies: &[Body]) -> Self {
        let moves = |body: u32| bodies[body as usize].inverse_mass > 0.0;
        let pairs: Vec<[u32; 2]> = pairs.collect();
        let rounds = Rounds::of(pairs.iter().copied(), bodies);
        let waves = Waves::of(&pairs, bodies.len(), moves, &rounds);
        let whole = Self::new(lanes, &pairs, &waves, bodies.len(), moves, rounds);
        if whole.has_rounds() {
            return whole;
        }
        let fewest = pairs.len().div_ceil(lanes);
        let time = |blocks: usize, segments: usize| {
            (blocks * (TYPICAL_SWEEPS + segments - 1)) as f32 * MIXED_LANES_COST
        };
        let mut least = SKEWED_TIME_SHARE * (whole.blocks() * TYPICAL_SWEEPS) as f32;
        if time(fewest.max(2), 2) > least {
            return whole;
        }
        let mut best = whole;
        let mut width = lanes / 2;
        while width > 0 {
            let none = Rounds::default();
            let narrow = Self::new(width, &pairs, &waves, bodies.len(), moves, none);
            let blocks = narrow.segment(lanes, &pairs, bodies.len(), moves);
            let segments = narrow.blocks().div_ceil(blocks);
            let time = time(blocks, segments);
            if time < least {
                least = time;
                best = narrow.skew(lanes, blocks);
            }
            width /= 2;
        }
        best
    }

    /// `moves` says whether contacts can change a body; only those bodies must not be shared.
    fn new(
        lanes: usize,
        pairs: &[[u32; 2]],
        waves: &Waves,
        bodies: usize,
        moves: impl Fn(u32) -> bool,
        rounds: Rounds,
    ) -> Self {
        let mut slots: Vec<u32> = Vec::with_capacity(2 * pairs.len());
        let mut filled: Vec<u8> = Vec::with_capacity(2 * pairs.len() / lanes);
        let mut places = Earliest::new(bodies, &rounds);
        // By block: a block at or after it that may have room; see `with_room`.
        let mut next: Vec<u32> = Vec::new();
        let mut floor = 0;
        for wave in waves.iter() {
            let begun = filled.len() as u32;
            for &contact in wave {
                let pair = pairs[contact as usize];
                let free = places.earliest(contact, pair);
                let block = with_room(&mut next, free.max(floor));
                if block as usize == filled.len() {
                    filled.push(0);
                    slots.resize(slots.len() + lanes, NO_CONTACT);
                    next.push(block);
                }
                let fill = &mut filled[block as usize];
                slots[block as usize * lanes + *fill as usize] = contact;
                *fill += 1;
                if *fill as usize == lanes {
                    next[block as usize] = block + 1;
                }
                places.place(contact, pair, block, &moves);
            }
            floor = begun;
        }
        Self {
            lanes,
            segments: 1,
            share: lanes,
            slots,
            contacts: pairs.len(),
            rounds,
        }
    }

    /// The fewest blocks of a segment if segments lie side by side in `lanes` lanes. No block may hold a body twice, and each sweep must
    /// have finished with a body before the next sweep reaches the body's first contact.
    fn segment(
        &self,
        lanes: usize,
        pairs: &[[u32; 2]],
        bodies: usize,
        moves: impl Fn(u32) -> bool,
    ) -> usize {
        let mut first = vec![u32::MAX; bodies];
        let mut farthest = 0;
        for (number, block) in (0..).zip(self.iter()) {
            let bodies = block.flat_map(|(_, contact)| pairs[contact as usize]);
            for body in bodies.filter(|&body| moves(body)) {
                let first = &mut first[body as usize];
                *first = number.min(*first);
                farthest = farthest.max(number - *first);
            }
        }
        let segments = lanes / self.lanes;
        self.blocks().div_ceil(segments).max(farthest as usize + 1)
    }

    /// Cuts the sequence into segments of `blocks` blocks, side by side in `lanes` lanes.
    fn skew(&self, lanes: usize, blocks: usize) -> Self {
        let mut slots = vec![NO_CONTACT; blocks * lanes];
        for (number, narrow) in self.slots.chunks_exact(self.lanes).enumerate() {
            let (segment, block) = (number / blocks, number % blocks);
            slots[block * lanes + segment * self.lanes..][..self.lanes].copy_from_slice(narrow);
        }
        Self {
            lanes,
            segments: self.blocks().div_ceil(blocks),
            share: self.lanes,
            slots,
            contacts: self.contacts,
            rounds: Rounds::default(),
        }
    }

    /// Whether some contacts share a body with others of their block.
    pub fn has_rounds(&self) -> bool {
        !self.rounds.is_empty()
    }

    /// The rounds of heavy bodies.
    pub fn rounds(&self) -> &Rounds {
        &self.rounds
    }

    /// The blocks after which rounds end. `first_seat` is the index of the first seat among the velocities.
    pub fn round_ends(&self, first_seat: u32) -> RoundEnds {
        let contacts = |block| Batches::block(self, block).map(|(_, contact)| contact);
        self.rounds
            .ends((0..self.blocks()).map(contacts), first_seat)
    }

    /// Number of blocks.
    pub fn blocks(&self) -> usize {
        self.slots.len() / self.lanes
    }

    /// Number of segments side by side, at least 1.
    pub fn segments(&self) -> usize {
        self.segments
    }

    /// The segment to which a lane belongs.
    pub fn segment_of(&self, lane: usize) -> usize {
        lane / self.share
    }

    /// Number of lanes in all segments.
    pub fn lanes_used(&self) -> usize {
        self.segments * self.share
    }

    /// Whether the mean block holds at least `contacts` contacts.
    #[cfg(target_arch = "x86_64")]
    pub fn holds(&self, contacts: usize) -> bool {
        self.contacts >= contacts * self.blocks()
    }

    /// The contacts of one block, each with its lane.
    #[inline]
    pub fn block(&self, block: usize) -> Contacts<'_> {
        Contacts::of(&self.slots[block * self.lanes..][..self.lanes])
    }

    /// The contacts of each block, each with its lane.
    pub fn iter(&self) -> impl Iterator<Item = Contacts<'_>> + Clone {
        self.slots.chunks_exact(self.lanes).map(Contacts::of)
    }
}

/// Iterator over the contacts of a block, each with its lane. (A filter is not inlined into loops over lanes, and costs a twentieth of a
/// step.)
#[derive(Clone)]
pub struct Contacts<'a> {
    slots: &'a [u32],
    lane: usize,
}

impl<'a> Contacts<'a> {
    #[inline(always)]
    fn of(slots: &'a [u32]) -> Self {
        Self { slots, lane: 0 }
    }
}

impl Iterator for Contacts<'_> {
    type Item = (usize, u32);

    #[inline(always)]
    fn next(&mut self) -> Option<Self::Item> {
        while let Some(&contact) = self.slots.get(self.lane) {
            let lane = self.lane;
            self.lane += 1;
            if contact != NO_CONTACT {
                return Some((lane, contact));
            }
        }
        None
    }
}

/// The earliest wave, or block, for the next contact of each body.
struct Earliest<'a> {
    rounds: &'a Rounds,
    /// By body without rounds: the earliest wave or block.
    after: Vec<u32>,
    /// By body with rounds.
    round_places: Vec<RoundPlace>,
}

impl<'a> Earliest<'a> {
    fn new(bodies: usize, rounds: &'a Rounds) -> Self {
        Self {
            rounds,
            after: vec![0; bodies],
            round_places: vec![RoundPlace::default(); rounds.bodies()],
        }
    }

    /// The earliest wave or block for a contact.
    fn earliest(&mut self, contact: u32, pair: [u32; 2]) -> u32 {
        let seats = self.rounds.seats(contact);
        let earliest: [u32; 2] = std::array::from_fn(|side| match seats[side] {
            Some(seat) => self.round_places[seat.body as usize].earliest(seat.round),
            None => self.after[pair[side] as usize],
        });
        earliest[0].max(earliest[1])
    }

    /// Places a contact in wave or block `when`. `moves` says which bodies must not be shared.
    fn place(&mut self, contact: u32, pair: [u32; 2], when: u32, moves: impl Fn(u32) -> bool) {
        for (body, seat) in pair.into_iter().zip(self.rounds.seats(contact)) {
            match seat {
                Some(seat) => self.round_places[seat.body as usize].place(when),
                None if moves(body) => self.after[body as usize] = when + 1,
                None => {}
            }
        }
    }
}

/// Contacts sorted by wave, in their order within a wave.
struct Waves {
    contacts: Vec<u32>,
    /// By wave: the end of its contacts.
    ends: Vec<u32>,
}

impl Waves {
    fn of(pairs: &[[u32; 2]], bodies: usize, moves: impl Fn(u32) -> bool, rounds: &Rounds) -> Self {
        let mut places = Earliest::new(bodies, rounds);
        let mut waves: Vec<u32> = Vec::with_capacity(pairs.len());
        for (contact, &pair) in (0..).zip(pairs) {
            let wave = places.earliest(contact, pair);
            waves.push(wave);
            places.place(contact, pair, wave, &moves);
        }
        let mut sizes = vec![0u32; waves.iter().max().map_or(0, |&wave| wave as usize + 1)];
        // A contact that no earlier contact delays, such as one on the ground, moves to the wave right before the next contact of its
        // bodies.
        let mut before = places.after;
        before.fill(u32::MAX);
        for (contact, (pair, wave)) in pairs.iter().zip(&mut waves).enumerate().rev() {
            let moving = || pair.iter().filter(|&&body| moves(body));
            // A contact of a round stays in its wave.
            let seated = rounds.seats(contact as u32) != [None; 2];
            let latest = moving().map(|&body| before[body as usize]);
            let (least, most) = latest.fold((u32::MAX, 0), |(least, most), wave| {
                (least.min(wave), most.max(wave))
            });
            if most < u32::MAX && least < u32::MAX && !seated {
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

/// The first block from `block` on that has room.
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

    fn of(
        lanes: usize,
        pairs: &[[u32; 2]],
        bodies: usize,
        moves: impl Fn(u32) -> bool + Copy,
    ) -> Batches {
        let rounds = Rounds::default();
        let waves = Waves::of(pairs, bodies, moves, &rounds);
        Batches::new(lanes, pairs, &waves, bodies, moves, rounds)
    }

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
            let batches = of(lanes, &pairs, 201, |_| true);
            let mut block_of = vec![usize::MAX; pairs.len()];
            for (block, contacts) in batches.iter().enumerate() {
                assert!((1..=lanes).contains(&contacts.clone().count()));
                for (_, contact) in contacts {
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
    fn skewed_contacts_that_share_a_body_keep_their_order_from_sweep_to_sweep() {
        let mut rng = fastrand::Rng::with_seed(2);
        for length in [12, 40, 100] {
            // A chain with some cross links, on a fixed ground.
            let links = (1..length).flat_map(|a| {
                let across = rng.u8(..4) == 0;
                [Some([a, a + 1]), across.then_some([a, a + 2])]
            });
            let links: Vec<_> = links.flatten().collect();
            let grounded = (1..length).step_by(7).map(|a| [0, a]);
            let pairs: Vec<[u32; 2]> = grounded.chain(links).collect();
            let mut bodies = vec![Body::default(); length as usize + 2];
            for body in &mut bodies[1..] {
                body.inverse_mass = 1.0;
            }
            for lanes in [4, 8] {
                let skewed = Batches::skewed(lanes, pairs.iter().copied(), &bodies);
                let blocks = skewed.blocks();
                let whole = of(lanes, &pairs, bodies.len(), |body| body > 0);
                assert!(
                    skewed.segments() > 1 && blocks < whole.blocks(),
                    "{length} in {lanes}"
                );
                // By contact: its visit, counted since the sweep began.
                let mut visit_of = vec![usize::MAX; pairs.len()];
                for (block, contacts) in skewed.iter().enumerate() {
                    for (lane, contact) in contacts {
                        assert!(skewed.segment_of(lane) < skewed.segments());
                        visit_of[contact as usize] = skewed.segment_of(lane) * blocks + block;
                    }
                }
                for (i, one) in pairs.iter().enumerate() {
                    for (j, other) in pairs[..i].iter().enumerate() {
                        if one.iter().any(|body| *body > 0 && other.contains(body)) {
                            let (later, earlier) = (visit_of[i], visit_of[j]);
                            // The next sweep must visit the earlier contact only after this sweep has visited the later one.
                            assert!((earlier + 1..earlier + blocks).contains(&later));
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn fixed_bodies_may_be_shared() {
        for lanes in [4, 8] {
            let on_ground: Vec<_> = (1..=16).map(|body| [0, body]).collect();
            let batches = of(lanes, &on_ground, 17, |body| body != 0);
            assert_eq!(batches.blocks(), 16 / lanes);
        }
    }
}
