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
    links: Vec<[u32; 2]>,
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
    pub fn level(&self, slot: u32) -> Option<u32> {
        Some(self.levels.of(slot)).filter(|level| *level != Levels::NONE)
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
    let Islands {
        graph,
        levels,
        links,
    } = &mut *islands;
    links.clear();
    let touching = pairs
        .iter()
        .filter(|(_, manifold)| !manifold.points.is_empty());
    links.extend(touching.map(|(pair, _)| pair.slots));
    let dynamic = |slot: u32| table.get(slot).is_some_and(BodyState::is_dynamic);
    let members = table.iter().filter(|(_, body)| body.is_dynamic());
    graph.regroup(
        table.slots(),
        members.map(|(slot, _)| slot),
        links
            .iter()
            .copied()
            .filter(|slots| slots.iter().all(|&slot| dynamic(slot))),
    );
    let stands_still = |slot| table.get(slot).is_some_and(|body| !body.is_dynamic());
    levels.find(table.slots(), links, stands_still);

    let parted = pairs.iter().filter(|(pair, _)| pair.parted);
    let parted = parted.flat_map(|(pair, _)| pair.slots);
    wake(&mut table, graph, links, parted, &mut sleepers);
}

/// Islands sleep and wake as a whole. What is awake, was roused by the user, or is carried by something that moves wakes the rest;
/// and so does what has parted: what a body lay on, or what held it down, has gone away.
fn wake(
    table: &mut BodyTable,
    graph: &Graph,
    links: &[[u32; 2]],
    parted: impl Iterator<Item = u32>,
    sleepers: &mut Query<&mut Sleeping>,
) {
    if !table.iter().any(|(_, body)| body.asleep) {
        return;
    }
    let mut awake = vec![false; graph.count];
    for (slot, body) in table.iter() {
        if let Some(island) = graph.of(slot) {
            awake[island] |= !body.asleep || body.roused;
        }
    }
    for [a, b] in links {
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
    for slot in rising {
        let body = table.get_mut(slot).expect("it was just seen");
        body.asleep = false;
        if let Ok(mut sleeping) = sleepers.get_mut(body.entity) {
            sleeping.wake();
        }
    }
}
