//! What the contacts of a structure that was just built carry.
//!
//! Without impulses to start from, sweeps need a number that grows with the height squared to find the load at the foot of a
//! tower, and until then it sinks. But loads go down: from the top, each body hands its own weight and what it has been given
//! to what it lies on. One pass is exact for a tower, and a good start for a wall or a pyramid.

use crate::solver::{Body, Patch, PatchPoint, Problem};
use glam::Vec3;

/// Normals flatter than this, as a cosine to the vertical, carry no load.
const FLAT: f32 = 0.1;

/// Visits to the supports of one body, which share its load.
const VISITS: usize = 50;

/// True where most contacts are new and all bodies slow: built, not collided.
fn is_new(problem: &Problem, closed: f32) -> bool {
    let fall = problem.gravity.length() * problem.dt;
    let slow = |body: &Body| {
        let before = body.linear - body.push[0];
        before.length_squared() <= fall * fall
    };
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

/// The patches that each body lies on: their indices, and on which side of them it is.
struct Supports {
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

/// Gives the contacts of a new structure the load they will carry. True where it is one.
pub fn cold_start(problem: &mut Problem) -> bool {
    let closed = 0.5 * problem.gravity.length() * problem.dt * problem.dt;
    if !is_new(problem, closed) {
        return false;
    }
    let mut supports = Supports::new(problem);
    // What each body would do if nothing held it.
    let mut motions: Vec<[Vec3; 2]> = problem.bodies.iter().map(|body| body.push).collect();
    let mut ready: Vec<usize> = (0..problem.bodies.len())
        .filter(|&body| supports.above[body] == 0)
        .collect();
    while let Some(body) = ready.pop() {
        let beneath = std::mem::take(&mut supports.of[body]);
        // Equal shares first: sweeps alone would let the point visited first carry the most.
        let count: usize = beneath
            .iter()
            .map(|&(patch, _)| {
                let points = &problem.points[problem.patches[patch].range()];
                points.iter().filter(|p| p.separation <= closed).count()
            })
            .sum();
        let falling = motions[body][0].dot(problem.gravity.normalize_or_zero()).max(0.0);
        let share = falling / (problem.bodies[body].inverse_mass * count.max(1) as f32);
        for &(patch, side) in &beneath {
            let patch = &problem.patches[patch];
            for point in &mut problem.points[patch.range()] {
                if point.separation <= closed && problem.bodies[body].inverse_mass > 0.0 {
                    let normal = if side == 0 { patch.normal } else { -patch.normal };
                    let arm = patch.arms[side] + point.offset;
                    point.impulse = share;
                    push(&problem.bodies[body], &mut motions[body], normal * share, arm);
                }
            }
        }
        for _ in 0..VISITS {
            for &(patch, side) in &beneath {
                let patch = &problem.patches[patch];
                let points = &mut problem.points[patch.range()];
                carry(
                    &problem.bodies[body],
                    &mut motions[body],
                    patch,
                    side,
                    points,
                    closed,
                );
            }
        }
        for &(index, side) in &beneath {
            let points = &problem.points[problem.patches[index].range()];
            problem.patches[index].load = points.iter().map(|p| p.impulse).sum::<f32>() / points.len() as f32;
            let patch = &problem.patches[index];
            let below = patch.bodies[1 - side] as usize;
            for point in &problem.points[patch.range()] {
                let normal = if side == 0 { -patch.normal } else { patch.normal };
                let arm = patch.arms[1 - side] + point.offset;
                push(
                    &problem.bodies[below],
                    &mut motions[below],
                    normal * point.impulse,
                    arm,
                );
            }
            supports.above[below] -= 1;
            if supports.above[below] == 0 {
                ready.push(below);
            }
        }
    }
    true
}

/// Stops a body's fall at the points of one patch, as if what is below could not give way.
fn carry(
    body: &Body,
    motion: &mut [Vec3; 2],
    patch: &Patch,
    side: usize,
    points: &mut [PatchPoint],
    closed: f32,
) {
    let normal = if side == 0 { patch.normal } else { -patch.normal };
    for point in points.iter_mut().filter(|p| p.separation <= closed) {
        let arm = patch.arms[side] + point.offset;
        let turn = arm.cross(normal);
        let response = body.inverse_mass + turn.dot(body.inverse_inertia * turn);
        if response <= 0.0 {
            continue;
        }
        let approach = normal.dot(motion[0]) + turn.dot(motion[1]);
        let found = (point.impulse - approach / response).max(0.0);
        push(body, motion, normal * (found - point.impulse), arm);
        point.impulse = found;
    }
}

fn push(body: &Body, motion: &mut [Vec3; 2], impulse: Vec3, arm: Vec3) {
    motion[0] += body.inverse_mass * impulse;
    motion[1] += body.inverse_inertia * arm.cross(impulse);
}
