//! What stands on what: how many contacts a body is away from what stands still, its level of support.
//!
//! Loads travel from body to body with a sweep, and a sweep from the ground up carries them through a whole structure; from the top
//! down everything falls. So contacts are swept by the level of support of their bodies, and within a level in spawn order. That follows from
//! how things stand, not from how they were spawned, and it keeps bodies that touch near each other in the order (Cuthill and
//! McKee 1969 number the unknowns of a sparse matrix so for the same reason).
//!
//! Invariant, after every update: a body that stands still has level 0; any other is one above the lowest that it is linked to, or has
//! none where no way leads to what stands still. That is what a search breadth first from all that stands still finds (`recompute`, the
//! oracle of the tests). An update visits only bodies whose level changes, and their neighbours:
//! 1. *What has lost its support.* From the lowest up, a body near a link that is gone keeps its level if one of its neighbours is one below
//!    it. Otherwise it has none for now, and those one above it are looked at in turn.
//! 2. *What is nearer now.* Bodies without a level, and those at new links, take the lowest that their neighbours allow, from the lowest up.

use super::edges::ConstraintGraph;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// What a slot holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// No body.
    Empty,
    /// A body that contacts can move.
    Dynamic,
    /// A body that stands still, or moves by itself.
    Fixed,
}

/// By slot.
#[derive(Clone, Debug, Default)]
pub(super) struct Levels {
    levels: Vec<u32>,
    /// Bodies to look at, by level: scratch.
    queue: BinaryHeap<Reverse<(u32, u32)>>,
    /// Bodies that have lost their level: scratch.
    lost: Vec<u32>,
}

impl Levels {
    /// Of a body that nothing carries.
    pub const NONE: u32 = u32::MAX;

    pub fn of(&self, slot: u32) -> u32 {
        self.levels
            .get(slot as usize)
            .copied()
            .unwrap_or(Self::NONE)
    }

    /// Brings the levels up to date, where edges have begun and ceased to link, and slots hold others than before.
    pub fn update(
        &mut self,
        graph: &ConstraintGraph,
        kind: impl Fn(u32) -> Kind,
        [linked, unlinked]: [&[[u32; 2]]; 2],
        renewed: &[u32],
    ) {
        let slots = [linked, unlinked].into_iter().flat_map(<[_]>::as_flattened);
        let last = slots.chain(renewed).max();
        if let Some(&last) = last
            && self.levels.len() <= last as usize
        {
            self.levels.resize(last as usize + 1, Self::NONE);
        }
        self.lose(graph, &kind, unlinked, renewed);
        self.find(graph, &kind, linked, renewed);
    }

    /// Takes the level from bodies that have lost their support.
    fn lose(
        &mut self,
        graph: &ConstraintGraph,
        kind: &impl Fn(u32) -> Kind,
        unlinked: &[[u32; 2]],
        renewed: &[u32],
    ) {
        let Self {
            levels,
            queue,
            lost,
        } = self;
        queue.clear();
        lost.clear();
        for &slot in renewed {
            let level = &mut levels[slot as usize];
            match kind(slot) {
                Kind::Empty => *level = Self::NONE,
                Kind::Dynamic => {
                    let carried = std::mem::replace(level, Self::NONE);
                    lost.push(slot);
                    let above = graph.neighbours(slot);
                    let above = above.filter(|&n| levels[n as usize] == carried.wrapping_add(1));
                    queue.extend(above.map(|n| Reverse((carried.wrapping_add(1), n))));
                }
                Kind::Fixed => (),
            }
        }
        for &slot in unlinked.as_flattened() {
            if kind(slot) == Kind::Dynamic && levels[slot as usize] != Self::NONE {
                queue.push(Reverse((levels[slot as usize], slot)));
            }
        }
        while let Some(Reverse((level, slot))) = queue.pop() {
            if levels[slot as usize] != level || kind(slot) != Kind::Dynamic {
                continue;
            }
            let mut below = graph.neighbours(slot).map(|n| levels[n as usize]);
            if below.any(|below| below != Self::NONE && below + 1 == level) {
                continue;
            }
            levels[slot as usize] = Self::NONE;
            lost.push(slot);
            let above = graph.neighbours(slot);
            let above = above.filter(|&n| levels[n as usize] == level + 1);
            queue.extend(above.map(|n| Reverse((level + 1, n))));
        }
    }

    /// Gives bodies a level that have none, or that are nearer to what stands still than before.
    fn find(
        &mut self,
        graph: &ConstraintGraph,
        kind: &impl Fn(u32) -> Kind,
        linked: &[[u32; 2]],
        renewed: &[u32],
    ) {
        let Self {
            levels,
            queue,
            lost,
        } = self;
        for &slot in renewed {
            if kind(slot) == Kind::Fixed {
                levels[slot as usize] = 0;
                queue.extend(graph.neighbours(slot).map(|n| Reverse((1, n))));
            }
        }
        // A link may have ended again since it began, so both look at the links there are.
        for &slot in lost.iter().chain(linked.as_flattened()) {
            let below = graph.neighbours(slot).map(|n| levels[n as usize]);
            let below = below.min().filter(|&below| below != Self::NONE);
            queue.extend(below.map(|below| Reverse((below + 1, slot))));
        }
        while let Some(Reverse((level, slot))) = queue.pop() {
            if levels[slot as usize] <= level || kind(slot) != Kind::Dynamic {
                continue;
            }
            levels[slot as usize] = level;
            let above = graph.neighbours(slot);
            let above = above.filter(|&n| levels[n as usize] > level + 1);
            queue.extend(above.map(|n| Reverse((level + 1, n))));
        }
    }
}

/// The levels of all slots, found anew.
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
    let mut next = 0;
    while let Some(&slot) = queue.get(next) {
        next += 1;
        for n in graph.neighbours(slot) {
            if levels[n as usize] == Levels::NONE {
                levels[n as usize] = levels[slot as usize] + 1;
                queue.push(n);
            }
        }
    }
    levels
}
