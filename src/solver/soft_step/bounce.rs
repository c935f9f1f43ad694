//! Restitution, after the substeps: what was stopped leaves again (Box2D v3's `restitution` stage).

use crate::solver::{Body, Problem};
use glam::Vec3;

/// Visits to all points that bounce; a body that lands flat has several.
const VISITS: usize = 8;

/// Less than this share of the approach is left where a contact has stopped it.
const STOPPED: f32 = 0.5;

/// A point that may bounce.
pub struct Bouncing {
    patch: usize,
    arms: [Vec3; 2],
    /// W, 1/kg.
    response: f32,
    /// Normal velocity before the step, m/s.
    came: f32,
    /// Normal velocity to leave with, m/s.
    leave: f32,
    /// What the bounce has given so far, N·s.
    impulse: f32,
}

/// The points that will bounce if they are stopped, and how fast; before the substeps.
///
/// They leave with a share e of the velocity with which they arrive, equation (2) of the paper: that before this step's forces,
/// and what these add on the way to the surface. Without the second a ball would lose height in every bounce.
pub fn find(problem: &Problem) -> Vec<Bouncing> {
    let mut found = Vec::new();
    let patches = problem.patches.iter().enumerate();
    for (index, patch) in patches.filter(|(_, patch)| patch.restitution > 0.0) {
        let bodies = patch.bodies.map(|body| &problem.bodies[body as usize]);
        for point in &problem.points[patch.range()] {
            let arms = patch.arms.map(|arm| arm + point.offset);
            let came = speed(bodies, &arms, patch.normal, |body| body.start);
            if came < 0.0 {
                let pull = speed(bodies, &arms, patch.normal, Body::push) / problem.dt;
                let gained = -2.0 * pull * point.separation.max(0.0);
                found.push(Bouncing {
                    patch: index,
                    arms,
                    response: bodies[0].response(patch.normal, arms[0])
                        + bodies[1].response(patch.normal, arms[1]),
                    came,
                    leave: patch.restitution * (came * came + gained).max(0.0).sqrt(),
                    impulse: 0.0,
                });
            }
        }
    }
    found
}

/// Lets those leave that have been stopped; after the substeps.
pub fn bounce(problem: &mut Problem, mut bouncing: Vec<Bouncing>) {
    let speed = |problem: &Problem, point: &Bouncing| {
        let patch = &problem.patches[point.patch];
        let bodies = patch.bodies.map(|body| &problem.bodies[body as usize]);
        speed(bodies, &point.arms, patch.normal, |body| {
            [body.linear, body.angular]
        })
    };
    bouncing.retain(|point| speed(problem, point) > STOPPED * point.came);
    for _ in 0..VISITS {
        for point in &mut bouncing {
            let missing = point.leave - speed(problem, point);
            let found = (point.impulse + missing / point.response).max(0.0);
            let patch = &problem.patches[point.patch];
            let change = (found - point.impulse) * patch.normal;
            point.impulse = found;
            let [a, b] = patch.bodies;
            problem.bodies[a as usize].apply(change, point.arms[0]);
            problem.bodies[b as usize].apply(-change, point.arms[1]);
        }
    }
}

fn speed(
    bodies: [&Body; 2],
    arms: &[Vec3; 2],
    normal: Vec3,
    velocity: impl Fn(&Body) -> [Vec3; 2],
) -> f32 {
    let at = |i: usize| {
        let [linear, angular] = velocity(bodies[i]);
        linear + angular.cross(arms[i])
    };
    normal.dot(at(0) - at(1))
}
