//! The pairs alive: by the slots of their bodies, and those of each body, so that what is done to one body costs as much as it has
//! neighbours, whoever else there is.

use bevy_ecs::entity::{EntityMapper, MapEntities};
use bevy_ecs::prelude::*;
use bevy_platform::collections::HashMap;

/// See the module's text.
#[derive(Clone, Default)]
pub(crate) struct Pairs {
    known: HashMap<[u32; 2], u32>,
    pairs: Vec<Pair>,
    free: Vec<u32>,
    /// By slot.
    of: Vec<Vec<u32>>,
}

#[derive(Clone)]
struct Pair {
    slots: [u32; 2],
    entity: Entity,
    /// Where it stands in the list of either body.
    places: [u32; 2],
}

impl MapEntities for Pairs {
    fn map_entities<M: EntityMapper>(&mut self, mapper: &mut M) {
        for &number in self.known.values() {
            self.pairs[number as usize].entity.map_entities(mapper);
        }
    }
}

impl Pairs {
    /// How many there are.
    pub fn count(&self) -> usize {
        self.known.len()
    }

    /// The entities of a body's pairs.
    pub fn of(&self, slot: u32) -> impl ExactSizeIterator<Item = Entity> {
        let pairs = self.of.get(slot as usize).map_or(&[][..], |pairs| pairs);
        pairs.iter().map(|&pair| self.pairs[pair as usize].entity)
    }

    /// False where it is known. Its entity is told later.
    pub fn insert(&mut self, slots: [u32; 2]) -> bool {
        if self.known.contains_key(&slots) {
            return false;
        }
        let number = self.free.pop().unwrap_or(self.pairs.len() as u32);
        self.known.insert(slots, number);
        let last = slots.into_iter().max().unwrap_or(0) as usize;
        if self.of.len() <= last {
            self.of.resize_with(last + 1, Vec::new);
        }
        let places = slots.map(|slot| {
            let list = &mut self.of[slot as usize];
            list.push(number);
            list.len() as u32 - 1
        });
        let pair = Pair {
            slots,
            entity: Entity::PLACEHOLDER,
            places,
        };
        match self.pairs.get_mut(number as usize) {
            Some(free) => *free = pair,
            None => self.pairs.push(pair),
        }
        true
    }

    /// Tells the entity of a pair.
    pub fn name(&mut self, slots: [u32; 2], entity: Entity) {
        if let Some(&number) = self.known.get(&slots) {
            self.pairs[number as usize].entity = entity;
        }
    }

    /// Forgets a pair.
    pub fn remove(&mut self, slots: [u32; 2]) {
        let Some(number) = self.known.remove(&slots) else {
            return;
        };
        self.free.push(number);
        for (slot, place) in slots.into_iter().zip(self.pairs[number as usize].places) {
            let list = &mut self.of[slot as usize];
            list.swap_remove(place as usize);
            if let Some(&moved) = list.get(place as usize) {
                let moved = &mut self.pairs[moved as usize];
                let end = (moved.slots[0] != slot) as usize;
                moved.places[end] = place;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    #[test]
    fn lists_are_those_of_the_pairs_alive() {
        let mut rng = fastrand::Rng::with_seed(3);
        let mut pairs = Pairs::default();
        let mut expected = BTreeMap::new();
        for number in 0..3000 {
            let a = rng.u32(0..20);
            let slots = [a, a + rng.u32(1..6)];
            if rng.bool() {
                let new = pairs.insert(slots);
                assert_eq!(new, !expected.contains_key(&slots));
                if new {
                    let entity = Entity::from_raw_u32(number).unwrap();
                    pairs.name(slots, entity);
                    expected.insert(slots, entity);
                }
            } else {
                pairs.remove(slots);
                expected.remove(&slots);
            }
        }
        assert_eq!(pairs.count(), expected.len());
        assert!(!expected.is_empty());
        for slot in 0..26 {
            let mut found: Vec<_> = pairs.of(slot).collect();
            let of = |(slots, _): &(&[u32; 2], &Entity)| slots.contains(&slot);
            let mut wanted: Vec<_> = expected.iter().filter(of).map(|(_, &e)| e).collect();
            found.sort_unstable();
            wanted.sort_unstable();
            assert_eq!(found, wanted);
        }
    }
}
