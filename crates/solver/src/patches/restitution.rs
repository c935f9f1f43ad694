//! Restitution, after the substeps: bodies that contacts have stopped bounce (Box2D v3's `restitution` stage).
//!
//! A point that arrives at u leaves at −e u, and the other points of its group yield no further in the meantime. Then a bounce takes the
//! share 1 − e² of the energy that the contacts have taken out of the approach, however many bodies have a part in it, and none at e = 1:
//! E⁺ − E⁻ = ½ λᵀ(u⁺ + u⁻), and where λ is not zero u⁺ is −e u⁻. Arms that turn do not satisfy this, so a bounce that would gain energy is
//! weakened.
//!
//! Friction acts in the bounce by Coulomb's law. Where one patch bounces, it acts within the cone of the impulses of the whole blow: those
//! with which the substeps have stopped a point, and those of its bounce. Where several do, it acts within the cone of the bounce, since
//! friction that ties bricks to each other would make a wall bounce like one body. With Newton's law for the normal velocity, as here, a
//! point that begins to slide in the blow slides on as under Poisson's law.
//!
//! Slender bodies take no [blows](super::soft_step::blows), in which friction acts as well; so their points that land take part here, and
//! leave at rest.

use super::soft_step::blows::{BLOW_SPEED, lands_slender};
use crate::Both;
use crate::contact_row::{ContactRow, rate, relative};
use crate::groups::Groups;
use crate::sort;
use crate::{Body, PatchPoint, PatchProblem};
use glam::{DVec3, Vec3};

/// Upper bound of visits to all points of a group.
const MAX_VISITS: usize = 50;

/// Visits end when none has changed a velocity by more than this share of the fastest bounce.
const SETTLED_SHARE: f32 = 1e-6;

/// Points that may bounce.
pub struct Bounces {
    points: Vec<Bouncing>,
    /// By body: change of its velocity by the forces of this step.
    pushes: Vec<[Vec3; 2]>,
}

/// A point that may bounce.
struct Bouncing {
    /// Its index among the problem's.
    point: usize,
    /// The index of its patch.
    patch: usize,
    /// Normal velocity to leave with, m/s.
    leave: f32,
    /// Time of its arrival, s from the start of the step.
    arrives: f32,
    /// It arrives after the others of its patch, and does not bounce in this step.
    is_late: bool,
}

/// Finds the points that will bounce if they are stopped, and their speeds; called before the substeps. With `slender`, those of slender
/// bodies too that do not bounce.
///
/// They leave with a share e of the velocity with which they arrive, equation (2) of the paper: the velocity before this step's forces, and
/// the velocity that these add on the way to the surface. Without the second a ball would lose height in every bounce.
pub fn find(problem: &PatchProblem, slender: bool) -> Bounces {
    let mut points = Vec::new();
    for (number, patch) in problem.patches.iter().enumerate() {
        let bodies = patch.bodies.both(|body| &problem.bodies[body as usize]);
        let lands =
            || slender && patch.friction > 0.0 && bodies.iter().any(|body| lands_slender(body));
        if patch.restitution == 0.0 && !lands() {
            continue;
        }
        for point in patch.range() {
            let PatchPoint {
                offset, separation, ..
            } = problem.points[point];
            let arms = patch.arms.both(|arm| arm + offset);
            let came = rate(patch.normal, arms, bodies.both(|body| body.start));
            if came >= 0.0 {
                continue;
            }
            let gained = rate(patch.normal, arms, bodies.both(Body::push));
            let fallen = -2.0 * gained / problem.dt * separation.max(0.0);
            let leave = patch.restitution * (came * came + fallen).max(0.0).sqrt();
            // A body that would be back within the step rests.
            let takes_part = match patch.restitution > 0.0 {
                true => leave > -0.5 * gained,
                false => came < -BLOW_SPEED,
            };
            if takes_part {
                points.push(Bouncing {
                    point,
                    patch: number,
                    leave,
                    arrives: separation.max(0.0) / -came,
                    is_late: false,
                });
            }
        }
    }
    let pushes = match points.is_empty() {
        true => Vec::new(),
        false => problem.bodies.iter().map(Body::push).collect(),
    };
    Bounces { points, pushes }
}

/// A point that takes part in a bounce: it bounces itself, or it carried an impulse.
struct Taking {
    row: ContactRow,
    point: usize,
    patch: usize,
    /// Its group; points of other groups have no part in its bounce.
    group: u32,
    bodies: [usize; 2],
    /// It was stopped, and takes part in the bounce with a velocity of its own.
    bounces: bool,
    /// Normal velocity to leave with, m/s; 0 for a point that does not bounce.
    leave: f32,
    /// Lower bound of its impulse, N·s. A point that does not leave may lose the impulse with which it was stopped, or which it carries.
    least: f32,
    /// Coefficient of friction.
    friction: f32,
    /// The normal impulse of the substeps, and its share of their friction impulse on A, N·s.
    stopped: f32,
    held: Vec3,
    /// Its friction impulse on A in the bounce, N·s.
    rubbed: Vec3,
    /// The velocity that friction demands of A against B along the surface, m/s.
    along: Vec3,
    /// Upper bound of the response to friction, 1/kg; 0 for a point that does not bounce.
    yields: f32,
}

impl Taking {
    fn speed(&self, bodies: &[Body]) -> f32 {
        self.row.direction.dot(self.velocity(bodies))
    }

    /// The velocity of A relative to B at the point, m/s.
    fn velocity(&self, bodies: &[Body]) -> Vec3 {
        let velocities = self
            .bodies
            .both(|body| [bodies[body].linear, bodies[body].angular]);
        relative(self.row.arms, velocities)
    }

    /// Its impulse on A, N·s.
    fn impulse(&self) -> Vec3 {
        self.row.impulse * self.row.direction + self.rubbed
    }

    /// Lets friction stop the point from sliding, within the cone of its impulses. Returns the change of its velocity, m/s.
    fn rub(&mut self, bodies: &mut [Body]) -> f32 {
        if self.friction == 0.0 || self.yields <= 0.0 {
            return 0.0;
        }
        let slides =
            (self.velocity(bodies) - self.along).reject_from_normalized(self.row.direction);
        let wanted = self.held + self.rubbed - slides / self.yields;
        let most = self.friction * (self.stopped + self.row.impulse).max(0.0);
        let rubbed = wanted.clamp_length_max(most) - self.held;
        let change = rubbed - std::mem::replace(&mut self.rubbed, rubbed);
        bodies[self.bodies[0]].apply(change, self.row.arms[0]);
        bodies[self.bodies[1]].apply(-change, self.row.arms[1]);
        change.length() * self.yields
    }

    /// Adds to its impulse. Returns the amount that was added, N·s.
    fn give(&mut self, change: f32, bodies: &mut [Body]) -> f32 {
        let given = self.row.add(change, self.least);
        let push = given * self.row.direction;
        bodies[self.bodies[0]].apply(push, self.row.arms[0]);
        bodies[self.bodies[1]].apply(-push, self.row.arms[1]);
        given
    }
}

/// Applies restitution to points that were stopped, after `substeps` substeps.
pub fn bounce(problem: &mut PatchProblem, bounces: Bounces, substeps: usize) {
    let mut bouncing = bounces.points;
    let at_once = problem.dt / substeps as f32;
    for patch in bouncing.chunk_by_mut(|a, b| a.patch == b.patch) {
        let stopped = |bouncing: &Bouncing| problem.points[bouncing.point].normal > 0.0;
        let arrived = patch.iter().filter(|point| stopped(point));
        let last = arrived
            .map(|point| point.arrives)
            .fold(f32::NEG_INFINITY, f32::max);
        for point in patch {
            // A face that lands at the very end of the step bounces as a whole, or one of its edges would throw it.
            let arrives_later = point.arrives > last + at_once || point.leave == 0.0;
            point.is_late = !stopped(point) && arrives_later;
        }
    }
    bouncing.retain(|bouncing| !bouncing.is_late);
    if bouncing.is_empty() {
        return;
    }
    let mut rows = rows(problem, &bouncing, substeps);
    group(&mut rows, problem.bodies);
    for group in rows.chunk_by_mut(|a, b| a.group == b.group) {
        if group.iter().any(|taking| taking.bounces) {
            throw(group, problem.points, problem.bodies, &bounces.pushes);
        }
    }
    for taking in rows {
        let point = &mut problem.points[taking.point];
        point.normal += taking.row.impulse;
        problem.patches[taking.patch].tangential += taking.rubbed;
        if taking.bounces {
            // The point has left the surface and carries nothing.
            point.normal_impulse = 0.0;
            let patch = &mut problem.patches[taking.patch];
            (patch.friction_impulse, patch.twist_impulse) = (Vec3::ZERO, 0.0);
            patch.rolling_impulse = Vec3::ZERO;
        }
    }
}

/// Sorts rows into groups. The rows of a group share movable bodies, directly or through others.
fn group(rows: &mut [Taking], bodies: &[Body]) {
    let mut groups = Groups::default();
    groups.begin(bodies.len());
    let moves = |body: usize| bodies[body].inverse_mass > 0.0;
    for taking in rows.iter() {
        if taking.bodies.into_iter().all(moves) {
            groups.link(taking.bodies.both(|body| body as u32));
        }
    }
    for taking in rows.iter_mut() {
        let moved = taking.bodies.into_iter().find(|&body| moves(body));
        taking.group = groups.first_of(moved.unwrap_or(0) as u32);
    }
    sort::by_key(rows, |taking| taking.group);
}

/// Whether all points of a group that bounce are of one patch.
fn of_one_patch(group: &[Taking]) -> bool {
    let mut patches = group
        .iter()
        .filter(|taking| taking.bounces)
        .map(|taking| taking.patch);
    let first = patches.next();
    patches.all(|patch| Some(patch) == first)
}

/// Bounces one group.
fn throw(group: &mut [Taking], points: &[PatchPoint], bodies: &mut [Body], pushes: &[[Vec3; 2]]) {
    let mut ends: Vec<usize> = group.iter().flat_map(|taking| taking.bodies).collect();
    sort::values(&mut ends);
    ends.dedup();
    let before: Vec<_> = ends
        .iter()
        .map(|&end| [bodies[end].linear, bodies[end].angular])
        .collect();
    let speeds = group.iter().filter(|taking| taking.bounces);
    let speeds = speeds.map(|taking| taking.leave.max(taking.stopped * taking.row.response));
    let fastest = speeds.fold(0.0, f32::max);
    if !of_one_patch(group) {
        for taking in group.iter_mut() {
            (taking.stopped, taking.held) = (0.0, Vec3::ZERO);
        }
    }
    for patch in group.chunk_by_mut(|a, b| a.patch == b.patch) {
        throw_together(patch, points, bodies);
    }
    for _ in 0..MAX_VISITS {
        let mut change = 0.0f32;
        for taking in group.iter_mut() {
            let missing = taking.leave - taking.speed(bodies);
            let given = taking.give(missing / taking.row.response, bodies);
            let rubbed = taking.rub(bodies);
            change = change.max(given.abs() * taking.row.response).max(rubbed);
        }
        if change < SETTLED_SHARE * fastest {
            break;
        }
    }
    let share = affordable(group, bodies, &ends, &before, pushes);
    if share < 1.0 {
        for (&end, before) in ends.iter().zip(&before) {
            let body = &mut bodies[end];
            body.linear = before[0] + share * (body.linear - before[0]);
            body.angular = before[1] + share * (body.angular - before[1]);
        }
        for taking in group {
            taking.row.impulse *= share;
            taking.rubbed *= share;
        }
    }
}

fn rows(problem: &PatchProblem, bouncing: &[Bouncing], substeps: usize) -> Vec<Taking> {
    let mut rows = Vec::new();
    let mut next = bouncing.iter().peekable();
    let surface = |patch: usize| {
        let surfaces = problem.surfaces;
        let found = surfaces.binary_search_by_key(&(patch as u32), |(patch, _)| *patch);
        found.map_or(Vec3::ZERO, |i| surfaces[i].1)
    };
    for (number, patch) in problem.patches.iter().enumerate() {
        let normal: f32 = problem.points[patch.range()]
            .iter()
            .map(|point| point.normal)
            .sum();
        let share = if normal > 0.0 { 1.0 / normal } else { 0.0 };
        for index in patch.range() {
            let bounces = next.next_if(|bouncing| bouncing.point == index);
            let point = &problem.points[index];
            if point.normal <= 0.0 && bounces.is_none() {
                continue;
            }
            let bodies = patch.bodies.both(|body| body as usize);
            let arms = patch.arms.both(|arm| arm + point.offset);
            let response = |i: usize| problem.bodies[bodies[i]].response(patch.normal, arms[i]);
            let response = response(0) + response(1);
            if response <= 0.0 {
                // Locked axes keep both bodies from moving along the normal.
                continue;
            }
            rows.push(Taking {
                row: ContactRow {
                    direction: patch.normal,
                    arms,
                    response,
                    impulse: 0.0,
                },
                point: index,
                patch: number,
                group: 0,
                bodies,
                bounces: bounces.is_some(),
                leave: bounces.map_or(0.0, |bouncing| bouncing.leave),
                least: match bounces {
                    Some(bouncing) if bouncing.leave > 0.0 => 0.0,
                    Some(_) => -point.normal,
                    None => -point.normal_impulse / substeps as f32,
                },
                friction: patch.friction,
                stopped: point.normal,
                held: share * point.normal * patch.tangential,
                rubbed: Vec3::ZERO,
                along: surface(number),
                yields: bounces.map_or(0.0, |_| {
                    let (t1, t2) = patch.normal.any_orthonormal_pair();
                    let both = [t1, t2].map(|t| {
                        let of = |i: usize| problem.bodies[bodies[i]].response(t, arms[i]);
                        of(0) + of(1)
                    });
                    // The larger of the two principal ones is at most their sum.
                    both[0] + both[1]
                }),
            });
        }
    }
    rows
}

/// Bounces a patch as a whole: its points get impulses in the proportion in which they were stopped, with the speed that fits them best. So
/// a body that landed on a face leaves it as it came.
fn throw_together(patch: &mut [Taking], points: &[PatchPoint], bodies: &mut [Body]) {
    let (mut push, mut turns, mut missing) = (0.0, [Vec3::ZERO; 2], 0.0);
    for taking in patch.iter().filter(|taking| taking.bounces) {
        let given = points[taking.point].normal;
        push += given;
        for (turn, arm) in turns.iter_mut().zip(taking.row.arms) {
            *turn += arm.cross(given * taking.row.direction);
        }
        missing += given * (taking.leave - taking.speed(bodies));
    }
    let first = &patch[0];
    let [a, b] = first.bodies.both(|body| &bodies[body]);
    let masses = [a, b].both(|body| body.inverse_mass_along(first.row.direction));
    let takes = push * push * (masses[0] + masses[1])
        + turns[0].dot(a.inverse_inertia * turns[0])
        + turns[1].dot(b.inverse_inertia * turns[1]);
    if missing > 0.0 && takes > 0.0 {
        for taking in patch.iter_mut().filter(|taking| taking.bounces) {
            taking.give(missing / takes * points[taking.point].normal, bodies);
        }
    }
}

/// The share of a bounce for which the energy, kinetic and potential, is at most that before the step. `before` holds the velocities of the
/// bodies in `ends` before the bounce.
fn affordable(
    group: &[Taking],
    bodies: &[Body],
    ends: &[usize],
    before: &[[Vec3; 2]],
    pushes: &[[Vec3; 2]],
) -> f32 {
    let moves = |end: &Body| end.inverse_mass > 0.0;
    let driven = |end: &Body| !moves(end) && end.start != [Vec3::ZERO; 2];
    if ends.iter().any(|&end| driven(&bodies[end])) {
        // A driven body does work.
        return 1.0;
    }
    // E(s) = E(0) + s d + s² q.
    let (mut d, mut q) = (0.0f64, 0.0f64);
    for taking in group {
        let was = taking.bodies.both(|body| {
            let end = ends.binary_search(&body).expect("all ends were collected");
            before[end]
        });
        let was = relative(taking.row.arms, was);
        d += taking.impulse().dot(was) as f64;
        q += 0.5 * taking.impulse().dot(taking.velocity(bodies) - was) as f64;
    }
    let spare: f64 = ends
        .iter()
        .zip(before)
        .filter(|(end, _)| moves(&bodies[**end]))
        .map(|(&end, before)| spent(&bodies[end], *before, pushes[end]))
        .sum();
    if d + q <= spare || q <= 0.0 {
        return 1.0;
    }
    let root = (d * d + 4.0 * q * spare).max(0.0).sqrt();
    ((root - d) / (2.0 * q)).clamp(0.0, 1.0) as f32
}

/// The energy that contacts have taken from a body in the substeps, J: its energy before the step, plus the work of forces, less its energy
/// now.
fn spent(body: &Body, now: [Vec3; 2], push: [Vec3; 2]) -> f64 {
    let inertia = body.inertia();
    let product = |[v, w]: [DVec3; 2], [x, y]: [DVec3; 2]| {
        v.dot(x) / body.inverse_mass as f64 + w.dot(inertia * y)
    };
    let [start, now, push, moved] =
        [body.start, now, push, body.motion.unwrap_or(now)].map(|v| v.both(|v| v.as_dvec3()));
    0.5 * (product(start, start) - product(now, now)) + product(push, moved)
}
