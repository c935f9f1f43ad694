//! What contacts carry that have carried nothing yet, of a structure that was just built or of a brick that was put on one.
//!
//! Without impulses to start from, sweeps need a number that grows with the height squared to find the load at the foot of a
//! tower, and where joints carry moments with a higher power of it; until then it sinks and leans. So loads are [handed
//! down](hand_down), and what was built as a whole is then [brought to rest](statics): impulses that keep it still are what it carries
//! at rest, and so they are held. What lies on something and vanishes is handed down in the same way, or what bore it would be thrown.

mod hand_down;
mod statics;

use crate::solver::lanes::F32xN;
use crate::solver::{Body, PatchProblem};

/// What is faster than this has not been put there, but thrown, m/s.
const PUT: f32 = 0.01;

/// What is faster than this is not at rest, m/s: the parts of a pile take up their loads and leave them as they come.
const RESTS: f32 = 0.001;

/// What is built is put where it will rest to so much at least, m.
const PLACED: f32 = 0.005;

/// Sweeps to and fro in which a structure is brought to rest, at most, for each of its courses.
const SWEEPS_PER_COURSE: usize = 150;

/// What bears so many times what a body is pressed down with still bears what is gone.
const UNLOADED: f32 = 2.0;

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
    fn find(problem: &PatchProblem, closed: f32, footing: &mut Vec<Footing>) -> Option<Self> {
        Footing::find(problem, footing);
        let footing = &*footing;
        let fall = problem.gravity.length() * problem.dt;
        let slower = |body: &Body, most: f32| body.start[0].length_squared() <= most * most;
        let moves = |body: &&Body| body.inverse_mass > 0.0;
        let pairs = || {
            problem
                .bodies
                .iter()
                .zip(footing)
                .filter(|(body, _)| moves(body))
        };
        let unloaded = |(body, footing): &(&Body, &Footing)| footing.is_unloaded(body, problem);
        if pairs().all(|(_, footing)| footing.carries) && !pairs().any(|pair| unloaded(&pair)) {
            return None;
        }
        let stands = hand_down::standing(problem, closed);
        let bodies = problem.bodies.iter().zip(footing).zip(stands);
        let bodies: Vec<[bool; 2]> = bodies
            .map(|((body, footing), stands)| {
                let still = moves(&body) && stands && slower(body, PUT);
                [
                    still && !footing.carries,
                    slower(body, RESTS) && still && unloaded(&(body, footing)),
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

/// What holds a body as the step begins.
#[derive(Clone, Copy, Default)]
pub struct Footing {
    /// Something has pushed on it before.
    carries: bool,
    /// What has long pushed on it upwards, and downwards, or does so now, N·s: what is round holds no load, and yet weighs.
    up: f32,
    down: f32,
}

impl Footing {
    /// Of all bodies.
    fn find(problem: &PatchProblem, all: &mut Vec<Self>) {
        let up = -problem.gravity.normalize_or_zero();
        all.clear();
        all.resize(problem.bodies.len(), Self::default());
        for patch in problem.patches.iter() {
            let (mut load, mut impulse) = (0.0, 0.0);
            for point in &problem.points[patch.range()] {
                load += point.load;
                impulse += point.warm_normal;
            }
            let carries = load.max(impulse) > 0.0;
            let long = up.dot(patch.normal * load + patch.load_tangential);
            let now = up.dot(patch.normal * impulse + patch.warm_tangential);
            for (body, sign) in patch.bodies.into_iter().zip([1.0, -1.0]) {
                let (long, now) = (sign * long, sign * now);
                let footing = &mut all[body as usize];
                footing.carries |= carries;
                footing.up += long.max(0.0);
                footing.down -= long.min(now).min(0.0);
            }
        }
    }

    /// What lay on it is gone, and what bore that would throw it.
    fn is_unloaded(&self, body: &Body, problem: &PatchProblem) -> bool {
        let weight = problem.gravity.length() * problem.dt / body.inverse_mass;
        self.up > UNLOADED * (self.down + weight)
    }
}

/// Gives contacts that carry nothing yet the load they will carry, as impulses and as what they carry at rest.
pub fn cold_start<L: F32xN>(problem: &mut PatchProblem, footing: &mut Vec<Footing>) {
    // What falls from rest gets so far in a step.
    let fallen = 0.5 * problem.gravity.length() * problem.dt * problem.dt;
    let closed = fallen.max(PLACED);
    let Some(new) = New::find(problem, closed, footing) else {
        return;
    };
    let courses = hand_down::hand_down(problem, closed, &new.bodies);
    if new.all {
        let most = PATCH_VISITS / problem.patches.len().max(1);
        statics::settle::<L>(problem, closed, most.min(SWEEPS_PER_COURSE * courses));
    }
}

#[cfg(test)]
mod tests;
