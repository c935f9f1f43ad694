//! What sleeps goes to rest, island by island, and is roused as one: its bodies and pairs get the marker [`Resting`], and with it leave
//! what the stages go through.
//!
//! A resting island is remembered as the list of its bodies. In the graph of those that are active it is one node, and has a part in
//! it only where an active body touches it. Bodies leave rest in several ways, and are struck off the lists later: whoever reads a list asks
//! the table whether each body is still there.

use crate::body::{BodyTable, Resting};
use crate::broadphase::Broadphase;
use bevy_ecs::entity::{EntityMapper, MapEntities};
use bevy_ecs::prelude::*;

/// The islands that rest.
#[derive(Clone, Default)]
pub(super) struct Groups {
    /// By slot; means something only where the body rests.
    of: Vec<u32>,
    members: Vec<Vec<(u32, Entity)>>,
    free: Vec<u32>,
    /// How many bodies are in the lists, those that have gone or rest elsewhere by now included.
    listed: usize,
}

impl MapEntities for Groups {
    fn map_entities<M: EntityMapper>(&mut self, mapper: &mut M) {
        for (_, body) in self.members.iter_mut().flatten() {
            body.map_entities(mapper);
        }
    }
}

/// Lists are gone through when so many bodies in them may have gone, or half of all if that is more.
const FORGOTTEN: usize = 64;

impl Groups {
    /// The island of a body that rests.
    pub fn of(&self, slot: u32) -> Option<u32> {
        self.of.get(slot as usize).copied()
    }

    /// How many numbers of islands are in use, at most.
    pub fn count(&self) -> usize {
        self.members.len()
    }

    /// The bodies of an island.
    pub fn members(&self, table: &BodyTable, island: u32) -> impl Iterator<Item = (u32, Entity)> {
        let members = self.members.get(island as usize).into_iter().flatten();
        let there = move |&&member: &&(u32, Entity)| is_there(&self.of, table, island, member);
        members.filter(there).copied()
    }

    /// Dissolves an island: its bodies.
    pub fn take(&mut self, table: &BodyTable, island: u32) -> Vec<(u32, Entity)> {
        let Some(members) = self.members.get_mut(island as usize) else {
            return Vec::new();
        };
        let mut members = std::mem::take(members);
        if !members.is_empty() {
            self.listed -= members.len();
            self.free.push(island);
        }
        members.retain(|&member| is_there(&self.of, table, island, member));
        members
    }

    /// Bodies that rest together from now on.
    pub fn insert(&mut self, members: Vec<(u32, Entity)>) {
        if members.is_empty() {
            return;
        }
        self.listed += members.len();
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

    /// Strikes off bodies that have gone, or that rest no more or elsewhere, and islands without bodies. Once in a while, so that it costs
    /// as much a body as striking off one.
    pub fn forget_gone(&mut self, table: &BodyTable) {
        let gone = self.listed.saturating_sub(table.resting());
        if gone <= FORGOTTEN.max(self.listed / 2) {
            return;
        }
        for (island, members) in self.members.iter_mut().enumerate() {
            if members.is_empty() {
                continue;
            }
            let there = |&member: &_| is_there(&self.of, table, island as u32, member);
            members.retain(there);
            if members.is_empty() {
                *members = Vec::new();
                self.free.push(island as u32);
            }
        }
        self.listed = self.members.iter().map(Vec::len).sum();
    }
}

/// A body that rested in an island still does: it is the same one, and has not come to rest in another since.
fn is_there(of: &[u32], table: &BodyTable, island: u32, (slot, entity): (u32, Entity)) -> bool {
    table.rests(slot)
        && of.get(slot as usize) == Some(&island)
        && table.get(slot).is_some_and(|body| body.entity == entity)
}

/// What is to go to rest.
#[derive(Clone, Default)]
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
    use crate::body::{BodyIndex, BodyState, Pose, Velocity};

    fn state(entity: Entity) -> BodyState {
        BodyState::new(entity, Pose::default(), Velocity::default())
    }

    /// A table in which bodies of these entities rest, by slot.
    fn resting(entities: &[Entity]) -> BodyTable {
        let mut table = BodyTable::default();
        for &entity in entities {
            let index = table.insert(state(entity));
            table.set_resting(index.0, true);
        }
        table
    }

    fn entity(number: u32) -> Entity {
        Entity::from_raw_u32(number).unwrap()
    }

    #[test]
    fn bodies_at_rest_are_known_by_their_island_until_it_is_dissolved() {
        let table = resting(&(0..10).map(entity).collect::<Vec<_>>());
        let mut groups = Groups::default();
        let body = |slot: u32| (slot, entity(slot));
        groups.insert(vec![body(4), body(7)]);
        groups.insert(vec![body(2)]);
        assert_eq!([7, 4, 2].map(|slot| groups.of(slot)), [0, 0, 1].map(Some));
        assert_eq!(groups.of(9), None);
        assert_eq!(groups.take(&table, 0), [body(4), body(7)]);
        assert_eq!(groups.take(&table, 0), []);
        groups.insert(vec![body(7), body(9)]);
        assert_eq!([9, 7, 2].map(|slot| groups.of(slot)), [0, 0, 1].map(Some));
        assert_eq!(groups.count(), 2);
    }

    #[test]
    fn who_has_gone_or_rests_elsewhere_is_no_member() {
        let mut table = resting(&(0..3).map(entity).collect::<Vec<_>>());
        let mut groups = Groups::default();
        groups.insert(vec![(0, entity(0)), (1, entity(1)), (2, entity(2))]);
        table.remove(entity(1), BodyIndex(1));
        // The last one was looked at, and lies by itself now.
        groups.insert(vec![(2, entity(2))]);
        let members = |island| groups.members(&table, island).collect::<Vec<_>>();
        assert_eq!(members(0), [(0, entity(0))]);
        assert_eq!(members(1), [(2, entity(2))]);
    }

    #[test]
    fn islands_whose_bodies_have_gone_are_used_again() {
        let mut groups = Groups::default();
        let mut table = BodyTable::default();
        for round in 0..1000 {
            let body = entity(round);
            let index = table.insert(state(body));
            table.set_resting(index.0, true);
            groups.insert(vec![(index.0, body)]);
            table.remove(body, index);
            table.recycle(index.0);
            groups.forget_gone(&table);
        }
        assert!(groups.count() <= 2 * FORGOTTEN, "{}", groups.count());
    }
}
