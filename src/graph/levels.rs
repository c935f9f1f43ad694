//! Levels of support: how many contacts a body is away from a static or kinematic body.
//!
//! A sweep of the solver passes loads from body to body. A sweep from the ground up carries them through a whole structure; a sweep from
//! the top down lets everything fall. So contacts are swept by the level of support of their bodies, and within a level in spawn order.
//! This order depends on how the bodies are stacked, not on how they were spawned, and it keeps bodies that touch near each other in the
//! order (Cuthill and McKee 1969 number the unknowns of a sparse matrix by levels for the same reason).
//!
//! Invariant, after every update: a static or kinematic body has level 0. The level of a dynamic body is one more than the lowest level
//! among the bodies that it is linked to, or none if it is not connected to a static or kinematic body. This is the result of a
//! breadth-first search from all static and kinematic bodies (`recompute`, the oracle of the tests). An update visits only bodies whose
//! level changes, and their neighbours:
//! 1. *Lost support.* From the lowest up, a body near a removed link keeps its level if one of its neighbours is one level below it.
//!    Otherwise it loses its level for now, and its neighbours one level above it are checked in turn.
//! 2. *Shorter ways.* Bodies without a level, and bodies at new links, take the lowest level that their neighbours allow, from the lowest
//!    up.

use super::edges::ConstraintGraph;
use crate::body::{WORLD, cover};
use crate::stored::clone_fields;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// The content of a slot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// No body.
    Empty,
    /// A body that contacts can move.
    Dynamic,
    /// A static or kinematic body.
    Fixed,
}

/// The level of support of each slot.
#[derive(Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Levels {
    levels: Vec<u32>,
    /// Scratch: bodies to check, by level.
    #[cfg_attr(feature = "serde", serde(skip))]
    queue: BinaryHeap<Reverse<(u32, u32)>>,
    /// Scratch: bodies that have lost their level.
    lost: Vec<u32>,
    /// Bodies whose level the last update has set or removed.
    changed: Vec<u32>,
}

clone_fields!(Levels {
    levels,
    queue,
    lost,
    changed,
});

impl Levels {
    /// The level of a body without support.
    pub const NONE: u32 = u32::MAX;

    pub fn of(&self, slot: u32) -> u32 {
        self.levels
            .get(slot as usize)
            .copied()
            .unwrap_or(Self::NONE)
    }

    /// Bodies whose level the last update may have changed.
    pub fn changed(&self) -> &[u32] {
        &self.changed
    }

    /// [Covers](cover) so many slots.
    pub fn cover(&mut self, slots: usize) {
        cover(&mut self.levels, slots, Self::NONE);
    }

    /// Sets the level of a body that was added together with all of its links.
    pub fn put(&mut self, slot: u32, level: u32) {
        if self.levels.len() <= slot as usize {
            self.levels.resize(slot as usize + 1, Self::NONE);
        }
        self.levels[slot as usize] = level;
    }

    /// Updates the levels after edges began or ceased to link, and after slots changed their content.
    pub fn update(
        &mut self,
        graph: &ConstraintGraph,
        kind: impl Fn(u32) -> Kind,
        [linked, unlinked]: [&[[u32; 2]]; 2],
        renewed: &[u32],
    ) {
        let slots = [linked, unlinked].into_iter().flat_map(<[_]>::as_flattened);
        let slots = slots.filter(|&&slot| slot != WORLD);
        let last = slots.chain(renewed).max();
        if let Some(&last) = last
            && self.levels.len() <= last as usize
        {
            self.levels.resize(last as usize + 1, Self::NONE);
        }
        self.changed.clear();
        self.lose(graph, &kind, unlinked, renewed);
        self.find(graph, &kind, linked, renewed);
    }

    /// Removes the level of bodies that have lost their support.
    fn lose(
        &mut self,
        graph: &ConstraintGraph,
        kind: &impl Fn(u32) -> Kind,
        unlinked: &[[u32; 2]],
        renewed: &[u32],
    ) {
        self.queue.clear();
        self.lost.clear();
        for &slot in renewed {
            match kind(slot) {
                Kind::Empty => self.levels[slot as usize] = Self::NONE,
                Kind::Dynamic => self.remove(graph, slot),
                Kind::Fixed => (),
            }
        }
        for &slot in unlinked.as_flattened() {
            if slot == WORLD {
                continue;
            }
            let level = self.levels[slot as usize];
            if kind(slot) == Kind::Dynamic && level != Self::NONE {
                self.queue.push(Reverse((level, slot)));
            }
        }
        while let Some(Reverse((level, slot))) = self.queue.pop() {
            if self.levels[slot as usize] != level || kind(slot) != Kind::Dynamic {
                continue;
            }
            let mut below = graph.neighbours(slot).map(|n| level_of(&self.levels, n));
            if !below.any(|below| below != Self::NONE && below + 1 == level) {
                self.remove(graph, slot);
            }
        }
    }

    /// Sets the level of bodies that have none, or that have a shorter way to a static or kinematic body than before.
    fn find(
        &mut self,
        graph: &ConstraintGraph,
        kind: &impl Fn(u32) -> Kind,
        linked: &[[u32; 2]],
        renewed: &[u32],
    ) {
        for &slot in renewed {
            if kind(slot) == Kind::Fixed {
                self.set(graph, slot, 0);
            }
        }
        // A new link may have ended again since, so both lists are checked against the current links.
        for &slot in self.lost.iter().chain(linked.as_flattened()) {
            // A static body is at one end of many links, and has many neighbours. Its level is known.
            if slot == WORLD || kind(slot) != Kind::Dynamic {
                continue;
            }
            let below = graph.neighbours(slot).map(|n| level_of(&self.levels, n));
            let below = below.min().filter(|&below| below != Self::NONE);
            self.queue
                .extend(below.map(|below| Reverse((below + 1, slot))));
        }
        while let Some(Reverse((level, slot))) = self.queue.pop() {
            if self.levels[slot as usize] > level && kind(slot) == Kind::Dynamic {
                self.set(graph, slot, level);
            }
        }
    }

    /// Removes the level of a body, and queues its neighbours one level above it.
    fn remove(&mut self, graph: &ConstraintGraph, slot: u32) {
        let level = std::mem::replace(&mut self.levels[slot as usize], Self::NONE);
        self.lost.push(slot);
        self.changed.push(slot);
        if level != Self::NONE {
            self.queue_neighbours(graph, slot, level + 1, |known| known == level + 1);
        }
    }

    /// Sets the level of a body, and queues its neighbours that get a lower level by it.
    fn set(&mut self, graph: &ConstraintGraph, slot: u32, level: u32) {
        self.levels[slot as usize] = level;
        self.changed.push(slot);
        self.queue_neighbours(graph, slot, level + 1, |known| known > level + 1);
    }

    /// Queues the neighbours of a body whose known level satisfies a condition, with a new level.
    fn queue_neighbours(
        &mut self,
        graph: &ConstraintGraph,
        slot: u32,
        level: u32,
        condition: impl Fn(u32) -> bool,
    ) {
        let neighbours = graph.neighbours(slot);
        let neighbours = neighbours.filter(|&n| n != WORLD && condition(self.levels[n as usize]));
        self.queue.extend(neighbours.map(|n| Reverse((level, n))));
    }
}

/// The level of a body or of the world.
#[inline]
fn level_of(levels: &[u32], slot: u32) -> u32 {
    match slot {
        WORLD => 0,
        slot => levels[slot as usize],
    }
}

/// Computes the levels of all slots from scratch.
#[cfg(test)]
pub(super) fn recompute(
    graph: &ConstraintGraph,
    slots: u32,
    kind: impl Fn(u32) -> Kind,
) -> Vec<u32> {
    let mut levels = vec![Levels::NONE; slots as usize];
    let mut queue: Vec<u32> = (0..slots)
        .filter(|&slot| kind(slot) == Kind::Fixed)
        .collect();
    for &slot in &queue {
        levels[slot as usize] = 0;
    }
    for slot in (0..slots).filter(|&slot| kind(slot) == Kind::Dynamic) {
        if graph.neighbours(slot).any(|n| n == WORLD) {
            levels[slot as usize] = 1;
            queue.push(slot);
        }
    }
    queue.sort_by_key(|&slot| levels[slot as usize]);
    // Bodies at level 1 that hang on the world come after those at level 0, so the search still goes level by level.
    let mut queue = std::collections::VecDeque::from(queue);
    while let Some(slot) = queue.pop_front() {
        for n in graph.neighbours(slot).filter(|&n| n != WORLD) {
            let level = levels[slot as usize] + 1;
            if levels[n as usize] == Levels::NONE {
                levels[n as usize] = level;
                queue.push_back(n);
            }
        }
    }
    levels
}
