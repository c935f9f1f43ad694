//! Loads go down: from the top, each body hands its own weight and what it has been given to what it lies on, as if that could not
//! give way. One pass is exact for a tower, also on a slope, and a good start for a wall or a pyramid.

use super::super::upright::{up, upper};
use crate::solver::{Body, PatchPoint, PatchProblem};
use glam::Vec3;

/// Visits to the supports of one body, which share its load, at most.
const VISITS: usize = 200;

/// Visits end when they change less than this share of what the body carries.
const SHARED: f32 = 1e-5;

/// What moves by less than this share of what gravity would do to it is in balance; turns on an arm of a metre.
const BALANCED: f32 = 1e-3;

/// What lies on what.
struct Supports {
    /// For each body the patches it lies on, and on which side of them it is.
    of: Vec<Vec<(usize, usize)>>,
    /// How many patches lie on each body and have not handed down their load.
    above: Vec<usize>,
}

/// Whether a way down to what nothing moves leads from each body through closed patches. They come in the order of their level, so
/// that one pass finds all.
pub fn standing(problem: &PatchProblem, closed: f32) -> Vec<bool> {
    let up = up(problem);
    let fixed = |body: &Body| body.inverse_mass == 0.0;
    let mut stands: Vec<bool> = problem.bodies.iter().map(fixed).collect();
    for patch in problem.patches.iter() {
        let points = &problem.points[patch.range()];
        if let Some(side) = upper(patch, up)
            && points.iter().any(|point| point.separation <= closed)
        {
            let [on_top, below] = [side, 1 - side].map(|side| patch.bodies[side] as usize);
            stands[on_top] |= stands[below];
        }
    }
    stands
}

impl Supports {
    fn new(problem: &PatchProblem) -> Self {
        let up = up(problem);
        let mut supports = Self {
            of: vec![Vec::new(); problem.bodies.len()],
            above: vec![0; problem.bodies.len()],
        };
        for (i, patch) in problem.patches.iter().enumerate() {
            if let Some(side) = upper(patch, up) {
                let [on_top, below] = [side, 1 - side].map(|side| patch.bodies[side] as usize);
                supports.of[on_top].push((i, side));
                supports.above[below] += 1;
            }
        }
        supports
    }
}

/// A direction along which something is pushed.
struct Row {
    direction: Vec3,
    /// From the centre of the body, m.
    arm: Vec3,
    /// Inverse effective mass, if what is below could not give way, 1/kg.
    response: f32,
    /// N·s
    impulse: f32,
    /// What it was.
    before: f32,
}

impl Row {
    fn new(body: &Body, direction: Vec3, arm: Vec3, impulse: f32) -> Self {
        Self {
            direction,
            arm,
            response: body.response(direction, arm),
            impulse,
            before: impulse,
        }
    }

    /// What would stop the body along it.
    fn wanted(&self, [linear, angular]: [Vec3; 2]) -> f32 {
        self.impulse - self.direction.dot(linear + angular.cross(self.arm)) / self.response
    }

    /// What has come to it, N·s.
    fn gained(&self) -> Vec3 {
        self.direction * (self.impulse - self.before)
    }

    /// Makes its impulse that; by how much it changes.
    fn set(&mut self, impulse: f32, body: &Body, motion: &mut [Vec3; 2]) -> f32 {
        let change = impulse - self.impulse;
        self.impulse = impulse;
        push(body, motion, self.direction * change, self.arm);
        change.abs()
    }
}

/// A patch that a body stands on.
struct Foot {
    /// Among the problem's.
    patch: usize,
    /// On which side of it the body is.
    side: usize,
    normals: Vec<(usize, Row)>,
    tangents: [Row; 2],
}

impl Foot {
    /// Where any of its points is closed.
    fn new(problem: &PatchProblem, (index, side): (usize, usize), closed: f32) -> Option<Self> {
        let patch = &problem.patches[index];
        let body = &problem.bodies[patch.bodies[side] as usize];
        let sign = if side == 0 { 1.0 } else { -1.0 };
        let arm = patch.arms[side];
        let point = |i: usize| -> Option<(usize, Row)> {
            let PatchPoint {
                offset,
                separation,
                warm_normal,
                ..
            } = problem.points[i];
            let row = Row::new(body, patch.normal * sign, arm + offset, warm_normal);
            let carries = separation <= closed || warm_normal > 0.0;
            (carries && row.response > 0.0).then_some((i, row))
        };
        let normals: Vec<_> = patch.range().filter_map(point).collect();
        let (t1, t2) = patch.normal.any_orthonormal_pair();
        (!normals.is_empty()).then(|| Self {
            patch: index,
            side,
            normals,
            tangents: [t1, t2].map(|t| Row::new(body, t * sign, arm, t.dot(patch.warm_tangential))),
        })
    }

    /// Lets its points stop the body; by how much an impulse has changed at most, N·s.
    fn push(&mut self, body: &Body, motion: &mut [Vec3; 2]) -> f32 {
        let mut changed = 0f32;
        for (_, row) in &mut self.normals {
            let wanted = row.wanted(*motion).max(0.0);
            changed = changed.max(row.set(wanted, body, motion));
        }
        changed
    }

    /// The same of its friction, within what its points carry.
    fn hold(&mut self, friction: f32, body: &Body, motion: &mut [Vec3; 2]) -> f32 {
        let carried: f32 = self.normals.iter().map(|(_, row)| row.impulse).sum();
        let [x, y] = [0, 1].map(|i| self.tangents[i].wanted(*motion));
        let share = (friction * carried / x.hypot(y)).min(1.0);
        let found = if share.is_nan() {
            [0.0; 2]
        } else {
            [x, y].map(|x| share * x)
        };
        let rows = self.tangents.iter_mut().zip(found);
        rows.map(|(row, found)| row.set(found, body, motion))
            .fold(0.0, f32::max)
    }
}

/// What each body would do in this step under its forces and what its contacts start with.
fn unbalanced(problem: &PatchProblem) -> Vec<[Vec3; 2]> {
    let mut motions: Vec<[Vec3; 2]> = problem.bodies.iter().map(Body::push).collect();
    for patch in problem.patches.iter() {
        for (side, sign) in [1.0, -1.0].into_iter().enumerate() {
            let index = patch.bodies[side] as usize;
            let (body, arm) = (&problem.bodies[index], patch.arms[side]);
            push(body, &mut motions[index], sign * patch.warm_tangential, arm);
            for point in &problem.points[patch.range()] {
                let impulse = sign * point.warm_normal * patch.normal;
                push(body, &mut motions[index], impulse, arm + point.offset);
            }
        }
    }
    motions
}

/// Whether what contacts start with leaves hardly anything of what forces do.
pub fn is_balanced(problem: &PatchProblem) -> bool {
    let most = BALANCED * problem.gravity.length() * problem.dt;
    let motions = unbalanced(problem);
    let bodies = problem.bodies.iter().zip(motions);
    bodies
        .filter(|(body, _)| body.inverse_mass > 0.0)
        .all(|(_, motion)| motion.iter().all(|part| part.length() <= most))
}

/// Hands down what is not balanced of bodies that are new, or have lost what lay on them. The bodies below keep what they carry where that is
/// enough. Through how many bodies the longest way led.
pub fn hand_down(problem: &mut PatchProblem, closed: f32, new: &[bool]) -> usize {
    let down = -up(problem);
    let mut supports = Supports::new(problem);
    // Of the others only what comes to them: what they lack or have too much is motion, and not new. Handed down with the rest it would
    // push a wall that trembles out of its plane.
    let mut motions = unbalanced(problem);
    for (motion, _) in motions.iter_mut().zip(new).filter(|(_, new)| !**new) {
        *motion = [Vec3::ZERO; 2];
    }
    let mut gained = new.to_vec();
    let mut courses = vec![1; problem.bodies.len()];
    let mut ready: Vec<usize> = (0..problem.bodies.len())
        .filter(|&body| supports.above[body] == 0)
        .collect();
    while let Some(index) = ready.pop() {
        let beneath = std::mem::take(&mut supports.of[index]);
        if gained[index] {
            let foot = |&at: &(usize, usize)| Foot::new(problem, at, closed);
            let mut feet: Vec<Foot> = beneath.iter().filter_map(foot).collect();
            share(problem, index, &mut feet, &mut motions[index], down);
            for foot in feet {
                gained[foot.below(problem)] = true;
                foot.hand_on(problem, &mut motions);
            }
        }
        for (patch, side) in beneath {
            let below = problem.patches[patch].bodies[1 - side] as usize;
            courses[below] = courses[below].max(courses[index] + 1);
            supports.above[below] -= 1;
            if supports.above[below] == 0 {
                ready.push(below);
            }
        }
    }
    courses.into_iter().max().unwrap_or(0)
}

/// Shares what has come to a body among its feet.
fn share(
    problem: &PatchProblem,
    index: usize,
    feet: &mut [Foot],
    motion: &mut [Vec3; 2],
    down: Vec3,
) {
    let body = &problem.bodies[index];
    let pressed = motion[0].dot(down) / body.inverse_mass;
    // Equal shares of what comes, and of what goes the same share of each first: visits alone would let the foot visited first carry
    // the most, or the least.
    let rows = || feet.iter().flat_map(|foot| &foot.normals);
    let equal = pressed.max(0.0) / rows().count() as f32;
    let borne: f32 = rows().map(|(_, row)| row.impulse).sum();
    let left = if borne > 0.0 {
        (1.0 + pressed.min(0.0) / borne).max(0.0)
    } else {
        1.0
    };
    for (_, row) in feet.iter_mut().flat_map(|foot| &mut foot.normals) {
        row.set(left * row.impulse + equal, body, motion);
    }
    // Friction only where there is no rest without: it would be held by springs.
    for with_friction in [false, true] {
        for _ in 0..VISITS {
            let mut changed = 0f32;
            for foot in feet.iter_mut() {
                changed = changed.max(foot.push(body, motion));
                if with_friction {
                    let friction = problem.patches[foot.patch].friction;
                    changed = changed.max(foot.hold(friction, body, motion));
                }
            }
            if changed <= SHARED * pressed.abs() {
                break;
            }
        }
    }
}

impl Foot {
    fn below(&self, problem: &PatchProblem) -> usize {
        problem.patches[self.patch].bodies[1 - self.side] as usize
    }

    /// To the problem, and to what is below.
    fn hand_on(self, problem: &mut PatchProblem, motions: &mut [[Vec3; 2]]) {
        let patch = &mut problem.patches[self.patch];
        let (sign, other) = if self.side == 0 { (1.0, 1) } else { (-1.0, 0) };
        let below = patch.bodies[other] as usize;
        let mut load = |row: &Row, arm: Vec3| {
            push(
                &problem.bodies[below],
                &mut motions[below],
                -row.gained(),
                arm,
            )
        };
        for row in &self.tangents {
            patch.warm_tangential += sign * row.gained();
            load(row, patch.arms[other]);
        }
        for (i, row) in &self.normals {
            let point = &mut problem.points[*i];
            load(row, patch.arms[other] + point.offset);
            // Its impulse of the moment may be more or less than what it carries at rest.
            point.load = (point.load + (row.impulse - row.before)).max(0.0);
            point.warm_normal = row.impulse;
        }
    }
}

fn push(body: &Body, motion: &mut [Vec3; 2], impulse: Vec3, arm: Vec3) {
    let [linear, angular] = body.answer(impulse, arm);
    motion[0] += linear;
    motion[1] += angular;
}
