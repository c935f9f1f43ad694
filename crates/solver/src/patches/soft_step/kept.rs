//! The state that Soft Step keeps of an island from step to step.

use super::blows::Blows;
use super::contact::pass::Pass;
use super::island::Island;
use super::sweeps::budget::Course;
use super::sweeps::layout::{batches, fixed_bodies_rest, rounds, skewed};
use super::sweeps::load_statistics::BodyLoad;
use super::sweeps::skewed::SkewedSweeps;
use super::sweeps::{Changes, Mode};
use crate::batches::Batches;
use crate::lanes::F32xN;
use crate::{Lanes, PatchProblem};

/// An island in blocks, with the data that is found once for them.
pub struct Kept<L: F32xN> {
    pub island: Island<L>,
    layout: Layout,
    /// Present if blocks are skewed.
    skewed: Option<SkewedSweeps>,
    pub blows: Blows<L>,
    pub scratch: Scratch,
}

/// Why the blocks of an island are as they are.
enum Layout {
    /// They are skewed or have rounds, where that pays.
    Best,
    /// They are plain, for a step whose mode asked for that.
    PlainForMode,
    /// They are plain, because segments are too short for the grabs on these bodies.
    PlainForGrabs(Vec<u32>),
}

/// Lists of one call, whose memory is reused.
#[derive(Default)]
pub struct Scratch {
    pub body_loads: Vec<BodyLoad>,
    pub courses: Vec<Course>,
    pub passes: Vec<Pass>,
}

impl<L: F32xN> Kept<L> {
    /// The state of the last step if it is still valid; else a new one. Blocks are skewed or have rounds only where sweeps may overlap.
    pub fn of(
        kept: Option<Box<Self>>,
        problem: &PatchProblem,
        lanes: Lanes,
        found: Option<Batches>,
        mode: Mode,
    ) -> Box<Self> {
        let rest = fixed_bodies_rest(problem);
        let valid = kept.filter(|kept| {
            kept.island.fastest == problem.max_correction_speed
                && kept.island.fixed_bodies_rest == rest
                && kept.suits(problem, mode)
        });
        let mut kept = valid.unwrap_or_else(|| Box::new(Self::laid_out(problem, found, mode)));
        kept.island.place_grabs(problem);
        if kept.island.batches.segments() > 1 && !kept.island.grab_places.fit_segments() {
            *kept = Self::new(Island::new(problem, batches(L::LANES, problem)));
            kept.layout = Layout::PlainForGrabs(held(problem).collect());
            kept.island.place_grabs(problem);
        }
        kept.island.lanes = lanes;
        kept
    }

    /// Whether its blocks are those that a problem would get.
    fn suits(&self, problem: &PatchProblem, mode: Mode) -> bool {
        let batches = &self.island.batches;
        if mode != Mode::Overlapping {
            return batches.segments() == 1 && !batches.has_rounds();
        }
        let is_best = match &self.layout {
            Layout::Best => true,
            Layout::PlainForMode => false,
            Layout::PlainForGrabs(bodies) => bodies.iter().copied().eq(held(problem)),
        };
        // A body with a new mass has new patches.
        is_best
            && (self.island.loaded == problem.memory.patches()
                || *batches.rounds() == rounds(problem))
    }

    /// New blocks for a problem; those that were `found`, if it needs no plain ones.
    fn laid_out(problem: &PatchProblem, found: Option<Batches>, mode: Mode) -> Self {
        if mode == Mode::Overlapping {
            let batches = found.unwrap_or_else(|| skewed(L::LANES, problem));
            return Self::new(Island::new(problem, batches));
        }
        let mut kept = Self::new(Island::new(problem, batches(L::LANES, problem)));
        if kept.island.fixed_bodies_rest || !rounds(problem).is_empty() {
            kept.layout = Layout::PlainForMode;
        }
        kept
    }

    pub fn new(island: Island<L>) -> Self {
        Self {
            island,
            layout: Layout::Best,
            skewed: None,
            blows: Blows::default(),
            scratch: Scratch::default(),
        }
    }

    /// Runs the sweeps of a step after those that are `done`: the first round, and the others if the island is not
    /// [quiet](super::sweeps::quiet) after it. The others are divided among `threads`.
    pub fn sweep(
        &mut self,
        problem: &mut PatchProblem,
        (first, others): (&[Pass], &[Pass]),
        (done, threads): (Changes, usize),
        mode: Mode,
        tell: &mut dyn FnMut(f32),
    ) {
        if mode == Mode::Blows {
            self.island
                .sweep_through_blows(&mut self.blows, problem, first, tell);
            return;
        }
        let first = &first[done.len()..];
        done.into_iter().for_each(&mut *tell);
        self.sweep_all(problem, first, tell);
        if others.is_empty() {
            return;
        }
        match self
            .island
            .are_almost_still(0..problem.bodies.len(), problem)
        {
            true => self.island.skip(others),
            false => {
                problem.threads = threads;
                self.sweep_all(problem, others, tell);
            }
        }
    }

    /// Runs sweeps. Each goes over the blocks from the first to the last, in the order in which bodies were spawned, from the ground up;
    /// back and forth shook stacks and pyramids. Calls `tell` with Σ Wᵢᵢ Δλᵢ² of each, J.
    fn sweep_all(&mut self, problem: &PatchProblem, passes: &[Pass], tell: &mut dyn FnMut(f32)) {
        match self.island.batches.segments() {
            1 => self.island.sweep(problem, passes, tell),
            _ => {
                let batches = &self.island.batches;
                let skewed = self
                    .skewed
                    .get_or_insert_with(|| SkewedSweeps::new(batches, problem));
                self.island.sweep_skewed(skewed, passes, tell);
            }
        }
    }
}

/// The bodies that grabs hold.
fn held(problem: &PatchProblem) -> impl Iterator<Item = u32> {
    problem.grabs.iter().map(|grab| grab.body)
}

#[cfg(test)]
mod tests;
