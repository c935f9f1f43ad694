//! Quiet islands: once nothing moves any more, the sweeps that are left of a step are skipped.
//!
//! A structure at rest begins a step with the impulses that hold it. A round of sweeps (soft ones, and the rigid one that follows them)
//! finds the same impulses again, and so does every other round. An island is *quiet* if its bodies were almost still before the step, are
//! so after the first round, and would be so in the next substep ([`ALMOST_STILL_FACTOR`]). Then the substeps that are left are skipped:
//! contacts give the same impulses in them, and bodies stay where they were before the step.
//!
//! Arches and houses of cards would never come quite to rest. Their poses are rounded by more than springs stretch, so what springs correct
//! in one step, rounding undoes. If their bodies moved, by the first round alone or by the last velocity for the rest of the step, they
//! would tremble by some µm/s, and everything that watches their `Transform` would see a change in every step. Their velocities are kept,
//! so a body that is out of balance gets faster until the island is no longer quiet.
//!
//! A wall of 40 × 25 bricks at rest takes 0.87 ms a step, and 1.52 ms without this.
//!
//! Only worlds without sleeping use this ([`PatchProblem::stays_awake`]): elsewhere such an island sleeps after half a second. Until then
//! it gets all sweeps, because the forces with which it falls asleep decide when it wakes. With one round, the same structure fell asleep
//! with other forces, and a wall of 20 × 20 whose foot is taken fell at the 17th brick by need and at the 11th awake.
//!
//! Whether an island is quiet follows from its problem alone. The rate of sweeps, and with it the stiffness of springs, does not depend on
//! it.

use super::layout::fixed_bodies_rest;
use crate::Both;
use crate::lanes::{F32xN, State};
use crate::patches::soft_step::contact::pass::Pass;
use crate::patches::soft_step::island::Island;
use crate::{Body, PatchProblem};
use std::ops::Range;

/// Number of sweeps after which an island may be quiet: the first soft sweeps, and the rigid sweep after them. With an `effort` that is
/// larger than usual it is as many rounds.
pub fn first_round(passes: &[Pass], effort: f32) -> usize {
    let mut rigid = (0..passes.len()).filter(|&i| !passes[i].soft);
    let last = rigid.nth((effort.ceil() as usize).saturating_sub(1));
    last.map_or(passes.len(), |rigid| rigid + 1)
}

/// A body is almost still below this many times the speed at which it counts as [still](Body::still_below). At 4, arches are not quiet. At
/// 16, a stack of 20 that was placed with noise drifts twice as far in a minute.
const ALMOST_STILL_FACTOR: f32 = 8.0;

/// Whether an island may be quiet in this step. If some contacts may bounce it needs all sweeps: a brick with e = 0.6 that bounces on a
/// wall at 0.1 s moved it by 2.3 mm instead of less than 1. Otherwise: it never sleeps, only contacts act on its bodies, and these were
/// almost still before the step.
pub fn may_be_quiet(problem: &PatchProblem, bounces: bool) -> bool {
    let start = |body: &Body| body.start.both(|velocity| velocity.extend(0.0));
    problem.stays_awake
        && !bounces
        && !problem.patches.is_empty()
        && problem.has_only_contacts()
        && fixed_bodies_rest(problem)
        && problem
            .bodies
            .iter()
            .all(|body| is_almost_still(body, start(body)))
}

/// Returns true if a body with this velocity is almost still. A body that contacts cannot change is so if it stands.
fn is_almost_still(body: &Body, [linear, angular]: State) -> bool {
    let [speed, spin] = body.still_below.both(|limit| ALMOST_STILL_FACTOR * limit);
    linear.length_squared() <= speed * speed && angular.length_squared() <= spin * spin
}

impl<L: F32xN> Island<L> {
    /// Returns true if some bodies are almost still after a pass that [extrapolates](Pass::extrapolates), and will be so in the next
    /// substep.
    pub fn are_almost_still(&self, bodies: Range<usize>, problem: &PatchProblem) -> bool {
        bodies.into_iter().all(|i| {
            let states = [self.before[i], self.velocities[i]];
            states
                .into_iter()
                .all(|state| is_almost_still(&problem.bodies[i], state))
        })
    }

    /// Ends the step of a quiet island without these sweeps. Its bodies do not move.
    pub fn skip(&mut self, passes: &[Pass]) {
        self.skipped = passes.iter().filter(|pass| pass.soft).count();
        self.velocities.clone_from(&self.before);
        self.motions.fill(State::default());
    }
}
