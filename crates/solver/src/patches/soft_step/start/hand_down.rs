//! Hands loads down. From the top, each body passes its own weight and the load on it to its supports, as if those could not yield. One
//! pass is exact for a tower, also on a slope, and a good start for a wall or a pyramid.

use super::MAX_PLACED_SPEED;
use crate::Both;
use crate::contact_row::{ContactRow, add_to, relative};
use crate::patches::soft_step::start::upright::{up, upper};
use crate::{Body, PatchConstraint, PatchPoint, PatchProblem};
use bevy_math::ops;
use glam::Vec3;
use smallvec::SmallVec;

/// Upper bound of visits to the supports of one body, which share its load.
const MAX_VISITS: usize = 200;

/// The same for pieces of bodies that have just broken, which hardly stay as they are.
const MAX_VISITS_OF_PIECES: usize = 20;

/// Visits end when they change less than this share of the body's new load or of its weight, whichever is larger.
const SETTLED_SHARE: f32 = 1e-5;

/// Which points carry loads, and which bodies need friction.
#[derive(Clone, Copy)]
pub struct Limits {
    /// Points that are farther apart carry nothing, m.
    pub closed: f32,
    /// A body gets no friction if normal forces leave it less motion than this in the step, m/s. 0 for awake bodies.
    pub still: f32,
}

impl Limits {
    /// The limits for bodies at rest, which do not move by what is left.
    pub fn at_rest(self, problem: &PatchProblem) -> Self {
        let still = SETTLED_SHARE * problem.gravity.length() * problem.dt;
        Self { still, ..self }
    }
}

/// The supports of each body.
struct Supports {
    /// By body: the patches it lies on, and its side of each.
    of: Vec<SmallVec<[(u32, u32); 4]>>,
    /// By body: the number of patches on it that have not handed down their load.
    above: Vec<u32>,
}

/// By body: whether a path of closed patches leads down to a fixed body, or to one that joints hold (`jointed`, if any). Patches come in
/// the order of their level, so that one pass finds all.
pub fn standing(problem: &PatchProblem, closed: f32, jointed: &[bool]) -> Vec<bool> {
    let up = up(problem);
    let fixed = |body: &Body| body.inverse_mass == 0.0;
    let mut stands: Vec<bool> = problem.bodies.iter().map(fixed).collect();
    for (stands, &jointed) in stands.iter_mut().zip(jointed) {
        *stands |= jointed;
    }
    for patch in problem.patches.iter() {
        let points = &problem.points[patch.range()];
        if let Some(side) = upper(patch, up)
            && points.iter().any(|point| point.separation <= closed)
        {
            let [on_top, below] = [side, 1 - side].both(|side| patch.bodies[side] as usize);
            stands[on_top] |= stands[below];
        }
    }
    stands
}

impl Supports {
    fn new(problem: &PatchProblem) -> Self {
        let up = up(problem);
        let mut supports = Self {
            of: vec![SmallVec::new(); problem.bodies.len()],
            above: vec![0; problem.bodies.len()],
        };
        for (i, patch) in problem.patches.iter().enumerate() {
            if let Some(side) = upper(patch, up) {
                let [on_top, below] = [side, 1 - side].both(|side| patch.bodies[side] as usize);
                supports.of[on_top].push((i as u32, side as u32));
                supports.above[below] += 1;
            }
        }
        supports
    }
}

/// A direction in which a support pushes a body.
struct Push {
    /// A is the body, B the one below, which cannot yield.
    row: ContactRow,
    /// The impulse before the pass, N·s.
    before: f32,
}

impl Push {
    fn new(body: &Body, direction: Vec3, arms: [Vec3; 2], impulse: f32) -> Self {
        let row = ContactRow {
            direction,
            arms,
            response: body.response(direction, arms[0]),
            impulse,
        };
        Self {
            row,
            before: impulse,
        }
    }

    /// The impulse that would stop the body in its direction, N·s.
    fn wanted(&self, velocity: [Vec3; 2]) -> f32 {
        let row = &self.row;
        match row.response > 0.0 {
            true => row.impulse - row.rate_of_a(velocity) / row.response,
            // The body is locked in this direction.
            false => 0.0,
        }
    }

    /// The impulse that the pass has added, N·s.
    fn gained(&self) -> Vec3 {
        self.row.direction * (self.row.impulse - self.before)
    }

    /// Sets its impulse. Returns the absolute change, N·s.
    fn set(&mut self, impulse: f32, body: &Body, motion: &mut [Vec3; 2]) -> f32 {
        let change = self.row.set(impulse);
        add_to(motion, self.row.answer(change, body, 0));
        change.abs()
    }
}

/// A patch on which a body stands.
struct Foot {
    /// Its index in the problem.
    patch: usize,
    /// The side of the body.
    side: usize,
    normals: SmallVec<[(usize, Push); 4]>,
    /// Its friction, if that is needed.
    tangents: Option<[Push; 2]>,
}

impl Foot {
    /// A foot, if any of its points is closed or carries an impulse.
    fn new(problem: &PatchProblem, (index, side): (u32, u32), closed: f32) -> Option<Self> {
        let (index, side) = (index as usize, side as usize);
        let patch = &problem.patches[index];
        let body = &problem.bodies[patch.bodies[side] as usize];
        let sign = if side == 0 { 1.0 } else { -1.0 };
        let arms = [side, 1 - side].both(|side| patch.arms[side]);
        let point = |i: usize| -> Option<(usize, Push)> {
            let PatchPoint {
                offset,
                separation,
                normal_impulse,
                ..
            } = problem.points[i];
            let arms = arms.both(|arm| arm + offset);
            let push = Push::new(body, patch.normal * sign, arms, normal_impulse);
            let carries = separation <= closed || normal_impulse > 0.0;
            (carries && push.row.response > 0.0).then_some((i, push))
        };
        let normals: SmallVec<_> = patch.range().filter_map(point).collect();
        (!normals.is_empty()).then_some(Self {
            patch: index,
            side,
            normals,
            tangents: None,
        })
    }

    /// Lets its points stop the body. Returns the largest change of an impulse, N·s.
    fn push(&mut self, body: &Body, motion: &mut [Vec3; 2]) -> f32 {
        let mut changed = 0f32;
        for (_, push) in &mut self.normals {
            let wanted = push.wanted(*motion).max(0.0);
            changed = changed.max(push.set(wanted, body, motion));
        }
        changed
    }

    /// Lets its friction stop the body, within the friction of its normal impulses. Friction of a body that slides acts against the slide.
    /// Returns the largest change, N·s.
    fn hold(&mut self, problem: &PatchProblem, body: &Body, motion: &mut [Vec3; 2]) -> f32 {
        let patch = &problem.patches[self.patch];
        let (t1, t2) = patch.normal.any_orthonormal_pair();
        let tangents = self.tangents.get_or_insert_with(|| {
            let sign = if self.side == 0 { 1.0 } else { -1.0 };
            let arms = [self.side, 1 - self.side].both(|side| patch.arms[side]);
            [t1, t2].both(|t| {
                let before = t.dot(patch.friction_impulse);
                Push::new(body, t * sign, arms, before)
            })
        });
        let carried: f32 = self.normals.iter().map(|(_, push)| push.row.impulse).sum();
        let slides = slide(problem, patch);
        let [x, y] = [(0, t1), (1, t2)].both(|(i, t)| {
            let row = &tangents[i].row;
            let stops = match row.response > 0.0 {
                true => t.dot(slides) / row.response,
                false => 0.0,
            };
            tangents[i].wanted(*motion) - stops
        });
        let share = (patch.friction * carried / ops::hypot(x, y)).min(1.0);
        let found = if share.is_nan() {
            [0.0; 2]
        } else {
            [x, y].both(|x| share * x)
        };
        let rows = tangents.iter_mut().zip(found);
        rows.map(|(push, found)| push.set(found, body, motion))
            .fold(0.0, f32::max)
    }
}

/// The velocity with which A slides on B at the centre of a patch, m/s; zero if they hardly move.
fn slide(problem: &PatchProblem, patch: &PatchConstraint) -> Vec3 {
    let starts = patch
        .bodies
        .both(|body| problem.bodies[body as usize].start);
    let velocity = relative(patch.arms, starts).reject_from_normalized(patch.normal);
    match velocity.length_squared() > MAX_PLACED_SPEED * MAX_PLACED_SPEED {
        true => velocity,
        false => Vec3::ZERO,
    }
}

/// The motion of each body in this step under its forces and the warm-start impulses.
fn unbalanced(problem: &PatchProblem) -> Vec<[Vec3; 2]> {
    let mut motions: Vec<[Vec3; 2]> = problem.bodies.iter().map(Body::push).collect();
    for patch in problem.patches.iter() {
        let points = &problem.points[patch.range()];
        // In a structure that was just built nothing carries yet.
        let carries = patch.friction_impulse != Vec3::ZERO
            || points.iter().any(|point| point.normal_impulse != 0.0);
        if !carries {
            continue;
        }
        for (side, sign) in [1.0, -1.0].into_iter().enumerate() {
            let index = patch.bodies[side] as usize;
            let (body, arm) = (&problem.bodies[index], patch.arms[side]);
            let change = body.answer(sign * patch.friction_impulse, arm);
            add_to(&mut motions[index], change);
            for point in points {
                let impulse = sign * point.normal_impulse * patch.normal;
                let change = body.answer(impulse, arm + point.offset);
                add_to(&mut motions[index], change);
            }
        }
    }
    motions
}

/// The largest motion that the warm-start impulses leave a body in this step, m/s; infinite if one is not a number. Rotations count on an
/// arm of a metre.
pub fn largest_motion(problem: &PatchProblem) -> f32 {
    let motions = unbalanced(problem);
    let bodies = problem.bodies.iter().zip(motions);
    let moving = bodies.filter(|(body, _)| body.inverse_mass > 0.0);
    let parts = moving.flat_map(|(_, motion)| motion.both(Vec3::length));
    parts.fold(0.0, |most, part| match part.is_nan() {
        true => f32::INFINITY,
        false => part.max(most),
    })
}

/// Hands down the unbalanced loads of bodies that are new or from which load was removed. The bodies below keep their impulses where those
/// are sufficient. Returns the number of bodies on the longest path.
pub fn hand_down(problem: &mut PatchProblem, limits: Limits, new: &[bool]) -> usize {
    // The imbalance of other bodies is motion and no new load, so they pass on only the load that comes to them. Handed down as well, it
    // would push a trembling wall out of its plane.
    let mut motions = unbalanced(problem);
    for (motion, _) in motions.iter_mut().zip(new).filter(|(_, new)| !**new) {
        *motion = [Vec3::ZERO; 2];
    }
    pass_on(problem, limits, new.to_vec(), motions)
}

/// Passes loads down to the ground. `gained` are the bodies that have any, and `motions` those that it would give them in this step.
/// Returns the number of bodies on the longest path.
pub fn pass_on(
    problem: &mut PatchProblem,
    limits: Limits,
    mut gained: Vec<bool>,
    mut motions: Vec<[Vec3; 2]>,
) -> usize {
    let down = -up(problem);
    let mut supports = Supports::new(problem);
    let mut courses = vec![1; problem.bodies.len()];
    let mut ready: Vec<usize> = (0..problem.bodies.len())
        .filter(|&body| supports.above[body] == 0)
        .collect();
    while let Some(index) = ready.pop() {
        let beneath = std::mem::take(&mut supports.of[index]);
        if gained[index] {
            let foot = |&at: &(u32, u32)| Foot::new(problem, at, limits.closed);
            let mut feet: SmallVec<[Foot; 2]> = beneath.iter().filter_map(foot).collect();
            let motion = &mut motions[index];
            share(problem, index, &mut feet, motion, down, limits.still);
            for foot in feet {
                gained[foot.below(problem)] = true;
                foot.hand_on(problem, &mut motions);
            }
        }
        for (patch, side) in beneath {
            let below = problem.patches[patch as usize].bodies[1 - side as usize] as usize;
            courses[below] = courses[below].max(courses[index] + 1);
            supports.above[below] -= 1;
            if supports.above[below] == 0 {
                ready.push(below);
            }
        }
    }
    courses.into_iter().max().unwrap_or(0)
}

/// Distributes the load of a body over its feet. For `still`, see [`Limits`].
fn share(
    problem: &PatchProblem,
    index: usize,
    feet: &mut [Foot],
    motion: &mut [Vec3; 2],
    down: Vec3,
    still: f32,
) {
    let body = &problem.bodies[index];
    let pressed = motion[0].dot(down) / body.inverse_mass;
    let weight = problem.gravity.length() * problem.dt / body.inverse_mass;
    // Added load is first divided equally, and removed load in proportion. Visits alone would give the first foot the most, or the least.
    let rows = || feet.iter().flat_map(|foot| &foot.normals);
    let equal = pressed.max(0.0) / rows().count() as f32;
    let borne: f32 = rows().map(|(_, push)| push.row.impulse).sum();
    let left = if borne > 0.0 {
        (1.0 + pressed.min(0.0) / borne).max(0.0)
    } else {
        1.0
    };
    for (_, push) in feet.iter_mut().flat_map(|foot| &mut foot.normals) {
        push.set(left * push.row.impulse + equal, body, motion);
    }
    let most = match problem.broke {
        true => MAX_VISITS_OF_PIECES,
        false => MAX_VISITS,
    };
    // Friction is used only where normals give no balance, since springs would have to hold it.
    for with_friction in [false, true] {
        if with_friction && motion.iter().all(|part| part.length() < still) {
            break;
        }
        for _ in 0..most {
            let mut changed = 0f32;
            for foot in feet.iter_mut() {
                changed = changed.max(foot.push(body, motion));
                if with_friction {
                    changed = changed.max(foot.hold(problem, body, motion));
                }
            }
            if changed <= SETTLED_SHARE * pressed.abs().max(weight) {
                break;
            }
        }
    }
}

impl Foot {
    fn below(&self, problem: &PatchProblem) -> usize {
        problem.patches[self.patch].bodies[1 - self.side] as usize
    }

    /// Stores the impulses, and applies them to the body below.
    fn hand_on(self, problem: &mut PatchProblem, motions: &mut [[Vec3; 2]]) {
        let patch = &mut problem.patches[self.patch];
        let (sign, other) = if self.side == 0 { (1.0, 1) } else { (-1.0, 0) };
        let below = patch.bodies[other] as usize;
        let mut load = |push: &Push| {
            let change = problem.bodies[below].answer(-push.gained(), push.row.arms[1]);
            add_to(&mut motions[below], change);
        };
        for push in self.tangents.iter().flatten() {
            patch.friction_impulse += sign * push.gained();
            load(push);
        }
        for (i, push) in &self.normals {
            let point = &mut problem.points[*i];
            load(push);
            // The current impulse may differ from the load at rest, so only the change is added.
            point.rest_impulse = (point.rest_impulse + (push.row.impulse - push.before)).max(0.0);
            point.normal_impulse = push.row.impulse;
        }
    }
}
