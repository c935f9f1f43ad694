//! Edits of kept blocks: patches that begin or end in a large island.
//!
//! A patch that begins is put into a lane that is free, in a block after all earlier patches of its bodies and before all later ones. If there
//! is none, it gets a block of its own there. A patch that ends leaves its lane. The sweep stays the sequential one, so velocities and impulses
//! have the same bits as with blocks that are found anew; only the blocks are filled less well, and are found anew after some edits.
//!
//! The blocks of patches whose springs are stiffer or softer now, because their bodies have other neighbours, are loaded again.

use super::block::{Block, Points};
use super::blows::Blows;
use super::grabs::GrabPlaces;
use super::island::{Island, neighbours, rounds};
use super::kept::Kept;
#[cfg(not(target_arch = "x86_64"))]
use crate::lanes::F32x4;
#[cfg(target_arch = "x86_64")]
use crate::lanes::F32x8;
use crate::lanes::F32xN;
use crate::patches::PatchEdit;
use crate::revision::Revision;
use crate::sort;
use crate::{Lanes, PatchProblem};

/// The width of edited blocks: the one of large islands.
#[cfg(target_arch = "x86_64")]
type Wide = F32x8;
#[cfg(not(target_arch = "x86_64"))]
type Wide = F32x4;

/// Number of patches for each edit that blocks take before they are found anew.
const PATCHES_PER_EDIT: usize = 256;

/// Mean number of patches in a block of eight from which on it is edited. It is well above that from which on eight lanes are chosen, so
/// blocks that were found anew would have eight lanes too.
#[cfg(target_arch = "x86_64")]
const WELL_FILLED: usize = 5;

/// Takes over the edits of the problem into the state that is kept of it, or discards that.
pub fn take_over_edits(problem: &mut PatchProblem) {
    let edits = problem.memory.take_edits();
    if edits.is_empty() {
        return;
    }
    let kept = problem.memory.take::<Kept<Wide>>();
    let kept = kept.filter(|kept| may_edit(kept, problem, edits.len()));
    if let Some(mut kept) = kept
        && kept.edit(problem, &edits)
        && still_as_wide(&kept)
    {
        problem.memory.keep(kept);
    }
}

/// Whether blocks that were found anew would have the same width.
fn still_as_wide(kept: &Kept<Wide>) -> bool {
    #[cfg(target_arch = "x86_64")]
    return kept.island.lanes != Lanes::Auto || kept.island.batches.holds(WELL_FILLED);
    #[cfg(not(target_arch = "x86_64"))]
    true
}

/// Whether blocks can be edited: each patch is in one lane, and nothing but contacts acts on the bodies.
fn may_edit<L: F32xN>(kept: &Kept<L>, problem: &PatchProblem, edits: usize) -> bool {
    let batches = &kept.island.batches;
    kept.edits + edits <= problem.patches.len() / PATCHES_PER_EDIT
        && batches.laps() == 1
        && !batches.has_rounds()
        && rounds(problem).is_empty()
        && problem.grabs.is_empty()
        && kept.island.grabs.is_empty()
        && problem.joints.is_empty()
        && kept.island.joints.is_empty()
}

impl<L: F32xN> Kept<L> {
    /// Makes the edits of the problem. Returns false, and leaves an unspecified state, if blocks have to be found anew.
    fn edit(&mut self, problem: &PatchProblem, edits: &[PatchEdit]) -> bool {
        self.edits += edits.len();
        self.blows = Blows::default();
        self.island.edit(problem, edits)
    }
}

impl<L: F32xN> Island<L> {
    fn edit(&mut self, problem: &PatchProblem, edits: &[PatchEdit]) -> bool {
        let moves = |body: u32| problem.bodies[body as usize].inverse_mass > 0.0;
        // Bodies that have other neighbours now.
        let mut touched = vec![false; problem.bodies.len()];
        let mut begun = Vec::new();
        let mut stale = Vec::new();
        for PatchEdit { at, removed, added } in edits {
            let end = at + removed.len();
            stale.extend(self.batches.splice(*at, removed.len(), *added));
            let revisions = (0..*added).map(|_| Revision::next());
            self.loaded.splice(*at..end, revisions);
            for &body in removed.as_flattened() {
                touched[body as usize] = moves(body);
            }
            begun.retain(|patch| !(*at..end).contains(patch));
            for patch in begun.iter_mut().filter(|patch| **patch >= end) {
                *patch = *patch + added - removed.len();
            }
            begun.extend(*at..at + added);
        }
        for &patch in &begun {
            for body in problem.patches[patch].bodies {
                touched[body as usize] = moves(body);
            }
        }
        let is_touched = |bodies: [u32; 2]| bodies.iter().any(|&body| touched[body as usize]);
        let affected: Vec<usize> = (0..problem.patches.len())
            .filter(|&patch| is_touched(problem.patches[patch].bodies))
            .collect();
        let mut places = self.batches.places();
        for patch in begun {
            let bodies = problem.patches[patch].bodies;
            let shares = |other: &usize| {
                let others = problem.patches[*other].bodies;
                bodies
                    .iter()
                    .any(|body| moves(*body) && others.contains(body))
            };
            let known = affected
                .iter()
                .filter(|&&other| places[other] != usize::MAX);
            let near = known.filter(|other| shares(other));
            let (mut start, mut end) = (0, self.batches.blocks());
            for &other in near {
                match other < patch {
                    true => start = start.max(places[other] + 1),
                    false => end = end.min(places[other]),
                }
            }
            // The bodies had nothing to do with each other, and one was finished before the other began.
            if start > end {
                return false;
            }
            let (block, is_new) = self.batches.insert(patch as u32, start..end);
            if is_new {
                self.insert_block(block, problem);
                let after = |place: &&mut usize| **place != usize::MAX && **place >= block;
                places
                    .iter_mut()
                    .filter(after)
                    .for_each(|place| *place += 1);
                stale
                    .iter_mut()
                    .filter(|place| **place >= block)
                    .for_each(|place| *place += 1);
            }
            places[patch] = block;
        }
        stale.extend(affected.iter().map(|&patch| places[patch]));
        sort::values(&mut stale);
        stale.dedup();
        let neighbours = neighbours(problem);
        for block in stale {
            self.load_block(block, problem, &neighbours);
        }
        self.pipeline = None;
        self.grab_places = GrabPlaces::default();
        true
    }

    /// Inserts an empty block without points.
    fn insert_block(&mut self, at: usize, problem: &PatchProblem) {
        let null_body = problem.bodies.len() as u32;
        // The entries of the other blocks are those before.
        let mut block = Block::new(null_body, null_body + 1 + self.blocks.len() as u32);
        let next = self.blocks.get(at);
        let first = next.map_or(self.points.len(), |next| next.range().start);
        block.place(first, 0);
        self.blocks.insert(at, block);
    }

    /// Loads the patches of a block as if it was new.
    fn load_block(&mut self, number: usize, problem: &PatchProblem, neighbours: &[u32]) {
        let lanes = self.batches.block(number);
        let patches = lanes.map(|(lane, patch)| (lane, patch, &problem.patches[patch as usize]));
        let count = patches.clone().map(|(.., patch)| patch.count).max();
        let count = count.unwrap_or(0);
        let before = self.blocks[number].range();
        let added = count as usize as isize - before.len() as isize;
        let empty = std::iter::repeat_n(Points::default(), count as usize);
        self.points.splice(before.clone(), empty);
        if added != 0 {
            for block in &mut self.blocks[number + 1..] {
                let range = block.range();
                block.place(range.start.wrapping_add_signed(added), range.len() as u32);
            }
        }
        let mut block = Block::new(problem.bodies.len() as u32, self.blocks[number].null_target);
        block.place(before.start, count);
        let points = &mut self.points[before.start..];
        let seats = (self.batches.rounds(), 0);
        block.fill(points, patches.clone(), problem, neighbours, seats);
        self.blocks[number] = block;
        // So that effective masses are computed.
        for (_, patch, _) in patches {
            self.loaded[patch as usize] = Revision::next();
        }
    }
}

#[cfg(test)]
mod tests;
