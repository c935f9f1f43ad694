//! The state that Soft Step keeps of an island from step to step.

use super::blows::Blows;
use super::contact::block::Pass;
use super::island::{Island, batches, rounds, skewed, stands_by_itself};
use super::sweeps::budget::Course;
use super::sweeps::load_statistics::BodyLoad;
use super::sweeps::skewed::SkewedSweeps;
use crate::batches::Batches;
use crate::lanes::F32xN;
use crate::{Lanes, PatchProblem};

/// An island in blocks, with the data that is found once for them.
pub struct Kept<L: F32xN> {
    pub island: Island<L>,
    /// The blocks are not skewed and have no rounds, though another step might use both.
    straight: bool,
    /// The bodies whose grabs are the reason for that.
    straight_for: Vec<u32>,
    /// Present if blocks are skewed.
    skewed: Option<SkewedSweeps>,
    pub blows: Blows<L>,
    pub scratch: Scratch,
}

/// Lists of one call, whose memory is reused.
#[derive(Default)]
pub struct Scratch {
    pub body_loads: Vec<BodyLoad>,
    pub courses: Vec<Course>,
    pub passes: Vec<Pass>,
}

impl<L: F32xN> Kept<L> {
    /// The state of the last step if it is still valid; else a new one. `straight` asks for blocks that are not skewed and have no rounds,
    /// for steps in which a visit or a sweep must end before the next begins.
    pub fn of(
        kept: Option<Box<Self>>,
        problem: &PatchProblem,
        lanes: Lanes,
        found: Option<Batches>,
        straight: bool,
    ) -> Box<Self> {
        let alone = stands_by_itself(problem);
        let held = || problem.grabs.iter().map(|grab| grab.body);
        let may_be = |kept: &Self| {
            let batches = &kept.island.batches;
            match straight {
                true => batches.laps() == 1 && !batches.has_rounds(),
                // A body with a new mass has new patches.
                false => {
                    let for_grabs = || kept.straight_for.iter().copied();
                    (!kept.straight || !kept.straight_for.is_empty() && for_grabs().eq(held()))
                        && (kept.island.loaded == problem.memory.patches()
                            || *batches.rounds() == rounds(problem))
                }
            }
        };
        let mut kept = kept
            .filter(|kept| {
                kept.island.fastest == problem.max_correction_speed
                    && kept.island.alone == alone
                    && may_be(kept)
            })
            .unwrap_or_else(|| {
                let batches = match straight {
                    true => batches(L::LANES, problem),
                    false => found.unwrap_or_else(|| skewed(L::LANES, problem)),
                };
                let mut kept = Self::new(Island::new(problem, batches));
                kept.straight = straight && (alone || !rounds(problem).is_empty());
                Box::new(kept)
            });
        kept.island.place_grabs(problem);
        if kept.island.batches.laps() > 1 && !kept.island.grab_places.fit_laps() {
            let batches = batches(L::LANES, problem);
            *kept = Self::new(Island::new(problem, batches));
            kept.straight = true;
            kept.straight_for = held().collect();
            kept.island.place_grabs(problem);
        }
        kept.island.lanes = lanes;
        kept
    }

    pub fn new(island: Island<L>) -> Self {
        Self {
            island,
            straight: false,
            straight_for: Vec::new(),
            skewed: None,
            blows: Blows::default(),
            scratch: Scratch::default(),
        }
    }

    /// Runs the `first` sweeps, and the `others` if the island is not [quiet](super::sweeps::quiet) after these. The others are divided
    /// among `threads`.
    pub fn sweep_if_needed(
        &mut self,
        problem: &mut PatchProblem,
        [first, others]: [&[Pass]; 2],
        threads: usize,
        tell: &mut dyn FnMut(f32),
    ) {
        self.sweep(problem, first, tell);
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
                self.sweep(problem, others, tell);
            }
        }
    }

    /// Runs sweeps. Each goes over the blocks from the first to the last, in the order in which bodies were spawned, from the ground up;
    /// back and forth shook stacks and pyramids. Calls `tell` with Σ Wᵢᵢ Δλᵢ² of each, J.
    pub fn sweep(&mut self, problem: &PatchProblem, passes: &[Pass], tell: &mut dyn FnMut(f32)) {
        match self.island.batches.laps() {
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

#[cfg(test)]
mod tests;
