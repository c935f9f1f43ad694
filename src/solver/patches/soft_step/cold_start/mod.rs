//! What contacts carry that have carried nothing yet, of a structure that was just built or of a brick that was put on one.
//!
//! Without impulses to start from, sweeps need a number that grows with the height squared to find the load at the foot of a
//! tower, and where joints carry moments with a higher power of it; until then it sinks and leans. So loads are [handed
//! down](hand_down). What was built as a whole, and is not in balance with them, carries instead what [weight that grows](grow) would
//! make: statics alone would let it lean on a squeeze that nobody made. If that holds it, it is [brought to rest](statics): impulses
//! that keep it still are what it carries at rest, and so they are held. What lies on something and vanishes is handed down in the same
//! way as what is new, or what bore it would be thrown.

mod grow;
mod hand_down;
mod statics;

use super::load_statistics::BodyLoad;
use crate::solver::lanes::F32xN;
use crate::solver::{Body, PatchProblem};
use grow::Grown;

/// What is faster than this has not been put there, but thrown, m/s.
const PUT: f32 = 0.01;

/// What is faster than this is not at rest, m/s: the parts of a pile take up their loads and leave them as they come.
const RESTS: f32 = 0.001;

/// What is built is put where it will rest to so much at least, m.
const PLACED: f32 = 0.005;

/// Sweeps to and fro in which a structure is brought to rest, at most, for each of its courses.
const SWEEPS_PER_COURSE: usize = 150;

/// And so many visits to patches: no step of a large structure that never comes to rest may take seconds.
const PATCH_VISITS: usize = 1_000_000;

/// Which bodies stand on something and carry nothing yet, or still carry what is gone.
struct New {
    bodies: Vec<bool>,
    /// They are most, and nothing else moves: it was built as a whole.
    all: bool,
}

impl New {
    /// None in most steps, which one pass over the points finds.
    fn find(problem: &PatchProblem, closed: f32, body_loads: &[BodyLoad]) -> Option<Self> {
        let fall = problem.gravity.length() * problem.dt;
        let slower = |body: &Body, most: f32| body.start[0].length_squared() <= most * most;
        let moves = |body: &&Body| body.inverse_mass > 0.0;
        let pairs = || {
            problem
                .bodies
                .iter()
                .zip(body_loads)
                .filter(|(body, _)| moves(body))
        };
        let unloaded =
            |(body, body_loads): &(&Body, &BodyLoad)| body_loads.is_unloaded(body, problem);
        if pairs().all(|(_, body_loads)| body_loads.carries) && !pairs().any(|pair| unloaded(&pair))
        {
            return None;
        }
        let stands = hand_down::standing(problem, closed);
        let bodies = problem.bodies.iter().zip(body_loads).zip(stands);
        let bodies: Vec<[bool; 2]> = bodies
            .map(|((body, body_loads), stands)| {
                let still = moves(&body) && stands && slower(body, PUT);
                [
                    still && !body_loads.carries,
                    slower(body, RESTS) && still && unloaded(&(body, body_loads)),
                ]
            })
            .collect();
        let new = bodies.iter().filter(|[new, _]| *new).count();
        let moved = problem.bodies.iter().filter(moves);
        let all = 2 * new > moved.count() && problem.bodies.iter().all(|body| slower(body, fall));
        let bodies: Vec<bool> = bodies
            .into_iter()
            .map(|[new, unloaded]| new || unloaded)
            .collect();
        bodies.contains(&true).then_some(Self { bodies, all })
    }
}

/// Gives contacts that carry nothing yet the load they will carry, as impulses and as what they carry at rest. True where there were any.
pub fn cold_start<L: F32xN>(problem: &mut PatchProblem, body_loads: &[BodyLoad]) -> bool {
    // What falls from rest gets so far in a step.
    let fallen = 0.5 * problem.gravity.length() * problem.dt * problem.dt;
    let closed = fallen.max(PLACED);
    let Some(new) = New::find(problem, closed, body_loads) else {
        return false;
    };
    let courses = hand_down::hand_down(problem, closed, &new.bodies);
    if new.all {
        let grown = match hand_down::is_balanced(problem) {
            true => Grown::Rest,
            false => grow::grow::<L>(problem, closed),
        };
        if grown != Grown::Go {
            let most = PATCH_VISITS / problem.patches.len().max(1);
            statics::settle::<L>(problem, closed, most.min(SWEEPS_PER_COURSE * courses));
        }
    }
    true
}

#[cfg(test)]
mod tests;
