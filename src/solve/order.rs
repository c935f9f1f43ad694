//! What is solved with what, and in which order: found when islands change, and kept while they don't.

use super::Pairs;
use super::touch::{Touch, place};
use crate::body::BodyTable;
use crate::islands::Islands;
use bevy_ecs::prelude::*;

/// See the module's text.
#[derive(Default)]
pub(super) struct Order {
    /// [`Islands::version`] for which it holds.
    version: u64,
    /// Dynamic bodies that are awake, by island and rank.
    pub bodies: Vec<Member>,
    /// By slot: where the body stands in its island's problem; `u32::MAX` where it is in none.
    pub local: Vec<u32>,
    /// Of the touches as the query has them, those that are solved: their island, and which they are; in the order of the solve.
    touches: Vec<(u32, u32)>,
}

/// A body of an island.
#[derive(Clone, Copy)]
pub(super) struct Member {
    pub island: u32,
    pub slot: u32,
}

impl Order {
    /// Finds it anew where it does not hold any more; true where it does.
    pub fn keep(&mut self, table: &BodyTable, islands: &Islands, pairs: &Pairs) -> bool {
        if self.version == islands.version() {
            return true;
        }
        self.version = islands.version();
        self.order_bodies(table, islands);
        self.order_touches(table, islands, pairs);
        false
    }

    fn order_bodies(&mut self, table: &BodyTable, islands: &Islands) {
        let awake = table
            .iter()
            .filter(|(_, body)| body.is_dynamic() && !body.asleep);
        let mut awake: Vec<_> = awake
            .filter_map(|(slot, body)| Some((islands.of(slot)?, islands.rank(slot, body), slot)))
            .collect();
        awake.sort_unstable_by_key(|&(island, rank, _)| (island, rank));
        self.local.clear();
        self.local.resize(table.slots(), u32::MAX);
        self.bodies.clear();
        let mut last = None;
        let mut local = 0;
        for (island, _, slot) in awake {
            local = if last == Some(island) { local + 1 } else { 0 };
            last = Some(island);
            self.local[slot as usize] = local;
            self.bodies.push(Member {
                island: island as u32,
                slot,
            });
        }
    }

    fn order_touches(&mut self, table: &BodyTable, islands: &Islands, pairs: &Pairs) {
        let local = &self.local;
        let awake = |slot: &&u32| local[**slot as usize] != u32::MAX;
        let touching = pairs.iter().zip(0..);
        let touching = touching.filter(|((_, manifold, ..), _)| !manifold.points.is_empty());
        let mut touches: Vec<(u128, u32, u32)> = touching
            .filter_map(|((pair, ..), number)| {
                let [a, b] = pair.slots;
                let bodies = [table.get(a)?, table.get(b)?];
                let island = islands.of(*pair.slots.iter().find(awake)?)? as u32;
                let ends = pair.slots.map(|slot| local[slot as usize]);
                Some((place(island, bodies, ends), island, number))
            })
            .collect();
        touches.sort_unstable_by_key(|&(place, ..)| place);
        self.touches.clear();
        let solved = touches.into_iter();
        self.touches
            .extend(solved.map(|(_, island, number)| (island, number)));
    }

    /// The touches, in order.
    pub fn touches<'a>(&self, pairs: &'a mut Pairs) -> Vec<Touch<'a>> {
        let mut all: Vec<Option<Touch>> = pairs
            .iter_mut()
            .map(|(pair, manifold, targets, impulses)| {
                // By a user, that is: our own stages say so in `fresh`.
                let edited = pair.is_changed() || manifold.is_changed() || impulses.is_changed();
                Some(Touch {
                    island: 0,
                    changed: pair.fresh || edited,
                    pair: pair.into_inner(),
                    manifold: manifold.into_inner(),
                    targets,
                    impulses: impulses.into_inner(),
                })
            })
            .collect();
        let take = |&(island, number): &(u32, u32)| {
            let touch = all[number as usize].take();
            let touch = touch.expect("each is solved once");
            Touch { island, ..touch }
        };
        self.touches.iter().map(take).collect()
    }
}
