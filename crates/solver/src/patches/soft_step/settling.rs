//! Settling: a tall structure that was hit and sways loses speed, so that it comes to rest.
//!
//! The contacts of a wall are springs whose damping grows with the frequency: ζ is 10 at some 100 Hz. So a sway with a period of five
//! seconds loses 6 to 12 % of its amplitude in a period. A wall of 40 × 25 through which a heavy ball has flown swayed by 15 mm for ten
//! seconds, and fell asleep where it happened to turn, out of balance. Real joints lose more, by friction within them and by impacts. So a
//! slow body loses speed at a constant rate. That is the mass-proportional damping of distinct-element models of masonry, and damps slow
//! motion more than fast.
//!
//! The loss vanishes with the speed, so it holds nothing up. It is limited to what sways:
//! - Only worlds with sleeping have it ([`PatchProblem::settling`]).
//! - A body must stand in flat contacts that stick ([`BodyLoad::stands`]). What rolls, slides, tips or flies is not slowed down.
//! - The island must be tall, and stand on something that does not move. It has no joints, grabs or moving surfaces.
//! - All of its bodies must be slow, and some faster than at rest.

use super::sweeps::load_statistics::BodyLoad;
use crate::Both;
use crate::patches::SMALL_ISLAND_PATCHES;
use crate::{Body, PatchProblem, Settling};
use glam::Vec3;

/// Number of awake courses from which on a structure settles. Lower ones sway faster, so springs damp them. Parts of a pile that creep
/// apart must not be stopped while they overlap.
const TALL_COURSES: u32 = 12;

/// Islands that are solved [together](super::together) are too small to settle.
const _: () = assert!(SMALL_ISLAND_PATCHES <= TALL_COURSES as usize);

/// A structure is at rest if its fastest body is slower than this share of [`Settling::below`]. It may tremble, but does not sway.
const REST_SPEED_SHARE: f32 = 0.01;

/// Takes speed from the bodies of a problem that was solved, if it sways. `body_loads` are those from before the solve.
pub fn damp(problem: &mut PatchProblem, body_loads: &[BodyLoad]) {
    let Some(settling) = problem.settling else {
        return;
    };
    if !settling.applies(problem, body_loads) {
        return;
    }
    for (body, load) in problem.bodies.iter_mut().zip(body_loads) {
        if body.inverse_mass > 0.0 && load.stands() {
            let lost = settling.rate * problem.dt * (1.0 - settling.square_speed(body));
            let kept = (1.0 - lost).max(0.0);
            body.linear *= kept;
            body.angular *= kept;
        }
    }
}

impl Settling {
    /// Whether the problem is a tall structure that sways slowly on something that does not move.
    fn applies(&self, problem: &PatchProblem, body_loads: &[BodyLoad]) -> bool {
        if problem.patches.len() < TALL_COURSES as usize || !problem.has_only_contacts() {
            return false;
        }
        let (mut lowest, mut highest) = (u32::MAX, 0);
        let (mut fastest, mut standing) = (0f32, 0.0);
        for (body, load) in problem.bodies.iter().zip(body_loads) {
            if body.inverse_mass > 0.0 {
                (lowest, highest) = (lowest.min(body.level), highest.max(body.level));
                fastest = fastest.max(self.square_speed(body));
            } else if [body.linear, body.angular] == [Vec3::ZERO; 2] {
                standing += load.standing;
            } else {
                return false;
            }
        }
        lowest.saturating_add(TALL_COURSES) <= highest + 1
            && standing > 0.0
            && (REST_SPEED_SHARE * REST_SPEED_SHARE..1.0).contains(&fastest)
    }

    /// The square of the speed of a body, as a share of [`Self::below`].
    fn square_speed(&self, body: &Body) -> f32 {
        let squares = [body.linear, body.angular].both(Vec3::length_squared);
        let [linear, angular] = self.below.both(|limit| limit * limit);
        (squares[0] / linear).max(squares[1] / angular)
    }
}
