//! What the contacts of a structure that was just built carry.
//!
//! Without impulses to start from, sweeps need a number that grows with the height squared to find the load at the foot of a
//! tower, and until then it sinks. But loads go down: from the top, each body hands its own weight and what it has been given
//! to what it lies on. One pass is exact for a tower, and a good start for a wall or a pyramid.

use crate::solver::{Body, PatchPoint, Problem};
use glam::Vec3;

/// Normals flatter than this, as a cosine to the vertical, carry no load.
const FLAT: f32 = 0.1;

/// Visits to the supports of one body, which share its load.
const VISITS: usize = 50;

/// True where most contacts are new and all bodies slow: built, not collided.
fn is_new(problem: &Problem, closed: f32) -> bool {
    let fall = problem.gravity.length() * problem.dt;
    let slow = |body: &Body| body.start[0].length_squared() <= fall * fall;
    let (mut new, mut old) = (0, 0);
    for patch in problem.patches.iter() {
        let points = &problem.points[patch.range()];
        if points.iter().any(|point| point.impulse > 0.0) {
            old += 1;
        } else if points.iter().any(|point| point.separation <= closed) {
            new += 1;
        }
    }
    new > old && problem.bodies.iter().all(slow)
}

/// What lies on what.
struct Supports {
    /// For each body the patches it lies on, and on which side of them it is.
    of: Vec<Vec<(usize, usize)>>,
    /// How many patches lie on each body and have not handed down their load.
    above: Vec<usize>,
}

impl Supports {
    fn new(problem: &Problem) -> Self {
        let up = -problem.gravity.normalize_or_zero();
        let mut supports = Self {
            of: vec![Vec::new(); problem.bodies.len()],
            above: vec![0; problem.bodies.len()],
        };
        for (i, patch) in problem.patches.iter().enumerate() {
            let slope = patch.normal.dot(up);
            if slope.abs() < FLAT {
                continue;
            }
            let upper = if slope > 0.0 { 0 } else { 1 };
            let [on_top, below] = [patch.bodies[upper], patch.bodies[1 - upper]];
            supports.of[on_top as usize].push((i, upper));
            supports.above[below as usize] += 1;
        }
        supports
    }
}

/// A point that a body stands on.
struct Foot {
    /// Its index among the problem's.
    point: usize,
    /// Towards the body.
    normal: Vec3,
    /// From the centre of the body, m.
    arm: Vec3,
    /// Inverse effective mass, if what is below could not give way, 1/kg.
    response: f32,
    /// What it stands on, and the arm there.
    below: (usize, Vec3),
}

/// The closed points that a body stands on.
fn feet(problem: &Problem, body: usize, beneath: &[(usize, usize)], closed: f32) -> Vec<Foot> {
    let mut feet = Vec::new();
    for &(patch, side) in beneath {
        let patch = &problem.patches[patch];
        let normal = patch.normal * if side == 0 { 1.0 } else { -1.0 };
        for point in patch.range() {
            let PatchPoint {
                offset, separation, ..
            } = problem.points[point];
            let arm = patch.arms[side] + offset;
            let response = problem.bodies[body].response(normal, arm);
            if separation <= closed && response > 0.0 {
                feet.push(Foot {
                    point,
                    normal,
                    arm,
                    response,
                    below: (
                        patch.bodies[1 - side] as usize,
                        patch.arms[1 - side] + offset,
                    ),
                });
            }
        }
    }
    feet
}

/// Gives the contacts of a new structure the load they will carry, as impulses and as what they carry at rest.
pub fn cold_start(problem: &mut Problem) {
    let closed = 0.5 * problem.gravity.length() * problem.dt * problem.dt;
    if !is_new(problem, closed) {
        return;
    }
    let down = problem.gravity.normalize_or_zero();
    let mut supports = Supports::new(problem);
    // What each body would do with what it carries if nothing held it.
    let mut motions: Vec<[Vec3; 2]> = problem.bodies.iter().map(Body::push).collect();
    let mut ready: Vec<usize> = (0..problem.bodies.len())
        .filter(|&body| supports.above[body] == 0)
        .collect();
    while let Some(body) = ready.pop() {
        let beneath = std::mem::take(&mut supports.of[body]);
        let feet = feet(problem, body, &beneath, closed);
        // Equal shares first: sweeps alone would let the foot visited first carry the most.
        let weight = motions[body][0].dot(down).max(0.0) / problem.bodies[body].inverse_mass;
        for foot in &feet {
            let share = weight / feet.len() as f32;
            problem.points[foot.point].impulse = share;
            push(
                &problem.bodies[body],
                &mut motions[body],
                foot.normal * share,
                foot.arm,
            );
        }
        for foot in std::iter::repeat_n(&feet, VISITS).flatten() {
            let [linear, angular] = motions[body];
            let approach = foot.normal.dot(linear + angular.cross(foot.arm));
            let impulse = &mut problem.points[foot.point].impulse;
            let found = (*impulse - approach / foot.response).max(0.0);
            let change = foot.normal * (found - *impulse);
            *impulse = found;
            push(&problem.bodies[body], &mut motions[body], change, foot.arm);
        }
        for foot in &feet {
            let load = -foot.normal * problem.points[foot.point].impulse;
            let (below, arm) = foot.below;
            push(&problem.bodies[below], &mut motions[below], load, arm);
        }
        for (patch, side) in beneath {
            let patch = &problem.patches[patch];
            for point in &mut problem.points[patch.range()] {
                point.load = point.impulse;
            }
            let below = patch.bodies[1 - side] as usize;
            supports.above[below] -= 1;
            if supports.above[below] == 0 {
                ready.push(below);
            }
        }
    }
}

fn push(body: &Body, motion: &mut [Vec3; 2], impulse: Vec3, arm: Vec3) {
    let [linear, angular] = body.answer(impulse, arm);
    motion[0] += linear;
    motion[1] += angular;
}
