//! What sleeps goes to rest, island by island, and is roused as one: its bodies and pairs get the marker [`Resting`], and with it leave
//! what the stages go through.
//!
//! A resting island is remembered as the list of its bodies. In the graph of those that are active it is one node, and has a part in
//! it only where an active body touches it.

use crate::body::{BodyTable, Resting};
use crate::broadphase::Broadphase;
use bevy_ecs::prelude::*;

/// The islands that rest.
#[derive(Default)]
pub(super) struct Groups {
    /// By slot; means something only where the body rests.
    of: Vec<u32>,
    members: Vec<Vec<(u32, Entity)>>,
    free: Vec<u32>,
}

impl Groups {
    /// The island of a body that rests.
    pub fn of(&self, slot: u32) -> Option<u32> {
        self.of.get(slot as usize).copied()
    }

    /// How many numbers of islands are in use, at most.
    pub fn count(&self) -> usize {
        self.members.len()
    }

    /// The bodies of an island. Some may have gone, and their slots to others.
    pub fn members(&self, island: u32) -> &[(u32, Entity)] {
        self.members.get(island as usize).map_or(&[], Vec::as_slice)
    }

    /// Dissolves an island: its bodies. Some may have gone, and their slots to others.
    pub fn take(&mut self, island: u32) -> Vec<(u32, Entity)> {
        self.free.push(island);
        std::mem::take(&mut self.members[island as usize])
    }

    /// Bodies that rest together from now on.
    pub fn insert(&mut self, members: Vec<(u32, Entity)>) {
        let group = self.free.pop().unwrap_or(self.members.len() as u32);
        for &(slot, _) in &members {
            if self.of.len() <= slot as usize {
                self.of.resize(slot as usize + 1, u32::MAX);
            }
            self.of[slot as usize] = group;
        }
        match self.members.get_mut(group as usize) {
            Some(free) => *free = members,
            None => self.members.push(members),
        }
    }
}

/// What is to go to rest.
#[derive(Default)]
pub(super) struct Tired {
    pub bodies: Vec<(u32, Entity)>,
    pub pairs: Vec<(Entity, [u32; 2])>,
}

impl Tired {
    pub fn is_empty(&self) -> bool {
        self.bodies.is_empty() && self.pairs.is_empty()
    }
}

/// Lays down what is to rest.
pub(super) fn lay_down(world: &mut World, Tired { bodies, pairs }: Tired) {
    let mut table = world.resource_mut::<BodyTable>();
    for &(slot, _) in &bodies {
        table.set_resting(slot, true);
    }
    // Some of their bodies may just have been roused.
    let rest = |slots: [u32; 2]| slots.into_iter().all(|slot| table.rests(slot));
    let pairs = pairs.into_iter().filter(|&(_, slots)| rest(slots));
    let all = bodies.into_iter().map(|(_, body)| body);
    let all: Vec<Entity> = all.chain(pairs.map(|(pair, _)| pair)).collect();
    // Who is gone by now is missed by *prepare*.
    let _ = world.try_insert_batch(all.into_iter().map(|entity| (entity, Resting::new())));
}

/// Part of the stages *prepare*, *broadphase* and *islands*: bodies that something was done to while they rested do so no more, nor do
/// their pairs.
pub fn rouse(world: &mut World) {
    let mut table = world.resource_mut::<BodyTable>();
    if table.stirred.is_empty() {
        return;
    }
    let stirred = std::mem::take(&mut table.stirred);
    let mut risen = Vec::new();
    for slot in stirred {
        let Some(entity) = table.get(slot).map(|body| body.entity) else {
            continue;
        };
        if table.set_resting(slot, false) {
            risen.push((slot, entity));
        }
    }
    let pairs = &world.resource::<Broadphase>().pairs;
    let mut marked: Vec<Entity> = Vec::new();
    for &(slot, body) in &risen {
        marked.push(body);
        marked.extend(pairs.of(slot));
    }
    for entity in marked {
        if let Ok(mut entity) = world.get_entity_mut(entity) {
            entity.remove::<Resting>();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bodies_at_rest_are_known_by_their_island_until_it_is_dissolved() {
        let mut groups = Groups::default();
        let body = |slot: u32| (slot, Entity::from_raw_u32(slot).unwrap());
        groups.insert(vec![body(4), body(7)]);
        groups.insert(vec![body(2)]);
        assert_eq!([7, 4, 2].map(|slot| groups.of(slot)), [0, 0, 1].map(Some));
        assert_eq!(groups.of(9), None);
        assert_eq!(groups.take(0), [body(4), body(7)]);
        assert_eq!(groups.take(0), []);
        groups.insert(vec![body(7), body(9)]);
        assert_eq!([9, 7, 2].map(|slot| groups.of(slot)), [0, 0, 1].map(Some));
        assert_eq!(groups.count(), 2);
    }
}
