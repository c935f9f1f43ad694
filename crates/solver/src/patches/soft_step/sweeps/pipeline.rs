//! Pipelined sweeps: they follow each other through the blocks, on several threads, or on one where the blocks are larger than its caches.
//!
//! The *reach* of a block is the last block that holds any moving body which this block holds as well. Sweep k + 1 may visit a block as
//! soon as sweep k is past its reach: no block that sweep k has yet to visit shares a body with it, so the visit finds the values that it
//! would find after the whole of sweep k, and changes nothing that sweep k has yet to read. The work on a body between two sweeps is done
//! right after the last block that holds it. So the result is that of sweeps one after the other, to the bit, on any number of threads.
//! Blocks stand in waves ([`batches`](crate::batches)), so that the next sweep follows one wave behind. Grabs are visited with the
//! block before which they stand ([`edges`](crate::patches::soft_step::grabs::places)), and that block counts their bodies as its own.
//!
//! On one thread, the first sweeps of a step follow the refresh and the warm start of blocks in the same way
//! ([`following`](super::following)).
//!
//! On two threads, a wall of 200 × 50 bricks takes 4 to 15 % less time; one of 100 × 50 takes the same.
//!
//! Sweeps form groups, and those of one group follow each other on one thread: one sweep per thread would move every block from cache to
//! cache in every sweep. A thread *claims* the next group from a counter. So a thread that waits for the previous group waits for one that
//! another thread has claimed, and the first group waits for none: no order of threads leads to a deadlock.
//!
//! Many blocks read bodies that contacts cannot change, all at the same time, so such a body must not move by itself either: on a moving
//! platform, sweeps run one after the other.

#![expect(
    unsafe_code,
    reason = "items go from thread to thread as sweeps pass them"
)]

use super::handed::Handed;
use crate::PatchProblem;
use crate::batches::Batches;
use crate::grab::ActiveGrab;
use crate::join::on_threads;
use crate::lanes::{F32xN, Kernel, State};
use crate::patches::soft_step::contact::block::{Block, Points};
use crate::patches::soft_step::contact::kinds::{Rigid, Soft};
use crate::patches::soft_step::contact::pass::Pass;
use crate::patches::soft_step::grabs::places::EdgePlaces;
use crate::patches::soft_step::island::Island;
use crate::rounds::RoundEnds;
use crate::sort;
use std::sync::atomic::{AtomicUsize, Ordering::*};

/// Sweeps in a group. Each thread gets two groups, so that all threads work until the end, and the window of blocks of a group fits a
/// cache.
const GROUP_SWEEPS: std::ops::RangeInclusive<usize> = 2..=6;

/// Distance between groups, bytes of blocks. Data that a thread has just written is in the cache of its core alone, and reading it from
/// there takes longer than reading it later. Two threads that followed closely both took half as long again, and in blocks that fit the
/// caches of two cores nothing was gained.
const GROUP_DISTANCE: usize = 2 << 20;

/// Size of all blocks from which on sweeps follow each other on one thread too, bytes: each sweep would read all blocks from memory.
const CACHE_SIZE: usize = 12 << 20;

/// Number of blocks that a sweep visits before the next sweep of the group continues.
const BLOCKS_AT_A_TIME: usize = 32;

/// The dependencies of blocks, found once for the blocks of an island.
#[derive(Default)]
pub struct Pipeline {
    /// By block: its reach.
    reach: Vec<u32>,
    /// Bodies that move, in the order of the last block that holds them.
    bodies: Vec<u32>,
    /// By block: where its bodies end in `bodies`.
    ends: Vec<u32>,
    round_ends: RoundEnds,
    /// The largest distance that a sweep keeps from the one before, blocks.
    lag: usize,
}

/// The distribution of sweeps over threads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shares {
    pub(super) threads: usize,
    /// Sweeps in a group.
    pub(super) group: usize,
    /// Blocks between groups.
    pub(super) apart: usize,
}

/// The data that sweeps read and change.
pub struct Work<'a, L: F32xN> {
    pub blocks: &'a mut [Block<L>],
    pub points: &'a mut [Points<L>],
    pub velocities: &'a mut [State],
    pub before: &'a mut [State],
    pub motions: &'a mut [State],
    pub grab_places: &'a EdgePlaces,
    pub grabs: &'a mut [ActiveGrab],
    /// The fastest correction, m/s.
    pub fastest: f32,
}

/// Returns true if sweeps over `bytes` bytes of blocks may be faster if they follow each other.
pub fn is_worthwhile(threads: usize, bytes: usize) -> bool {
    threads > 1 || bytes > CACHE_SIZE
}

impl Pipeline {
    /// Finds the dependencies of blocks, in which grabs have these places.
    pub fn of(
        batches: &Batches,
        places: &EdgePlaces,
        problem: &PatchProblem,
        round_ends: RoundEnds,
    ) -> Self {
        let mut blocks = Vec::with_capacity(batches.blocks());
        for (block, patches) in batches.iter().enumerate() {
            let mut bodies = Vec::new();
            for (_, patch) in patches {
                bodies.extend(problem.patches[patch as usize].bodies);
            }
            for group in places.before(block) {
                bodies.extend_from_slice(places.bodies_of(group));
            }
            blocks.push(bodies);
        }
        let moves = |body: u32| problem.bodies[body as usize].inverse_mass > 0.0;
        Self::new(&blocks, problem.bodies.len(), &moves, round_ends)
    }

    /// `blocks` are the bodies of each block; `moves` says whether contacts can change a body.
    fn new(
        blocks: &[Vec<u32>],
        bodies: usize,
        moves: &dyn Fn(u32) -> bool,
        round_ends: RoundEnds,
    ) -> Self {
        let mut last = vec![0u32; bodies];
        for (number, block) in (0..).zip(blocks) {
            for &body in block {
                last[body as usize] = number;
            }
        }
        let count = blocks.len() as u32;
        let mut reach = Vec::with_capacity(blocks.len());
        for (number, block) in (0..).zip(blocks) {
            let mut farthest: u32 = number;
            for &body in block.iter().filter(|&&body| moves(body)) {
                farthest = farthest.max(last[body as usize]);
            }
            reach.push(farthest);
        }
        let mut bodies: Vec<u32> = (0..bodies as u32).filter(|&body| moves(body)).collect();
        sort::by_key(&mut bodies, |&body| last[body as usize]);
        let ends = (0..count)
            .map(|block| bodies.partition_point(|&body| last[body as usize] <= block) as u32);
        let lags = (0..).zip(&reach).map(|(block, reach)| reach - block);
        Self {
            ends: ends.collect(),
            lag: lags.max().unwrap_or(0) as usize + 1,
            reach,
            bodies,
            round_ends,
        }
    }

    /// The distribution of these sweeps over at most `threads` threads, for blocks of `bytes` bytes in all; none if it is as fast to take
    /// one after the other.
    pub fn share(&self, threads: usize, sweeps: usize, bytes: usize) -> Option<Shares> {
        if sweeps < *GROUP_SWEEPS.start() {
            return None;
        }
        let blocks = self.reach.len();
        let apart = GROUP_DISTANCE * blocks / bytes.max(1);
        let least = if bytes > CACHE_SIZE { 1 } else { 2 };
        (least..=threads).rev().find_map(|threads| {
            let groups = if threads > 1 { 2 * threads } else { 1 };
            let group = sweeps.div_ceil(groups);
            let group = group.clamp(*GROUP_SWEEPS.start(), *GROUP_SWEEPS.end());
            let window = group * self.lag.max(BLOCKS_AT_A_TIME);
            let needed = threads * window + (threads - 1) * apart;
            (needed <= blocks).then_some(Shares {
                threads,
                group,
                apart,
            })
        })
    }

    /// Runs all sweeps. Calls `tell` with Σ Wᵢᵢ Δλᵢ² of each, J, in their order.
    pub fn run<L: F32xN>(
        &self,
        passes: &[Pass],
        mut work: Work<L>,
        shares: Shares,
        tell: &mut dyn FnMut(f32),
    ) {
        if shares.threads == 1 {
            for passes in passes.chunks(shares.group) {
                let mut changes = [L::ZERO; MAX_GROUP_SWEEPS];
                let groups = [Group::new(passes, &mut changes[..passes.len()])];
                L::run(PipelinedSweeps {
                    shared: &Shared::new(self, &mut work, &groups, shares),
                    number: 0,
                    delay: &|| (),
                });
                let changes = &changes[..passes.len()];
                changes.iter().for_each(|change| tell(change.sum()));
            }
        } else {
            let changes = self.run_in_groups(passes, work, shares, &|| ());
            changes.iter().for_each(|change| tell(change.sum()));
        }
    }

    /// Runs all sweeps on several threads. Returns Σ Wᵢᵢ Δλᵢ² of each, J, in their order.
    fn run_in_groups<L: F32xN>(
        &self,
        passes: &[Pass],
        mut work: Work<L>,
        shares: Shares,
        delay: &(dyn Fn() + Sync),
    ) -> Vec<L> {
        let mut changes = vec![L::ZERO; passes.len()];
        let groups = passes.chunks(shares.group);
        let groups = groups.zip(changes.chunks_mut(shares.group));
        let groups: Vec<_> = groups
            .map(|(passes, changes)| Group::new(passes, changes))
            .collect();
        let shared = Shared::new(self, &mut work, &groups, shares);
        let next = AtomicUsize::new(0);
        let work = || {
            loop {
                let number = next.fetch_add(1, Relaxed);
                if number >= groups.len() {
                    break;
                }
                L::run(PipelinedSweeps {
                    shared: &shared,
                    number,
                    delay,
                });
            }
        };
        on_threads(shares.threads.min(groups.len()), &work);
        drop(groups);
        changes
    }
}

/// Sweeps that follow each other on one thread.
pub(super) struct Group<'a, L> {
    passes: &'a [Pass],
    changes: Handed<'a, L>,
    /// Number of blocks that its last sweep has passed.
    done: AtomicUsize,
}

impl<'a, L> Group<'a, L> {
    fn new(passes: &'a [Pass], changes: &'a mut [L]) -> Self {
        Self {
            passes,
            changes: Handed::new(changes),
            done: AtomicUsize::new(0),
        }
    }
}

pub(super) struct Shared<'a, L: F32xN> {
    pipeline: &'a Pipeline,
    blocks: Handed<'a, Block<L>>,
    points: Handed<'a, Points<L>>,
    velocities: Handed<'a, State>,
    before: Handed<'a, State>,
    motions: Handed<'a, State>,
    grab_places: &'a EdgePlaces,
    grabs: Handed<'a, ActiveGrab>,
    fastest: f32,
    groups: &'a [Group<'a, L>],
    apart: usize,
}

impl<'a, L: F32xN> Shared<'a, L> {
    pub(super) fn new(
        pipeline: &'a Pipeline,
        work: &'a mut Work<L>,
        groups: &'a [Group<'a, L>],
        shares: Shares,
    ) -> Self {
        Self {
            pipeline,
            blocks: Handed::new(work.blocks),
            points: Handed::new(work.points),
            velocities: Handed::new(work.velocities),
            before: Handed::new(work.before),
            motions: Handed::new(work.motions),
            grab_places: work.grab_places,
            grabs: Handed::new(work.grabs),
            fastest: work.fastest,
            groups,
            apart: shares.apart,
        }
    }
}

/// One group, from its first visit to its last.
///
/// Its sweeps access a block, its points, its grabs and its moving bodies only after the sweep before is past the block's reach. So no
/// other thread accesses any of them at that time, nor until this sweep has passed them, which the counter tells the next group.
pub(super) struct PipelinedSweeps<'a, 'b, L: F32xN> {
    pub(super) shared: &'b Shared<'a, L>,
    pub(super) number: usize,
    pub(super) delay: &'b dyn Fn(),
}

/// Ends the wait of other threads if this one panics.
struct Unblock<'a>(&'a AtomicUsize);

impl Drop for Unblock<'_> {
    fn drop(&mut self) {
        self.0.store(usize::MAX, Release);
    }
}

impl<L: F32xN> Kernel for PipelinedSweeps<'_, '_, L> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Shared {
            pipeline, groups, ..
        } = self.shared;
        let group = &groups[self.number];
        let _unblock = Unblock(&group.done);
        let blocks = pipeline.reach.len();
        let passes = group.passes;
        // SAFETY: these items belong to this group, and one thread claims it.
        let changes = unsafe { group.changes.range(0, passes.len()) };
        let mut at = [0usize; MAX_GROUP_SWEEPS];
        let mut idle = 0u32;
        while at[passes.len() - 1] < blocks {
            let past = match self.number.checked_sub(1) {
                Some(before) => self.behind(&groups[before], blocks),
                None => usize::MAX,
            };
            let was = at;
            self.turn(passes, &mut at, changes, past);
            // Release: other threads see the writes of all visits up to here. The guard stores `usize::MAX` at the end.
            group.done.store(at[passes.len() - 1], Release);
            (self.delay)();
            if at != was {
                idle = 0;
            } else if idle < MAX_SPINS {
                idle += 1;
                std::hint::spin_loop();
            } else {
                // The thread that it waits for may have no processor.
                std::thread::yield_now();
            }
        }
    }
}

impl<L: F32xN> Island<L> {
    /// The pipeline of the last step or a new one, if sweeps may follow each other and may be faster then.
    pub fn take_pipeline(&mut self, problem: &PatchProblem) -> Option<Pipeline> {
        let kept = self.pipeline.take();
        let overlaps = is_worthwhile(problem.threads, self.bytes())
            && self.fixed_bodies_rest
            && self.joints.is_empty()
            && self.spinners.is_empty();
        overlaps.then(|| kept.unwrap_or_else(|| self.find_pipeline(problem)))
    }

    pub fn find_pipeline(&self, problem: &PatchProblem) -> Pipeline {
        let places = &self.grab_places.places;
        Pipeline::of(&self.batches, places, problem, self.round_ends.clone())
    }

    /// The size of all blocks and points.
    pub fn bytes(&self) -> usize {
        size_of_val(&*self.blocks) + size_of_val(&*self.points)
    }

    pub fn work(&mut self) -> Work<'_, L> {
        Work {
            blocks: &mut self.blocks,
            points: &mut self.points,
            velocities: &mut self.velocities,
            before: &mut self.before,
            motions: &mut self.motions,
            grab_places: &self.grab_places.places,
            grabs: &mut self.grabs,
            fastest: self.fastest,
        }
    }
}

/// Number of spins before a waiting thread yields the processor.
const MAX_SPINS: u32 = 1000;

/// Upper bound of sweeps in a group.
pub(super) const MAX_GROUP_SWEEPS: usize = 8;

impl<L: F32xN> PipelinedSweeps<'_, '_, L> {
    /// Each sweep visits some more blocks behind the one before it, the first behind whatever has passed so many blocks.
    #[inline(always)]
    pub(super) fn turn(
        &self,
        passes: &[Pass],
        at: &mut [usize; MAX_GROUP_SWEEPS],
        changes: &mut [L],
        mut past: usize,
    ) {
        let pipeline = self.shared.pipeline;
        let blocks = pipeline.reach.len();
        let mut sweep = 0;
        while sweep < passes.len() {
            // A sweep that has ended holds back no block.
            if past == blocks {
                past = usize::MAX;
            }
            let end = (at[sweep] + BLOCKS_AT_A_TIME).min(blocks);
            let mut block = at[sweep];
            let mut change = changes[sweep];
            let pass = &passes[sweep];
            if pass.soft {
                while block < end && (pipeline.reach[block] as usize) < past {
                    change += self.visit::<true>(block, pass);
                    block += 1;
                }
            } else {
                while block < end && (pipeline.reach[block] as usize) < past {
                    change += self.visit::<false>(block, pass);
                    block += 1;
                }
            }
            changes[sweep] = change;
            at[sweep] = block;
            past = block;
            sweep += 1;
        }
    }

    /// The number of blocks that the next group may access. Once this group has ended, that is all of them.
    #[inline(always)]
    fn behind(&self, before: &Group<L>, blocks: usize) -> usize {
        match before.done.load(Acquire) {
            done if done >= blocks => usize::MAX,
            done => done.saturating_sub(self.shared.apart),
        }
    }

    #[inline(always)]
    fn visit<const SOFT: bool>(&self, number: usize, pass: &Pass) -> L {
        let Shared {
            pipeline,
            blocks,
            points,
            velocities,
            before,
            motions,
            grab_places,
            ..
        } = self.shared;
        // SAFETY: see `PipelinedSweeps`.
        let (block, velocities, motions, before) = unsafe {
            let block = &mut blocks.range(number, number + 1)[0];
            (block, velocities.cells(), motions.cells(), before.cells())
        };
        let held = match grab_places.is_empty() {
            true => 0.0,
            false => self.visit_grabs(number),
        };
        let range = block.range();
        // SAFETY: see `PipelinedSweeps`; no other block has these points.
        let points = unsafe { points.range(range.start, range.end) };
        let mut change = match SOFT {
            true => {
                let kinds = Soft { first: pass.first };
                block.relax(kinds, points, velocities, motions, pass)
            }
            false => block.relax(Rigid, points, velocities, motions, pass),
        };
        pipeline.round_ends.after(number, velocities);
        let first = match number {
            0 => 0,
            _ => pipeline.ends[number - 1] as usize,
        };
        let mut i = first;
        while i < pipeline.ends[number] as usize {
            let body = pipeline.bodies[i] as usize;
            pass.end(&velocities[body], &before[body], &motions[body]);
            i += 1;
        }
        if held != 0.0 {
            change[0] += held;
        }
        change
    }

    /// Visits the grabs that stand before a block. Returns Σ W Δλ², J.
    #[inline(never)]
    fn visit_grabs(&self, block: usize) -> f32 {
        let Shared {
            velocities,
            motions,
            grab_places,
            grabs,
            fastest,
            ..
        } = self.shared;
        // SAFETY: see `PipelinedSweeps`: the block holds all bodies that its grabs read or change.
        let (velocities, motions) = unsafe { (velocities.cells(), motions.cells()) };
        let mut change = 0.0;
        for group in grab_places.before(block) {
            for &grab in grab_places.edges_of(group) {
                let grab = grab as usize;
                // SAFETY: see `PipelinedSweeps`; no other block has this grab.
                let held = unsafe { &mut grabs.range(grab, grab + 1)[0] };
                change += held.visit_among(velocities, motions, *fastest);
            }
        }
        change
    }
}

#[cfg(test)]
mod tests;
