//! The loads of a problem's contacts and bodies at the beginning of a step, found in one pass over the contacts.

use crate::Both;
use crate::body::trace;
use crate::{Body, PatchProblem};

/// A body has lost load if its supports push this many times as much as its weight and the bodies on it.
const UNLOADED: f32 = 2.0;

/// Number of points from which on a contact is flat: a body may tip over one of two points.
const FLAT: u32 = 3;

/// Number of edges that make no pile: a block that rocks stands on one, and an arch that falls turns about four.
const LONE_EDGES: usize = 4;

/// Statistics of the contacts of a problem.
#[derive(Clone, Copy, Debug)]
pub struct LoadStatistics {
    /// The share of the current impulses that differs from the loads at rest, 0..1.
    pub unsettled: f32,
    /// The largest load at rest on a body divided by its mass and size, 1/s².
    pub pressed: f32,
    /// Some contact may bounce.
    pub bounces: bool,
    /// Some body is round.
    pub rolls: bool,
    /// The share of edges and corners among the contacts that carry, 0..1. Contacts of round bodies and the first [`LONE_EDGES`] edges do
    /// not count.
    pub edges: f32,
}

/// The loads on a body.
#[derive(Clone, Copy, Debug, Default)]
pub struct BodyLoad {
    /// A contact of it has an impulse or a load at rest.
    pub carries: bool,
    /// It supports a body of a higher level of support.
    pub bears: bool,
    /// The normal impulses of its flat contacts that stick, less those of its other contacts, N·s.
    pub standing: f32,
    /// Upwards the load at rest that supports still push with; and downwards load at rest or current impulse, N·s. A point that has opened
    /// keeps its load at rest for a while, and it throws nothing. Round bodies have no load at rest and still weigh on the body below.
    up: f32,
    down: f32,
    /// 1/(mass · size), 1/(kg·m). The size is half the side of the cube with the same resistance to rotation.
    pub yielding: f32,
}

impl LoadStatistics {
    /// The statistics of a problem; `body_loads` receives those of its bodies.
    pub fn of(problem: &PatchProblem, body_loads: &mut Vec<BodyLoad>) -> Self {
        let up = -problem.gravity.normalize_or_zero();
        body_loads.clear();
        body_loads.extend(problem.bodies.iter().map(BodyLoad::of));
        let (mut new, mut all, mut pressed) = (0.0, 0.0, 0f32);
        let (mut bounces, mut rolls) = (false, false);
        let (mut edges, mut carrying) = (0usize, 0usize);
        for patch in problem.patches.iter() {
            let round = patch.rolling_radius > 0.0 && patch.rolling_radius < f32::INFINITY;
            bounces |= patch.restitution > 0.0;
            rolls |= round;
            let (mut load, mut impulse) = (0.0, 0.0);
            for point in &problem.points[patch.range()] {
                load += point.rest_impulse;
                impulse += point.normal_impulse;
            }
            new += (impulse - load).abs();
            all += larger(impulse, load);
            let carries = load > 0.0 || impulse > 0.0;
            carrying += usize::from(carries);
            edges += usize::from(carries && patch.count < FLAT && !round);
            let levels = patch
                .bodies
                .both(|body| problem.bodies[body as usize].level);
            let lower = patch.bodies[usize::from(levels[1] < levels[0])];
            body_loads[lower as usize].bears |= levels[0] != levels[1];
            let along = up.dot(patch.normal);
            let long = along * load + up.dot(patch.rest_friction_impulse);
            let now = along * impulse + up.dot(patch.friction_impulse);
            for (body, sign) in patch.bodies.into_iter().zip([1.0, -1.0]) {
                let (long, now) = (sign * long, sign * now);
                let body_loads = &mut body_loads[body as usize];
                body_loads.carries |= carries;
                body_loads.standing += match patch.slip.is_some() && patch.count >= FLAT {
                    true => impulse,
                    false => -impulse,
                };
                body_loads.up += larger(if now < long { now } else { long }, 0.0);
                body_loads.down += larger(larger(-long, -now), 0.0);
                pressed = larger(load * body_loads.yielding, pressed);
            }
        }
        Self {
            unsettled: if all > 0.0 { new / all } else { 1.0 },
            pressed: pressed / problem.dt,
            bounces,
            rolls,
            edges: edges.saturating_sub(LONE_EDGES) as f32 / carrying.max(1) as f32,
        }
    }
}

/// The larger number. (`f32::max` takes four instructions more, to treat NaN.)
#[inline(always)]
fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

impl BodyLoad {
    fn of(body: &Body) -> Self {
        let trace = trace(&body.inverse_inertia);
        Self {
            // The trace of a cube of side a is 18 / (m a²).
            yielding: (body.inverse_mass * trace * (4.0 / 18.0)).sqrt(),
            ..Default::default()
        }
    }

    /// Whether the body stands: most of what presses on it does so in flat contacts that stick. It does not roll, slide or tip then.
    pub fn stands(&self) -> bool {
        self.standing > 0.0
    }

    /// Whether a load was removed from the body. Its supports would throw it.
    pub fn is_unloaded(&self, body: &Body, problem: &PatchProblem) -> bool {
        let weight = problem.gravity.length() * problem.dt / body.inverse_mass;
        self.up > UNLOADED * (self.down + weight)
    }
}
