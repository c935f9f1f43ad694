//! Groups of bodies whose boxes overlap.

use super::each;
use crate::body::{BodyState, BodyTable};
use crate::broadphase::Broadphase;
use crate::graph::Parts;
use crate::settings::PhysicsThreads;
use std::ops::Range;

/// Dynamic bodies that overlap, directly or over each other, and all pairs with at least one of them.
#[derive(Clone, Debug)]
pub(super) struct Group<'a> {
    /// Slots of its bodies, in order of spawning.
    pub bodies: &'a [u32],
    /// Slots of A and B.
    pub pairs: &'a [[u32; 2]],
}

/// The groups of all bodies that arrive.
#[derive(Debug, Default)]
pub(super) struct Groups {
    bodies: Vec<u32>,
    pub pairs: Vec<[u32; 2]>,
    /// Ranges in both lists.
    ranges: Vec<(Range<usize>, Range<usize>)>,
    /// Static bodies, each with its level of support.
    pub fixed: Vec<(u32, u32)>,
    /// Bodies that are left to the stages.
    pub left_out: Vec<u32>,
}

/// Number of bodies whose overlaps one thread finds at a time.
const BODIES_PER_TASK: usize = 1024;

/// The neighbours of a body that arrives.
#[derive(Default)]
struct Near {
    /// Pairs of which it is the later body, or the only one that arrives.
    pairs: Vec<[u32; 2]>,
    /// Indices of bodies whose contacts are for the stages to find.
    left_out: Vec<u32>,
}

impl Groups {
    /// Finds the pairs of bodies that arrive, by their slots in order of spawning. Their boxes are in the tree.
    pub fn find(
        broadphase: &Broadphase,
        table: &BodyTable,
        slots: &[u32],
        threads: &PhysicsThreads,
    ) -> Self {
        let mut places = Places::new(slots);
        let shares: Vec<Range<usize>> = (0..slots.len())
            .step_by(BODIES_PER_TASK)
            .map(|first| first..(first + BODIES_PER_TASK).min(slots.len()))
            .collect();
        let near = each(threads, slots.len(), &shares, |share| {
            let mut near = Near::default();
            for i in share.clone() {
                near.look(broadphase, table, &places, (i as u32, slots[i]));
            }
            near
        });
        // Read once, in the order of the table, and not for each pair.
        let dynamic = slots.iter().map(|&slot| table.get(slot));
        let dynamic: Vec<bool> = dynamic
            .map(|body| body.is_some_and(BodyState::is_dynamic))
            .collect();
        let pairs = || near.iter().flat_map(|near| &near.pairs);
        for pair in pairs() {
            if let [Some(a), Some(b)] = pair.map(|slot| places.of(slot))
                && dynamic[a as usize]
                && dynamic[b as usize]
            {
                places.groups.join(a, b);
            }
        }
        let marked = near.iter().flat_map(|near| &near.left_out);
        let left_out = places.left_out(slots.len(), marked, pairs());
        let mut groups = Self::default();
        // By index: the number of the group of a body. The first body of a group comes before the others.
        let mut numbers: Vec<Option<u32>> = vec![None; slots.len()];
        let mut counts: Vec<[usize; 2]> = Vec::new();
        for (i, &slot) in (0..).zip(slots) {
            let first = places.groups.first(i);
            if left_out[first as usize] {
                groups.left_out.push(slot);
            } else if !dynamic[i as usize] {
                groups.fixed.push((slot, 0));
            } else {
                let number = numbers[first as usize].unwrap_or_else(|| {
                    counts.push([0; 2]);
                    counts.len() as u32 - 1
                });
                numbers[i as usize] = Some(number);
                counts[number as usize][0] += 1;
            }
        }
        let group_of = |slot: u32| numbers[places.of(slot)? as usize].map(|group| group as usize);
        let of_pair = |[a, b]: [u32; 2]| group_of(a).or_else(|| group_of(b));
        for &pair in pairs() {
            if let Some(group) = of_pair(pair) {
                counts[group][1] += 1;
            }
        }
        let mut ends = [0; 2];
        let mut next: Vec<[usize; 2]> = Vec::with_capacity(counts.len());
        for count in counts {
            let [bodies, pairs] = ends;
            next.push(ends);
            ends = [bodies + count[0], pairs + count[1]];
            groups.ranges.push((bodies..ends[0], pairs..ends[1]));
        }
        groups.bodies = vec![0; ends[0]];
        groups.pairs = vec![[0; 2]; ends[1]];
        for (&slot, &group) in slots.iter().zip(&numbers) {
            if let Some(group) = group.map(|group| group as usize) {
                groups.bodies[next[group][0]] = slot;
                next[group][0] += 1;
            }
        }
        for &pair in pairs() {
            if let Some(group) = of_pair(pair) {
                groups.pairs[next[group][1]] = pair;
                next[group][1] += 1;
            }
        }
        groups
    }

    /// The groups, divided into portions of about this many pairs.
    pub fn portions(&self, pairs: usize) -> Vec<Vec<Group<'_>>> {
        let mut portions: Vec<Vec<Group>> = Vec::new();
        let mut count = usize::MAX;
        for (bodies, of_it) in &self.ranges {
            if count >= pairs {
                portions.push(Vec::new());
                count = 0;
            }
            count += of_it.len().max(bodies.len());
            if let Some(portion) = portions.last_mut() {
                portion.push(Group {
                    bodies: &self.bodies[bodies.clone()],
                    pairs: &self.pairs[of_it.clone()],
                });
            }
        }
        portions
    }
}

impl Near {
    /// Finds what is near a body, by its index and its slot.
    fn look(
        &mut self,
        broadphase: &Broadphase,
        table: &BodyTable,
        places: &Places,
        (index, slot): (u32, u32),
    ) {
        for pair in broadphase.pairs_of(table, slot) {
            let other = if pair[0] == slot { pair[1] } else { pair[0] };
            if places.of(other).is_some() {
                // The later body of a pair finds it. One without a box finds none.
                if pair[1] == slot || !broadphase.has_box(other) {
                    self.pairs.push(pair);
                }
                continue;
            }
            let other = table.get(other);
            if other.is_none_or(|other| other.is_static() && !other.asks_for_hooks()) {
                self.pairs.push(pair);
            } else {
                self.left_out.push(index);
            }
        }
    }
}

/// The index of each body among those that arrive, and which of them are in one group.
struct Places {
    first_slot: u32,
    /// By slot, from the first one on.
    indices: Vec<u32>,
    /// By index.
    groups: Parts,
}

impl Places {
    fn new(slots: &[u32]) -> Self {
        let first_slot = slots.iter().copied().min().unwrap_or(0);
        let last = slots.iter().copied().max().unwrap_or(0);
        let mut indices = vec![u32::MAX; (last - first_slot) as usize + 1];
        for (i, &slot) in (0..).zip(slots) {
            indices[(slot - first_slot) as usize] = i;
        }
        Self {
            first_slot,
            indices,
            groups: Parts::new(slots.len()),
        }
    }

    /// The index of a body that arrives.
    fn of(&self, slot: u32) -> Option<u32> {
        let at = slot.checked_sub(self.first_slot)?;
        let index = self.indices.get(at as usize).copied();
        index.filter(|&index| index != u32::MAX)
    }

    /// By first body of a group: whether its contacts are left to the stages, because one of its bodies is marked or is near one that is.
    fn left_out<'a>(
        &mut self,
        bodies: usize,
        marked: impl Iterator<Item = &'a u32>,
        pairs: impl Iterator<Item = &'a [u32; 2]> + Clone,
    ) -> Vec<bool> {
        let mut left_out = vec![false; bodies];
        for &i in marked {
            left_out[self.groups.first(i) as usize] = true;
        }
        if left_out.contains(&true) {
            self.spread(pairs, &mut left_out);
        }
        left_out
    }

    /// Marks all groups that are near a marked one, over static bodies that arrive.
    fn spread<'a>(
        &mut self,
        pairs: impl Iterator<Item = &'a [u32; 2]> + Clone,
        marked: &mut [bool],
    ) {
        loop {
            let mut is_done = true;
            for pair in pairs.clone() {
                if let [Some(a), Some(b)] = pair.map(|slot| self.of(slot)) {
                    let (a, b) = (self.groups.first(a) as usize, self.groups.first(b) as usize);
                    if marked[a] != marked[b] {
                        (marked[a], marked[b]) = (true, true);
                        is_done = false;
                    }
                }
            }
            if is_done {
                break;
            }
        }
    }
}
