//! Rounds: contacts of a heavy body with many light ones that are relaxed together, as on a plate that carries thousands of bodies.
//!
//! Contacts of one body are relaxed one after another, each with the velocity that the one before has left. For a plate that would be one
//! contact per block, with the other lanes empty. But a light body hardly changes the velocity of a body [so much heavier](MIN_MASS_RATIO),
//! and the next contact finds almost the same velocity without that change. So the contacts of a heavy body form rounds of [`ROUND_SIZE`].
//! All of a round read the velocity from before the round, each writes its result to a *seat* of its own, and after the last of them the
//! body takes all changes together. No impulse is lost. The size of rounds does not depend on the number of lanes, so the result does not
//! depend on it either.
//!
//! Together, the contacts of a round change the plate's velocity by at most ROUND_SIZE / MIN_MASS_RATIO of the change that its own mass
//! would cause, times a factor for levers (4 at the end of a beam, 7 at the corner of a slab). That is less than half, so sweeps converge
//! (Jacobi's method would diverge from twice on).
//!
//! A step takes half of the time with 100 crates on a plate, and two fifths with 5 000.
//!
//! A step in which bodies hit each other has no rounds: under a blow even a small share of it counts.

use super::Body;
use super::lanes::State;
use crate::Both;
use crate::sort;
use std::cell::Cell;

/// Number of contacts in a round, at most.
pub const ROUND_SIZE: usize = 8;

/// A body has rounds if at least this many light bodies touch it; for fewer it does not pay.
const MIN_LIGHT_BODIES: u32 = 64;

/// Ratio of masses from which on the other body is light.
const MIN_MASS_RATIO: f32 = 128.0;

/// The rounds of the contacts of heavy bodies.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Rounds {
    /// Bodies with rounds.
    bodies: Vec<u32>,
    /// By contact and side. Empty if no body has rounds.
    seats: Vec<[Option<Seat>; 2]>,
}

/// The place of a contact in a round.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Seat {
    /// Index of the body among those with rounds.
    pub body: u32,
    pub round: u32,
    /// Number of the seat in the round.
    pub number: u32,
}

impl Rounds {
    /// Finds the rounds of contacts between these pairs of bodies, in the order of the sweep.
    pub fn of(pairs: impl Iterator<Item = [u32; 2]> + Clone, bodies: &[Body]) -> Self {
        let ease = |body: u32| bodies[body as usize].inverse_mass;
        let is_light = |other: u32, body: u32| ease(other) >= MIN_MASS_RATIO * ease(body);
        let heavy = |[a, b]: [u32; 2]| match (ease(a) > 0.0, ease(b) > 0.0) {
            (true, true) if is_light(b, a) => Some(a),
            (true, true) if is_light(a, b) => Some(b),
            _ => None,
        };
        let mut counts: Vec<u32> = Vec::new();
        for body in pairs.clone().filter_map(heavy) {
            counts.resize(bodies.len(), 0);
            counts[body as usize] += 1;
        }
        let crowded = (0..)
            .zip(&counts)
            .filter(|&(_, &count)| count >= MIN_LIGHT_BODIES);
        let crowded: Vec<u32> = crowded.map(|(body, _)| body).collect();
        if crowded.is_empty() {
            return Self::default();
        }
        // By body: the next round and seat. A contact that is a round by itself fills its round.
        let mut next = vec![(0, 0); crowded.len()];
        let seats = pairs.map(|pair| {
            let light = heavy(pair);
            pair.both(|body| {
                let number = crowded.binary_search(&body).ok()?;
                let (round, seat) = &mut next[number];
                let alone = light != Some(body);
                if *seat == ROUND_SIZE as u32 || alone && *seat > 0 {
                    (*round, *seat) = (*round + 1, 0);
                }
                let found = Seat {
                    body: number as u32,
                    round: *round,
                    number: *seat,
                };
                *seat = if alone { ROUND_SIZE as u32 } else { *seat + 1 };
                Some(found)
            })
        });
        Self {
            seats: seats.collect(),
            bodies: crowded,
        }
    }

    pub fn is_empty(&self) -> bool {
        self.seats.is_empty()
    }

    /// Number of bodies with rounds.
    pub fn bodies(&self) -> usize {
        self.bodies.len()
    }

    /// The seats of a contact, on both sides.
    pub fn seats(&self, contact: u32) -> [Option<Seat>; 2] {
        let seats = self.seats.get(contact as usize);
        seats.copied().unwrap_or_default()
    }

    /// Number of seats of all bodies.
    pub fn count(&self) -> usize {
        ROUND_SIZE * self.bodies.len()
    }

    /// The blocks after which rounds end, for contacts in these blocks. Seats begin at index `first_seat` among the velocities.
    pub fn ends(
        &self,
        blocks: impl Iterator<Item = impl Iterator<Item = u32>>,
        first_seat: u32,
    ) -> RoundEnds {
        if self.is_empty() {
            return RoundEnds::default();
        }
        // By body: its current round, the last block with a contact of that round, and the number of these contacts.
        let mut current = vec![(0u32, 0u32, 0u32); self.bodies.len()];
        let mut ends = Vec::new();
        let end = |body: usize, (_, block, contacts): (u32, u32, u32)| {
            let taken = RoundEnd {
                body: self.bodies[body],
                first: first_seat + (body * ROUND_SIZE) as u32,
                count: contacts,
            };
            (block, taken)
        };
        let mut count = 0;
        for (number, block) in (0..).zip(blocks) {
            count = number + 1;
            for seat in block.flat_map(|contact| self.seats(contact)).flatten() {
                let body = seat.body as usize;
                if current[body].0 != seat.round {
                    ends.push(end(body, current[body]));
                    current[body] = (seat.round, number, 0);
                }
                current[body].1 = number;
                current[body].2 += 1;
            }
        }
        ends.extend((0..).zip(current).map(|(body, last)| end(body, last)));
        sort::by_key(&mut ends, |&(block, _)| block);
        let starts = (0..=count).map(|block| ends.partition_point(|end| end.0 < block) as u32);
        RoundEnds {
            starts: starts.collect(),
            taken: ends.into_iter().map(|(_, taken)| taken).collect(),
        }
    }
}

/// The earliest wave or block for the contacts of a body with rounds.
#[derive(Clone, Copy, Default)]
pub struct RoundPlace {
    round: u32,
    /// The earliest wave or block of the current round, and the first one after it.
    begins: u32,
    over: u32,
}

impl RoundPlace {
    /// The earliest wave or block for a contact of a round.
    pub fn earliest(&mut self, round: u32) -> u32 {
        if self.round != round {
            (self.round, self.begins) = (round, self.over);
        }
        self.begins
    }

    /// Places a contact of the round in wave or block `when`.
    pub fn place(&mut self, when: u32) {
        self.over = self.over.max(when + 1);
    }
}

/// The rounds that end after each block.
#[derive(Clone, Debug, Default)]
pub struct RoundEnds {
    /// By block: start of the rounds that end after it; then the end of the list. Empty if no body has rounds.
    starts: Vec<u32>,
    taken: Vec<RoundEnd>,
}

/// A body that takes the changes in its seats.
#[derive(Clone, Copy, Debug)]
struct RoundEnd {
    body: u32,
    /// Index of the first seat among the velocities.
    first: u32,
    count: u32,
}

impl RoundEnds {
    /// Ends rounds after the visit to a block: their bodies take all changes.
    #[inline(always)]
    pub fn after(&self, block: usize, velocities: &[Cell<State>]) {
        if self.starts.is_empty() {
            return;
        }
        let range = self.starts[block] as usize..self.starts[block + 1] as usize;
        for taken in &self.taken[range] {
            let body = &velocities[taken.body as usize];
            let [linear, angular] = body.get();
            let mut sum = [linear, angular];
            for seat in &velocities[taken.first as usize..][..taken.count as usize] {
                let [moved, turned] = seat.get();
                sum = [sum[0] + (moved - linear), sum[1] + (turned - angular)];
            }
            body.set(sum);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bodies(count: usize, plate: f32) -> Vec<Body> {
        let mut bodies = vec![Body::default(); count + 2];
        bodies[1].inverse_mass = 1.0 / plate;
        for body in &mut bodies[2..] {
            body.inverse_mass = 1.0;
        }
        bodies
    }

    /// The pairs of a ground (0), a plate (1) on it, and light bodies on the plate.
    fn pairs(count: u32) -> impl Iterator<Item = [u32; 2]> + Clone {
        std::iter::once([0, 1]).chain((2..count + 2).map(|body| [1, body]))
    }

    #[test]
    fn light_bodies_on_a_heavy_one_come_in_rounds_and_the_ground_alone() {
        let rounds = Rounds::of(pairs(100), &bodies(100, 1000.0));
        assert_eq!(
            rounds.seats(0)[1].map(|seat| (seat.round, seat.number)),
            Some((0, 0))
        );
        for contact in 1..=100 {
            let seat = rounds.seats(contact)[0].unwrap();
            assert_eq!(seat.round, 1 + (contact - 1) / ROUND_SIZE as u32);
            assert_eq!(seat.number, (contact - 1) % ROUND_SIZE as u32);
            assert!(rounds.seats(contact)[1].is_none());
        }
        assert!(Rounds::of(pairs(100), &bodies(100, 100.0)).is_empty());
        assert!(Rounds::of(pairs(50), &bodies(50, 1000.0)).is_empty());
    }

    #[test]
    fn a_body_takes_what_all_of_a_round_have_changed() {
        let rounds = Rounds::of(pairs(64), &bodies(64, 1000.0));
        // Four lanes, so that a round has two blocks.
        let blocks: Vec<Vec<u32>> = std::iter::once(vec![0])
            .chain((0..16).map(|i| (1 + 4 * i..5 + 4 * i).collect()))
            .collect();
        let first = 100;
        let ends = rounds.ends(blocks.iter().map(|block| block.iter().copied()), first);
        let velocities = vec![Cell::new(State::default()); first as usize + rounds.count()];
        let at = |i: usize| velocities[i].get()[0].x;
        let set = |i: usize, x: f32| {
            let mut state = velocities[i].get();
            state[0].x = x;
            velocities[i].set(state);
        };
        for (block, contacts) in blocks.iter().enumerate() {
            let before = at(1);
            for &contact in contacts {
                let seat = rounds.seats(contact).into_iter().flatten().next().unwrap();
                set(first as usize + seat.number as usize, before + 1.0);
            }
            ends.after(block, &velocities);
            let taken = if block == 0 { 1.0 } else { 8.0 };
            let is_last = block == 0 || block % 2 == 0;
            assert_eq!(at(1) - before, if is_last { taken } else { 0.0 }, "{block}");
        }
    }
}
