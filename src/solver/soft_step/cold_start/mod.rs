//! What contacts carry that have carried nothing yet, of a structure that was just built or of a brick that was put on one.
//!
//! Without impulses to start from, sweeps need a number that grows with the height squared to find the load at the foot of a
//! tower, and where joints carry moments with a higher power of it; until then it sinks and leans. So loads are [handed
//! down](hand_down), and what was built as a whole is then [brought to rest](statics): impulses that keep it still are what it carries
//! at rest, and so they are held.

mod hand_down;
mod statics;

use crate::solver::{Body, Problem};

/// What is faster than this has not been put there, but thrown, m/s.
const PUT: f32 = 0.01;

/// What is built is put where it will rest to so much at least, m.
const PLACED: f32 = 0.005;

/// Sweeps to and fro in which a structure is brought to rest, at most, for each of its courses.
const SWEEPS_PER_COURSE: usize = 150;

/// And so many visits to patches: no step of a large structure that never comes to rest may take seconds.
const PATCH_VISITS: usize = 1_000_000;

/// Which bodies stand on something and carry nothing yet.
struct New {
    bodies: Vec<bool>,
    /// They are most, and nothing else moves: it was built as a whole.
    all: bool,
}

impl New {
    /// None in most steps, which one pass over the points finds.
    fn find(problem: &Problem, closed: f32) -> Option<Self> {
        let mut carries = vec![false; problem.bodies.len()];
        for patch in problem.patches.iter() {
            let points = &problem.points[patch.range()];
            let old = points.iter().any(|p| p.impulse > 0.0 || p.load > 0.0);
            for body in patch.bodies {
                carries[body as usize] |= old;
            }
        }
        let mut bodies = problem.bodies.iter().zip(&carries);
        if bodies.all(|(body, &carries)| carries || body.inverse_mass == 0.0) {
            return None;
        }
        let fall = problem.gravity.length() * problem.dt;
        let slower = |body: &Body, most: f32| body.start[0].length_squared() <= most * most;
        let stands = hand_down::standing(problem, closed);
        let bodies = problem.bodies.iter().zip(carries).zip(stands);
        let is_new = |((body, carries), stands): ((&Body, bool), bool)| {
            body.inverse_mass > 0.0 && stands && !carries && slower(body, PUT)
        };
        let bodies: Vec<bool> = bodies.map(is_new).collect();
        let new = bodies.iter().filter(|new| **new).count();
        let moved = problem.bodies.iter().filter(|body| body.inverse_mass > 0.0);
        let all = 2 * new > moved.count() && problem.bodies.iter().all(|body| slower(body, fall));
        (new > 0).then_some(Self { bodies, all })
    }
}

/// Gives contacts that carry nothing yet the load they will carry, as impulses and as what they carry at rest.
pub fn cold_start(problem: &mut Problem) {
    // What falls from rest gets so far in a step.
    let fallen = 0.5 * problem.gravity.length() * problem.dt * problem.dt;
    let closed = fallen.max(PLACED);
    let Some(new) = New::find(problem, closed) else {
        return;
    };
    let courses = hand_down::hand_down(problem, closed, &new.bodies);
    if new.all {
        let most = PATCH_VISITS / problem.patches.len().max(1);
        statics::settle(problem, closed, most.min(SWEEPS_PER_COURSE * courses));
    }
}

#[cfg(test)]
mod tests;
