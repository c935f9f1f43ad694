//! What a problem's bodies stand on and its contacts carry, as a step begins: found in one pass over them.

use crate::solver::body::trace;
use crate::solver::{Body, PatchProblem};

/// What bears so many times what a body is pressed down with still bears what is gone.
const UNLOADED: f32 = 2.0;

/// What the contacts of a problem carry, as a whole.
#[derive(Clone, Copy, Debug)]
pub struct LoadStatistics {
    /// The share of what contacts carry that they have not carried for long, 0..1.
    pub unsettled: f32,
    /// The most that something has carried for long by its mass and size, 1/s².
    pub pressed: f32,
    /// Something may bounce.
    pub bounces: bool,
}

/// What holds a body.
#[derive(Clone, Copy, Debug, Default)]
pub struct BodyLoad {
    /// Something has pushed on it before.
    pub carries: bool,
    /// Something stands on it: a body of a higher level of support.
    pub bears: bool,
    /// What has long pushed on it upwards, and downwards, or does so now, N·s: what is round holds no load, and yet weighs.
    up: f32,
    down: f32,
    /// 1/(mass · size), 1/(kg·m): its size is half the side of the cube that is as easy to turn.
    pub yielding: f32,
}

impl LoadStatistics {
    /// Of a problem, and of each of its bodies.
    pub fn of(problem: &PatchProblem, body_loads: &mut Vec<BodyLoad>) -> Self {
        let up = -problem.gravity.normalize_or_zero();
        body_loads.clear();
        body_loads.extend(problem.bodies.iter().map(BodyLoad::of));
        let (mut new, mut all, mut pressed) = (0.0, 0.0, 0f32);
        let mut bounces = false;
        for patch in problem.patches.iter() {
            bounces |= patch.restitution > 0.0;
            let (mut load, mut impulse) = (0.0, 0.0);
            for point in &problem.points[patch.range()] {
                load += point.load;
                impulse += point.warm_normal;
            }
            new += (impulse - load).abs();
            all += larger(impulse, load);
            let carries = load > 0.0 || impulse > 0.0;
            let levels = patch.bodies.map(|body| problem.bodies[body as usize].level);
            let lower = patch.bodies[usize::from(levels[1] < levels[0])];
            body_loads[lower as usize].bears |= levels[0] != levels[1];
            let along = up.dot(patch.normal);
            let long = along * load + up.dot(patch.load_tangential);
            let now = along * impulse + up.dot(patch.warm_tangential);
            for (body, sign) in patch.bodies.into_iter().zip([1.0, -1.0]) {
                let (long, now) = (sign * long, sign * now);
                let body_loads = &mut body_loads[body as usize];
                body_loads.carries |= carries;
                body_loads.up += larger(long, 0.0);
                body_loads.down += larger(larger(-long, -now), 0.0);
                pressed = larger(load * body_loads.yielding, pressed);
            }
        }
        Self {
            unsettled: if all > 0.0 { new / all } else { 1.0 },
            pressed: pressed / problem.dt,
            bounces,
        }
    }
}

/// The larger one. (`f32::max` takes four instructions more, for numbers that are none.)
#[inline(always)]
fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

impl BodyLoad {
    fn of(body: &Body) -> Self {
        let trace = trace(&body.inverse_inertia);
        Self {
            // That of a cube of side a is 18 / (m a²).
            yielding: (body.inverse_mass * trace * (4.0 / 18.0)).sqrt(),
            ..Default::default()
        }
    }

    /// What lay on it is gone, and what bore that would throw it.
    pub fn is_unloaded(&self, body: &Body, problem: &PatchProblem) -> bool {
        let weight = problem.gravity.length() * problem.dt / body.inverse_mass;
        self.up > UNLOADED * (self.down + weight)
    }
}
