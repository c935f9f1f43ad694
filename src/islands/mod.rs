//! The stage **islands**: groups bodies that push on each other, finds what stands on what (its level of support), and wakes islands that may not
//! sleep on. It comes before forces, so that what wakes has all of its weight when it is first solved.
//!
//! Static and kinematic bodies do not connect islands.

mod graph;
mod order;

use crate::body::{Age, BodyState, BodyTable, Velocity};
use crate::contact::{ContactPair, Manifold};
use crate::sleeping::Sleeping;
use bevy_ecs::prelude::*;
use graph::Graph;
use order::Levels;

/// Which island each body is in, and what stands on what.
#[derive(Resource, Default)]
pub struct Islands {
    graph: Graph,
    levels: Levels,
    links: Vec<Link>,
    members: Vec<Option<Member>>,
    version: u64,
    woke: bool,
}

/// A pair that touches: its bodies' slots, and which of all pairs it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Link {
    slots: [u32; 2],
    pair: u32,
}

/// Who is in a slot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Member {
    entity: Entity,
    age: Age,
    dynamic: bool,
    asleep: bool,
}

impl Member {
    #[inline]
    fn of(body: &BodyState) -> Self {
        Self {
            entity: body.entity,
            age: body.age,
            dynamic: body.is_dynamic(),
            asleep: body.asleep,
        }
    }

    /// The same body of the same kind, be it awake or asleep.
    fn is_same(before: &Option<Self>, now: &Option<Self>) -> bool {
        match (before, now) {
            (Some(before), Some(now)) => {
                (before.entity, before.age, before.dynamic) == (now.entity, now.age, now.dynamic)
            }
            (None, None) => true,
            _ => false,
        }
    }
}

impl Islands {
    /// The island of a dynamic body, by its slot.
    pub fn of(&self, slot: u32) -> Option<usize> {
        self.graph.of(slot)
    }

    /// How many there are, sleeping ones included.
    pub fn count(&self) -> usize {
        self.graph.count
    }

    /// How many contacts a body is away from what stands still; `None` where nothing carries it.
    #[inline]
    pub fn level(&self, slot: u32) -> Option<u32> {
        Some(self.levels.of(slot)).filter(|level| *level != Levels::NONE)
    }

    /// Somebody was woken in this step.
    pub(crate) fn woke(&self) -> bool {
        self.woke
    }

    /// Another whenever who touches whom, who is awake, or where pairs are kept is not as it was.
    pub(crate) fn version(&self) -> u64 {
        self.version
    }

    fn regroup(&mut self, links: &[Link], members: &[Option<Member>]) {
        let moves = |slot: u32| members[slot as usize].is_some_and(|member| member.dynamic);
        let slots = 0..members.len() as u32;
        let links: Vec<[u32; 2]> = links.iter().map(|link| link.slots).collect();
        let both_move = |slots: &&[u32; 2]| slots.iter().all(|&slot| moves(slot));
        self.graph.regroup(
            members.len(),
            slots.filter(|&slot| moves(slot)),
            links.iter().filter(both_move).copied(),
        );
        let stands_still = |slot: u32| members[slot as usize].is_some_and(|member| !member.dynamic);
        self.levels.find(members.len(), &links, stands_still);
    }

    /// What bodies and contacts are solved in the order of.
    pub(crate) fn rank(&self, slot: u32, body: &BodyState) -> (u32, Age) {
        (self.levels.of(slot), body.age)
    }
}

/// See the module's text.
pub fn islands(
    mut table: ResMut<BodyTable>,
    mut islands: ResMut<Islands>,
    pairs: Query<(&ContactPair, &Manifold)>,
    mut sleepers: Query<&mut Sleeping>,
) {
    let touching = pairs.iter().zip(0..);
    let touching = touching.filter(|((_, manifold), _)| !manifold.points.is_empty());
    let links: Vec<Link> = touching
        .map(|((pair, _), number)| Link {
            slots: pair.slots,
            pair: number,
        })
        .collect();
    let members = table.slot_bodies().map(|body| body.map(Member::of));
    let mut now: Vec<Option<Member>> = members.collect();
    let before = &islands.members;
    let same_graph = links == islands.links
        && now.len() == before.len()
        && before.iter().zip(&now).all(|(a, b)| Member::is_same(a, b));
    if !same_graph {
        islands.regroup(&links, &now);
    }
    islands.links = links;

    islands.woke = false;
    if now.iter().flatten().any(|member| member.asleep) {
        let parted = pairs.iter().filter(|(pair, _)| pair.parted);
        let parted = parted.flat_map(|(pair, _)| pair.slots);
        islands.woke = wake(&mut table, &islands, parted, &mut sleepers);
    }
    if islands.woke {
        now.clear();
        now.extend(table.slot_bodies().map(|body| body.map(Member::of)));
    }
    if !same_graph || now != islands.members {
        islands.version += 1;
    }
    islands.members = now;
}

/// Islands sleep and wake as a whole. What is awake, was roused by the user, or is carried by something that moves wakes the rest;
/// and so does what has parted: what a body lay on, or what held it down, has gone away.
fn wake(
    table: &mut BodyTable,
    islands: &Islands,
    parted: impl Iterator<Item = u32>,
    sleepers: &mut Query<&mut Sleeping>,
) -> bool {
    let Islands { graph, links, .. } = islands;
    let mut awake = vec![false; graph.count];
    for (slot, body) in table.iter() {
        if let Some(island) = graph.of(slot) {
            awake[island] |= !body.asleep || body.roused;
        }
    }
    for Link { slots: [a, b], .. } in links {
        for (carrier, carried) in [(a, b), (b, a)] {
            let (Some(below), Some(above)) = (table.get(*carrier), table.get(*carried)) else {
                continue;
            };
            // What comes into the world together with its ground may sleep on it.
            let changes = (below.moved || below.renewed) && !(below.arrived && above.arrived);
            let moves = !below.is_dynamic() && (changes || below.velocity != Velocity::default());
            if moves && let Some(island) = graph.of(*carried) {
                awake[island] = true;
            }
        }
    }
    for slot in parted {
        if let Some(island) = graph.of(slot) {
            awake[island] = true;
        }
    }
    let rising: Vec<u32> = table
        .iter()
        .filter(|(slot, body)| body.asleep && graph.of(*slot).is_some_and(|i| awake[i]))
        .map(|(slot, _)| slot)
        .collect();
    let woke = !rising.is_empty();
    for slot in rising {
        let body = table.get_mut(slot).expect("it was just seen");
        body.asleep = false;
        if let Ok(mut sleeping) = sleepers.get_mut(body.entity) {
            sleeping.wake();
        }
    }
    woke
}
