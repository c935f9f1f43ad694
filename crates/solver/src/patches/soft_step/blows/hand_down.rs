//! Hands down the momentum of falling bodies. From the top, each body is stopped by the bodies below it as if those could not yield, and
//! passes on the impulse that this takes.
//!
//! Sweeps go from the ground up, and carry a blow down a column by one body per sweep. Where a heavy body falls on a light one, they need
//! more sweeps by the ratio of the masses. Handing down stops a column of any masses in one pass. In other structures it gives the sweeps
//! their start.
//!
//! Only momentum from above is handed down. A ball that hits a wall from the side wedges bricks between their neighbours. Stopped as if
//! those could not yield, the bricks would drag the courses along.

use super::hot::{Hot, Place};
use super::{BLOW_SPEED, SETTLED_CHANGE};
use crate::Both;
use crate::contact_row::add_to;
use crate::groups::Groups;
use crate::lanes::{F32xN, State};
use crate::patches::soft_step::island::Island;
use crate::patches::soft_step::start::upright::{up, upper};
use crate::{Body, PatchProblem};
use glam::{Vec3, Vec4};

/// A body falls if at least this share of its squared velocity is downwards.
const DOWNWARD_SHARE: f32 = 0.5;

/// Upper bound of visits to the points under one body.
const MAX_VISITS: usize = 8;

/// Visits end when none changes the velocity by more than this, m/s.
const SETTLED_VELOCITY: f32 = 1e-3;

/// Data that is kept from substep to substep.
#[derive(Default)]
pub struct HandDown {
    /// Bodies that lie on another one, from the top. Found in the first blow of a step.
    order: Option<Vec<u32>>,
    /// By body: it is stopped, and passes on the impulse.
    stops: Vec<bool>,
    /// By body: its velocity after the stop.
    stopped: Vec<State>,
    rows: Vec<Support>,
    /// Velocities and impulses before the pass. They are restored where handing down has gained energy.
    before: Vec<State>,
    impulses: Vec<Before>,
    /// Groups of bodies that have handed impulses to each other.
    linked: Groups,
    /// By the first body of each group: gain of energy, J.
    gains: Vec<f64>,
}

/// The impulse of a point before the pass, N·s.
struct Before {
    body: u32,
    point: u32,
    lane: u32,
    impulse: f32,
}

/// A point of contact under a body. The body below cannot yield.
struct Support {
    /// Unit vector along which the point pushes the body, and its moment about the centre of mass, m.
    push: [Vec3; 2],
    /// The change of the body's velocity by an impulse of 1 N·s, m/s and rad/s.
    answer: [Vec3; 2],
    /// Inverse effective mass, 1/kg; positive.
    response: f32,
    /// Its impulse, N·s.
    impulse: f32,
    below: u32,
    /// From the centre of mass of the body below to the point, m.
    arm_below: Vec3,
    /// The index of the point that holds its impulse.
    point: u32,
    lane: u32,
    /// The smallest velocity along the normal that the point allows the body, m/s.
    least: f32,
    /// The impulse before the pass, N·s.
    before: f32,
}

impl Support {
    /// The velocity that the body lacks at the point, m/s.
    #[inline]
    fn lack(&self, [linear, angular]: [Vec3; 2]) -> f32 {
        self.least - (self.push[0].dot(linear) + self.push[1].dot(angular))
    }

    /// Adds to its impulse, which stays ≥ 0. Returns the amount that was added, N·s.
    #[inline]
    fn give(&mut self, impulse: f32, velocity: &mut [Vec3; 2]) -> f32 {
        let before = self.impulse;
        self.impulse = (before + impulse).max(0.0);
        let given = self.impulse - before;
        add_to(velocity, self.answer.both(|answer| given * answer));
        given
    }
}

/// The patches on which a body lies, each with the body below.
fn beneath<'a, L: F32xN>(
    hot: &'a Hot<L>,
    problem: &'a PatchProblem,
    body: u32,
) -> impl Iterator<Item = (&'a Place, u32)> {
    let up = up(problem);
    // Bodies that nothing moves hand nothing down.
    let moves = problem.bodies[body as usize].inverse_mass > 0.0;
    let places = hot.places_of(body).iter().filter(move |_| moves);
    places.filter_map(move |place| {
        let patch = &problem.patches[place.patch as usize];
        (upper(patch, up) == Some(place.side as usize))
            .then(|| (place, patch.bodies[1 - place.side as usize]))
    })
}

/// Bodies that lie on another one, from the top, without those that lie on each other in a ring.
fn from_the_top<L: F32xN>(hot: &Hot<L>, problem: &PatchProblem) -> Vec<u32> {
    let count = problem.bodies.len() as u32;
    let mut above = vec![0u32; count as usize];
    for body in 0..count {
        beneath(hot, problem, body).for_each(|(_, below)| above[below as usize] += 1);
    }
    let mut order: Vec<u32> = (0..count)
        .filter(|&body| above[body as usize] == 0)
        .collect();
    let mut next = 0;
    while let Some(&body) = order.get(next) {
        next += 1;
        for (_, below) in beneath(hot, problem, body) {
            above[below as usize] -= 1;
            if above[below as usize] == 0 {
                order.push(below);
            }
        }
    }
    order.retain(|&body| problem.bodies[body as usize].inverse_mass > 0.0);
    order
}

impl HandDown {
    /// Begins a step whose contacts are new.
    pub fn begin(&mut self) {
        self.order = None;
    }

    /// Hands down the momentum of falling bodies, in a substep of length 1/`rate`. Bodies that get much of it become hot.
    pub fn run<L: F32xN>(
        &mut self,
        problem: &PatchProblem,
        island: &mut Island<L>,
        hot: &mut Hot<L>,
        rate: f32,
    ) {
        if !self.find_stopping_bodies(problem, island, hot) {
            return;
        }
        let order = self
            .order
            .take()
            .unwrap_or_else(|| from_the_top(hot, problem));
        self.find_stopped(&order, problem, island, hot, rate);
        self.before.clone_from(&island.velocities);
        self.impulses.clear();
        self.linked.begin(problem.bodies.len());
        for &body in &order {
            if !self.stops[body as usize] {
                continue;
            }
            hot.heat(body);
            hot.hold(body);
            self.find_rows(body, problem, island, hot, rate);
            let mut velocity = island.velocities[body as usize].both(Vec4::truncate);
            stop(
                &mut self.rows,
                &problem.bodies[body as usize],
                &mut velocity,
            );
            island.velocities[body as usize] = velocity.both(|v| v.extend(0.0));
            self.hand_on(body, problem, island);
        }
        self.order = Some(order);
        self.take_back(problem, island);
    }

    /// Undoes the pass in groups that have gained energy. The bodies below can yield after all, and the gain would throw bodies.
    fn take_back<L: F32xN>(&mut self, problem: &PatchProblem, island: &mut Island<L>) {
        self.gains.clear();
        self.gains.resize(problem.bodies.len(), 0.0);
        for (body, of) in (0..).zip(problem.bodies.iter()) {
            let [now, before] = [&island.velocities, &self.before].both(|list| list[body as usize]);
            if now != before {
                let gain = kinetic_energy(of, &now) - kinetic_energy(of, &before);
                self.gains[self.linked.first_of(body) as usize] += gain;
            }
        }
        for body in 0..problem.bodies.len() as u32 {
            if self.gains[self.linked.first_of(body) as usize] > 0.0 {
                island.velocities[body as usize] = self.before[body as usize];
            }
        }
        for before in &self.impulses {
            if self.gains[self.linked.first_of(before.body) as usize] > 0.0 {
                let point = &mut island.points[before.point as usize];
                point.impulse[before.lane as usize] = before.impulse;
            }
        }
    }

    /// Finds the falling bodies that are hot or lie on a hot body. Returns whether there are any.
    fn find_stopping_bodies<L: F32xN>(
        &mut self,
        problem: &PatchProblem,
        island: &Island<L>,
        hot: &Hot<L>,
    ) -> bool {
        let up = up(problem);
        self.stops.clear();
        self.stops.resize(problem.bodies.len(), false);
        let falls = |body: u32| {
            let velocity = island.before[body as usize][0].truncate();
            let down = -velocity.dot(up);
            let falls =
                down > BLOW_SPEED && down * down > DOWNWARD_SHARE * velocity.length_squared();
            falls && problem.bodies[body as usize].inverse_mass > 0.0
        };
        let mut any = false;
        let mut stop = |body: u32| {
            if falls(body) {
                self.stops[body as usize] = true;
                any = true;
            }
        };
        for &body in &hot.bodies {
            stop(body);
            for place in hot.places_of(body) {
                let patch = &problem.patches[place.patch as usize];
                let above = 1 - place.side as usize;
                if upper(patch, up) == Some(above) {
                    stop(patch.bodies[above]);
                }
            }
        }
        any
    }

    /// Finds the velocity of each body after the stop, from the ground up. Hot bodies below a falling one are included.
    fn find_stopped<L: F32xN>(
        &mut self,
        order: &[u32],
        problem: &PatchProblem,
        island: &Island<L>,
        hot: &Hot<L>,
        rate: f32,
    ) {
        for &body in order {
            if self.stops[body as usize] {
                for (_, below) in beneath(hot, problem, body) {
                    self.stops[below as usize] |= hot.is(below);
                }
            }
        }
        self.stopped.clone_from(&island.velocities);
        for &body in order.iter().rev() {
            if self.stops[body as usize] {
                self.find_rows(body, problem, island, hot, rate);
                let mut velocity = self.stopped[body as usize].both(Vec4::truncate);
                stop(
                    &mut self.rows,
                    &problem.bodies[body as usize],
                    &mut velocity,
                );
                self.stopped[body as usize] = velocity.both(|v| v.extend(0.0));
            }
        }
    }

    /// Applies the impulses of the rows to their points and to the bodies below.
    fn hand_on<L: F32xN>(&mut self, body: u32, problem: &PatchProblem, island: &mut Island<L>) {
        for support in &self.rows {
            let given = support.impulse - support.before;
            if given == 0.0 {
                continue;
            }
            island.points[support.point as usize].impulse[support.lane as usize] = support.impulse;
            self.impulses.push(Before {
                body,
                point: support.point,
                lane: support.lane,
                impulse: support.before,
            });
            let below = &problem.bodies[support.below as usize];
            if below.inverse_mass > 0.0 {
                self.linked.link([body, support.below]);
                let answer = below.answer(-given * support.push[0], support.arm_below);
                let state = &mut island.velocities[support.below as usize];
                for (velocity, change) in state.iter_mut().zip(answer) {
                    *velocity += change.extend(0.0);
                }
                self.stops[support.below as usize] |=
                    given.abs() * below.inverse_mass > SETTLED_CHANGE;
            }
        }
    }

    /// Finds the points under a body.
    fn find_rows<L: F32xN>(
        &mut self,
        body: u32,
        problem: &PatchProblem,
        island: &Island<L>,
        hot: &Hot<L>,
        rate: f32,
    ) {
        self.rows.clear();
        let stops = &problem.bodies[body as usize];
        for (place, below) in beneath(hot, problem, body) {
            let patch = &problem.patches[place.patch as usize];
            let side = place.side as usize;
            let normal = if side == 0 {
                patch.normal
            } else {
                -patch.normal
            };
            let first = island.blocks[place.block as usize].first;
            let [linear, angular] = self.stopped[below as usize].both(Vec4::truncate);
            for (point, offset) in (first..).zip(&problem.points[patch.range()]) {
                let [arm, arm_below] =
                    [side, 1 - side].both(|side| patch.arms[side] + offset.offset);
                let found = &island.points[point as usize];
                let lane = place.lane as usize;
                let push = [normal, arm.cross(normal)];
                let answer = stops.answer(normal, arm);
                let response = push[0].dot(answer[0]) + push[1].dot(answer[1]);
                if response <= 0.0 {
                    continue;
                }
                self.rows.push(Support {
                    push,
                    answer,
                    response,
                    impulse: found.impulse[lane],
                    below,
                    arm_below,
                    point,
                    lane: place.lane,
                    // The body may still close the gap.
                    least: normal.dot(linear + angular.cross(arm_below)) - found.gap[lane] * rate,
                    before: found.impulse[lane],
                });
            }
        }
    }
}

/// Kinetic energy, J.
fn kinetic_energy(body: &Body, velocity: &State) -> f64 {
    let [linear, angular] = velocity.both(|v| v.truncate().as_dvec3());
    let inertia = body.inertia();
    0.5 * (linear.length_squared() / body.inverse_mass as f64 + angular.dot(inertia * angular))
}

/// Stops a body by the points under it.
fn stop(rows: &mut [Support], body: &Body, velocity: &mut [Vec3; 2]) {
    // All points that lack velocity first get the same impulse. Visits alone would let the first point turn the body.
    let was = *velocity;
    let lacking = |support: &Support| support.lack(was) > 0.0;
    let (mut missing, mut force, mut moment) = (0.0, Vec3::ZERO, Vec3::ZERO);
    for support in rows.iter().filter(|support| lacking(support)) {
        missing += support.lack(was);
        force += support.push[0];
        moment += support.push[1];
    }
    let turned = moment.dot(body.inverse_inertia * moment);
    let response = body.inverse_mass * (force * body.free_axes).length_squared() + turned;
    if missing > 0.0 && response > 0.0 {
        for support in rows.iter_mut().filter(|support| lacking(support)) {
            support.give(missing / response, velocity);
        }
    }
    for _ in 0..MAX_VISITS {
        let mut most = 0f32;
        for support in rows.iter_mut() {
            let given = support.give(support.lack(*velocity) / support.response, velocity);
            most = most.max(given.abs() * support.response);
        }
        if most < SETTLED_VELOCITY {
            break;
        }
    }
}
