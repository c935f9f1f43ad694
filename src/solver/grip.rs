//! A hand on a body, solved with its contacts: two constraints to the world, on the velocity of a held point and on the spin, whose
//! impulses are limited.
//!
//! A hand wants its point to be elsewhere, and asks for the speed with which it would get there in time, by a law of first order, but
//! no faster than it could still brake. That speed is held to with whatever force it takes, up to the hand's own; so a load does not make it sag,
//! whatever the step, and what a body is pressed against holds it: it does not ask for what [walls](super::walls) do not allow.

use super::Body;
use super::body::trace;
use super::lanes::State;
use super::walls::{self, Wall};
use glam::{Mat3, Vec3, Vec4};
use std::cell::Cell;

/// The share of a hand's strength that it counts on for braking; the rest may be bearing a load.
const BRAKES: f32 = 0.5;

/// The farthest that a pull turns a body in one step, rad, if the hand's torque cannot stop as much. Within a step what turns moves as if
/// along a tangent; farther, and what is pulled by a corner would be thrown to and fro.
const TURN: f32 = 0.5;

/// The farthest that a hand turns a body near walls in one step, rad: what turns farther would be through what contacts did not see coming.
const TURN_NEAR_WALLS: f32 = 0.25;

/// What a solver is given of a hand, and what it finds. World axes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Grip {
    /// Index of the held body among the problem's.
    pub body: u32,
    /// From the centre of mass to the held point, m.
    pub arm: Vec3,
    /// From where the point should be to where it is, m.
    pub error: Vec3,
    /// The turn from how the body should be turned to how it is, rad; nothing where it only shall not spin.
    pub turn: Vec3,
    /// One for each axis of the world along which it pulls, and zero for the others; the same of the axes about which it turns.
    pub axes: [Vec3; 2],
    /// Time in which an error fades to 1/e, s.
    pub response: f32,
    /// The fastest that it goes, m/s.
    pub max_speed: f32,
    /// N
    pub max_force: f32,
    /// N·m
    pub max_torque: f32,
    /// On the body, N: what to start from, and what was found.
    pub force: Vec3,
    /// The same of its moment, N·m.
    pub torque: Vec3,
}

/// A grip in a step, or in a substep, of `h` s.
#[derive(Clone, Debug)]
pub(super) struct Held {
    pub grip: Grip,
    h: f32,
    /// Time in which an error fades to 1/e, s.
    time: f32,
    /// The fastest that it turns the body by its pull and by its torque, rad/s.
    fastest_turns: [f32; 2],
    /// Velocity of the point and spin that are asked for, m/s and rad/s.
    wanted: [Vec3; 2],
    /// Effective masses of the point and of the spin.
    masses: [Mat3; 2],
    /// The same in the direction in which it is least, at most.
    least: [f32; 2],
    inverse_mass: f32,
    inverse_inertia: Mat3,
    /// The fastest that it may go and still brake, from so far away: the factor of √distance, for the point and the spin.
    braking: [f32; 2],
    /// N·s and N·m·s in `h`.
    pub impulse: [Vec3; 2],
    /// Where its body meets what it cannot be pulled through.
    walls: Vec<Wall>,
}

impl Held {
    pub fn new(grip: &Grip, body: &Body, h: f32) -> Self {
        let arm = grip.arm;
        let skew = Mat3::from_cols(arm.cross(Vec3::X), arm.cross(Vec3::Y), arm.cross(Vec3::Z));
        let inertia = body.inverse_inertia;
        let response =
            Mat3::from_diagonal(Vec3::splat(body.inverse_mass)) + skew.transpose() * inertia * skew;
        let eases = [body.inverse_mass, trace(&inertia) / 3.0];
        let strengths = [grip.max_force, grip.max_torque];
        let [reach, spin] = [(response, grip.axes[0]), (inertia, grip.axes[1])].map(within);
        let mut held = Self {
            grip: *grip,
            h,
            time: grip.response.max(h),
            fastest_turns: [f32::INFINITY; 2],
            wanted: [Vec3::ZERO; 2],
            masses: [(reach, grip.axes[0]), (spin, grip.axes[1])].map(inverse_within),
            least: [reach, spin].map(|w| trace(&w).max(f32::MIN_POSITIVE).recip()),
            inverse_mass: body.inverse_mass,
            inverse_inertia: inertia,
            braking: std::array::from_fn(|i| (2.0 * BRAKES * strengths[i] * eases[i]).sqrt()),
            impulse: [
                h * grip.force * grip.axes[0],
                h * grip.torque * grip.axes[1],
            ],
            walls: Vec::new(),
        };
        held.aim([Vec3::ZERO; 2]);
        held
    }

    /// The same in a step of `dt` s, which may have several substeps, of a body that meets walls. Contacts and arms are those of the step's
    /// beginning, so an error does not fade faster than within it, and it turns the body by no more than [`TURN`] or [`TURN_NEAR_WALLS`].
    pub fn in_step(self, dt: f32, walls: Vec<Wall>) -> Self {
        let (pulled, turned) = match walls.is_empty() {
            true => (TURN / dt, f32::INFINITY),
            false => (TURN_NEAR_WALLS / dt, TURN_NEAR_WALLS / dt),
        };
        let ease = trace(&self.inverse_inertia) / 3.0;
        let holds = self.grip.max_torque * ease * dt >= pulled;
        let mut held = Self {
            time: self.time.max(dt),
            fastest_turns: [if holds { f32::INFINITY } else { pulled }, turned],
            walls,
            ..self
        };
        held.aim([Vec3::ZERO; 2]);
        held
    }

    /// Brings its walls up to date, in a substep before which bodies have moved and turned by so much; contacts correct no faster than
    /// `fastest`, m/s. Then as [`aim`](Self::aim).
    fn aim_among(&mut self, motions: &[Cell<State>], fastest: f32) {
        let body = self.grip.body;
        for wall in &mut self.walls {
            wall.aim(body, motions, self.h, fastest);
        }
        self.aim(motions[body as usize].get().map(Vec4::truncate));
    }

    /// Asks for the velocity that takes it where it should be, when it has moved and turned by so much since the step began.
    pub fn aim(&mut self, [moved, turned]: [Vec3; 2]) {
        let Grip {
            arm,
            error,
            turn,
            axes,
            ..
        } = self.grip;
        let time = self.time;
        let towards = |error: Vec3, braking: f32, fastest: f32| {
            let distance = error.length();
            let speed = (distance / time)
                .min(braking * distance.sqrt())
                .min(fastest);
            match distance > 0.0 {
                true => error * (-speed / distance),
                false => Vec3::ZERO,
            }
        };
        let error = (error + moved + turned.cross(arm)) * axes[0];
        let spin = match turn == Vec3::ZERO {
            true => Vec3::ZERO,
            false => towards(
                (turn + turned) * axes[1],
                self.braking[1],
                self.fastest_turns[1],
            ),
        };
        let velocity = towards(error, self.braking[0], self.grip.max_speed);
        let turned = self.inverse_inertia * arm.cross(self.masses[0] * velocity);
        let share = match turned.length() > self.fastest_turns[0] {
            true => self.fastest_turns[0] / turned.length(),
            false => 1.0,
        };
        self.wanted = [velocity * share, spin];
    }

    /// Lets its body feel the impulses that it starts with.
    pub fn start(&self, velocities: &[Cell<State>]) {
        add(&velocities[self.grip.body as usize], self.warm_start());
    }

    /// What its impulses do to the linear and angular velocity of its body.
    pub fn warm_start(&self) -> [Vec3; 2] {
        self.answer(self.impulse)
    }

    /// Changes its impulses to what the velocity of its body calls for, where `other` tells those of other bodies. What that does to the
    /// velocity, and Σ W Δλ², J.
    pub fn relax(
        &mut self,
        [linear, angular]: [Vec3; 2],
        other: impl Fn(u32) -> [Vec3; 2],
    ) -> ([Vec3; 2], f32) {
        let wanted = self.allowed([linear, angular], other);
        let spun = self.give(1, wanted[1] - angular);
        let turned = self.answer([Vec3::ZERO, spun]);
        let velocity = linear + (angular + turned[1]).cross(self.grip.arm);
        let pushed = self.give(0, wanted[0] - velocity);
        let moved = self.answer([pushed, Vec3::ZERO]);
        let change = spun.dot(turned[1]) + pushed.dot(moved[0] + moved[1].cross(self.grip.arm));
        ([moved[0], turned[1] + moved[1]], change)
    }

    /// What it asks for, as far as walls allow it.
    fn allowed(
        &mut self,
        [linear, angular]: [Vec3; 2],
        other: impl Fn(u32) -> [Vec3; 2],
    ) -> [Vec3; 2] {
        if self.walls.is_empty() {
            return self.wanted;
        }
        // A hand that cannot turn its body does not say how it spins, nor how it moves along other axes than its own.
        let Grip { arm, axes, .. } = self.grip;
        let turns = match self.grip.max_torque > 0.0 {
            true => axes[1],
            false => Vec3::ZERO,
        };
        let along = |axes: Vec3, wanted: Vec3, is: Vec3| axes * wanted + (Vec3::ONE - axes) * is;
        let spin = along(turns, self.wanted[1], angular);
        let point = along(axes[0], self.wanted[0], linear + angular.cross(arm));
        let mut motion = [point - spin.cross(arm), spin];
        let (mass, inertia) = (self.inverse_mass, self.inverse_inertia);
        let answer = |push: Vec3, at: Vec3| [mass * push, inertia * at.cross(push)];
        match walls::project(&mut self.walls, &mut motion, self.impulse[0], answer, other) {
            true => [motion[0] + motion[1].cross(arm), motion[1]],
            false => self.wanted,
        }
    }

    /// The same with the velocities of all bodies. Σ W Δλ², J.
    pub fn visit(&mut self, velocities: &[Cell<State>]) -> f32 {
        let of = |body: u32| velocities[body as usize].get().map(Vec4::truncate);
        let (moved, change) = self.relax(of(self.grip.body), of);
        add(&velocities[self.grip.body as usize], moved);
        change
    }

    /// The same in a substep before which bodies have moved and turned by so much; contacts correct no faster than `fastest`, m/s.
    pub fn visit_among(
        &mut self,
        velocities: &[Cell<State>],
        motions: &[Cell<State>],
        fastest: f32,
    ) -> f32 {
        self.aim_among(motions, fastest);
        self.visit(velocities)
    }

    /// What a visit would change if the hand had done nothing yet and there were no walls: Σ W Δλ², J.
    pub fn missing(mut self, velocity: [Vec3; 2]) -> f32 {
        self.impulse = [Vec3::ZERO; 2];
        self.walls.clear();
        self.relax(velocity, |_| [Vec3::ZERO; 2]).1
    }

    /// The grip with the forces found.
    pub fn found(&self) -> Grip {
        Grip {
            force: self.impulse[0] / self.h,
            torque: self.impulse[1] / self.h,
            ..self.grip
        }
    }

    /// Adds to an impulse what a velocity that is missing calls for, and its strength allows; how much was added.
    fn give(&mut self, i: usize, missing: Vec3) -> Vec3 {
        let most = [self.grip.max_force, self.grip.max_torque][i] * self.h;
        let before = self.impulse[i];
        let mut after = before + self.masses[i] * missing;
        if after.length_squared() > most * most {
            // All that it has it gives in the direction of what is missing; an effective mass would turn it.
            let missing = missing * self.grip.axes[i];
            after = (before + self.least[i] * missing).clamp_length_max(most);
        }
        self.impulse[i] = after;
        after - before
    }

    fn answer(&self, [push, twist]: [Vec3; 2]) -> [Vec3; 2] {
        [
            self.inverse_mass * push,
            self.inverse_inertia * (self.grip.arm.cross(push) + twist),
        ]
    }
}

fn add(velocity: &Cell<State>, [linear, angular]: [Vec3; 2]) {
    let [moves, turns] = velocity.get();
    velocity.set([moves + linear.extend(0.0), turns + angular.extend(0.0)]);
}

/// What an answer is to impulses along some axes only, seen along these: rows and columns of the others are zero.
fn within((answer, axes): (Mat3, Vec3)) -> Mat3 {
    Mat3::from_cols(
        answer.x_axis * axes * axes.x,
        answer.y_axis * axes * axes.y,
        answer.z_axis * axes * axes.z,
    )
}

/// The inverse of such an answer, with zero rows and columns for the other axes.
fn inverse_within((answer, axes): (Mat3, Vec3)) -> Mat3 {
    if axes == Vec3::ONE {
        return inverse(answer);
    }
    let free = Mat3::from_diagonal(trace(&answer) * (Vec3::ONE - axes));
    within((inverse(answer + free), axes))
}

/// Of a matrix of any size: the determinant of a small one would be nothing. Zero of what nothing moves.
fn inverse(matrix: Mat3) -> Mat3 {
    let scale = trace(&matrix);
    if scale <= 0.0 {
        return Mat3::ZERO;
    }
    (matrix * scale.recip()).inverse() * scale.recip()
}
