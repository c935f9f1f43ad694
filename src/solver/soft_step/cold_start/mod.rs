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
const PUT: f32 = 0.25;

/// Sweeps to and fro in which a structure is brought to rest, at most, for each of its courses.
const SWEEPS_PER_COURSE: usize = 50;

/// Which bodies stand on something and carry nothing yet.
struct New {
    bodies: Vec<bool>,
    /// They are most, and nothing else moves: it was built as a whole.
    all: bool,
}

impl New {
    /// None in most steps, which this finds in one pass over the points.
    fn find(problem: &Problem, closed: f32) -> Option<Self> {
        let fall = problem.gravity.length() * problem.dt;
        let slow = |body: &Body| body.start[0].length_squared() <= fall * fall;
        let mut carries = vec![false; problem.bodies.len()];
        let mut touches = false;
        for patch in problem.patches.iter() {
            let points = &problem.points[patch.range()];
            let old = points.iter().any(|p| p.impulse > 0.0 || p.load > 0.0);
            for body in patch.bodies {
                carries[body as usize] |= old;
            }
            touches |= !old && points.iter().any(|p| p.separation <= closed);
        }
        if !touches {
            return None;
        }
        let stands = hand_down::standing(problem, closed);
        let put = fall.min(PUT);
        let mut bodies = vec![false; problem.bodies.len()];
        let (mut new, mut old) = (0, 0);
        for (i, body) in problem.bodies.iter().enumerate() {
            if body.inverse_mass > 0.0 {
                bodies[i] = stands[i] && !carries[i] && body.start[0].length() <= put;
                if bodies[i] { new += 1 } else { old += 1 }
            }
        }
        let all = new > old && problem.bodies.iter().all(slow);
        (new > 0).then_some(Self { bodies, all })
    }
}

/// Gives contacts that carry nothing yet the load they will carry, as impulses and as what they carry at rest.
pub fn cold_start(problem: &mut Problem) {
    // What falls from rest gets so far in a step, m.
    let closed = 0.5 * problem.gravity.length() * problem.dt * problem.dt;
    let Some(new) = New::find(problem, closed) else {
        return;
    };
    let courses = hand_down::hand_down(problem, closed, &new.bodies);
    if new.all {
        statics::settle(problem, closed, SWEEPS_PER_COURSE * courses);
    }
}
