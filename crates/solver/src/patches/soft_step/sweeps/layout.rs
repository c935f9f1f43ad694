//! The layout of contacts in blocks, and the width of the lanes.

#[cfg(target_arch = "x86_64")]
use crate::Lanes;
use crate::PatchProblem;
use crate::batches::Batches;
#[cfg(target_arch = "x86_64")]
use crate::lanes::{F32x4, F32x8, F32xN};
use crate::patches::soft_step::SoftStep;
#[cfg(target_arch = "x86_64")]
use crate::patches::soft_step::kept::Kept;
use crate::rounds::Rounds;
use crate::width::Width;
use glam::Vec3;

/// The blocks of a problem, not skewed and without rounds.
pub fn batches(lanes: usize, problem: &PatchProblem) -> Batches {
    let patches = problem.patches.iter().map(|patch| patch.bodies);
    Batches::of(lanes, patches, problem.bodies)
}

/// The blocks of a problem: skewed if sweeps may overlap and skewing pays, else in rounds.
pub fn skewed(lanes: usize, problem: &PatchProblem) -> Batches {
    let patches = problem.patches.iter().map(|patch| patch.bodies);
    match fixed_bodies_rest(problem) {
        true => Batches::skewed(lanes, patches, problem.bodies),
        false => Batches::in_rounds(lanes, patches, problem.bodies),
    }
}

pub fn rounds(problem: &PatchProblem) -> Rounds {
    let patches = problem.patches.iter().map(|patch| patch.bodies);
    Rounds::of(patches, problem.bodies)
}

/// Whether bodies that contacts cannot change stand still. Sweeps may overlap only then.
pub fn fixed_bodies_rest(problem: &PatchProblem) -> bool {
    problem.bodies.iter().all(|body| {
        body.inverse_mass > 0.0 || body.start == [Vec3::ZERO; 2] && body.push() == [Vec3::ZERO; 2]
    })
}

impl SoftStep {
    /// The width for a problem: that of the last step if the patches are the same. If it becomes eight, `found` gets the blocks that were
    /// computed for the decision.
    #[cfg(target_arch = "x86_64")]
    pub(crate) fn width(&self, problem: &PatchProblem, found: &mut Option<Batches>) -> Width {
        self.lanes.width(|| {
            was_auto::<F32x8>(problem) || !was_auto::<F32x4>(problem) && fills_eight(problem, found)
        })
    }

    /// The width for a problem.
    #[cfg(not(target_arch = "x86_64"))]
    pub(crate) fn width(&self, _: &PatchProblem, _: &mut Option<Batches>) -> Width {
        Width::Four
    }
}

/// Whether [`Lanes::Auto`] chose this width in the last step, and the reason still holds.
#[cfg(target_arch = "x86_64")]
fn was_auto<L: F32xN>(problem: &PatchProblem) -> bool {
    let kept = problem.memory.peek::<Kept<L>>();
    kept.is_some_and(|Kept { island, .. }| {
        island.lanes == Lanes::Auto && island.fixed_bodies_rest == fixed_bodies_rest(problem)
    })
}

/// Whether blocks of eight are faster. A visit to a block of eight costs 1.1 times one of four.
#[cfg(target_arch = "x86_64")]
fn fills_eight(problem: &PatchProblem, found: &mut Option<Batches>) -> bool {
    if problem.joints.len() >= MANY_JOINTS.max(problem.patches.len()) {
        return true;
    }
    if problem.patches.len() < WELL_FILLED {
        return false;
    }
    found
        .insert(skewed(F32x8::LANES, problem))
        .holds(WELL_FILLED)
}

/// Mean number of patches in a block of eight from which on it is faster: skewed, those of a wall of 10 × 10 hold 7, those of an arch 5.
#[cfg(target_arch = "x86_64")]
const WELL_FILLED: usize = 4;

/// Number of joints that fill blocks of eight.
#[cfg(target_arch = "x86_64")]
const MANY_JOINTS: usize = 64;

#[cfg(test)]
mod tests;
