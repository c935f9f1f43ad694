//! A grab holds a body with limited force and is solved with its contacts. It consists of two constraints to the world, on the velocity of
//! a held point and on the spin, with limited impulses.
//!
//! A grab pulls its point towards a target. It asks for the speed with which the point gets there in time, by a law of first order, but no
//! faster than it could still brake. It holds that speed with any force up to its own limit, so a load does not make it sag at any step
//! length. A body that is pressed against others stays where it is: the grab does not ask for motions that [walls](super::walls) do not
//! allow.

use super::Body;
use super::body::trace;
use super::lanes::State;
use super::walls::{self, Wall};
use crate::Both;
use glam::{Mat3, Vec3, Vec4};
use std::cell::Cell;

/// The share of a grab's strength that it reserves for braking; the rest may carry a load.
const BRAKES: f32 = 0.5;

/// The inverse mass of a body along an axis that is locked, as a share of its inverse mass. With none, effective masses would be infinite.
const RIGID: f32 = 1e-6;

/// The largest rotation of a body by a pull in one step, rad, if the torque of the grab cannot stop as much. Within a step a rotating body
/// moves as if along a tangent; with larger rotations, a body that is pulled by a corner would be thrown back and forth.
const TURN: f32 = 0.5;

/// The largest rotation of a body near walls in one step, rad: a body that turns farther would pass through surfaces for which no contacts
/// were detected.
const TURN_NEAR_WALLS: f32 = 0.25;

/// The input of a solver for a grab, and its results. World axes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GrabConstraint {
    /// Index of the held body among the problem's.
    pub body: u32,
    /// From the centre of mass to the held point, m.
    pub arm: Vec3,
    /// From the target of the point to its position, m.
    pub error: Vec3,
    /// From the target rotation of the body to its rotation, rad; zero if the grab only stops the spin.
    pub turn: Vec3,
    /// Masks of the world axes along which the grab pulls, and about which it turns: 1 for these axes, 0 for others.
    pub axes: [Vec3; 2],
    /// Time in which an error decreases to 1/e, s.
    pub response: f32,
    /// The largest speed of the point, m/s.
    pub max_speed: f32,
    /// The largest force, N.
    pub max_force: f32,
    /// The largest torque, N·m.
    pub max_torque: f32,
    /// Force on the body, N. In: the warm start. Out: the result.
    pub force: Vec3,
    /// Torque on the body, N·m. In: the warm start. Out: the result.
    pub torque: Vec3,
}

/// A grab during a step or substep of `h` s.
#[derive(Clone, Debug)]
pub(super) struct ActiveGrab {
    pub grab: GrabConstraint,
    h: f32,
    /// Time in which an error decreases to 1/e, s.
    time: f32,
    /// The largest spin from its pull and from its torque, rad/s.
    fastest_turns: [f32; 2],
    /// Wanted velocity of the point and wanted spin, m/s and rad/s.
    wanted: [Vec3; 2],
    /// Effective masses of the point and of the spin.
    masses: [Mat3; 2],
    /// Lower bounds of the effective masses over all directions.
    least: [f32; 2],
    inverse_mass: Vec3,
    inverse_inertia: Mat3,
    /// Factor of √distance for the largest speed at which it can still brake, for the point and the spin.
    braking: [f32; 2],
    /// Impulses over `h`, N·s and N·m·s.
    pub impulse: [Vec3; 2],
    /// The points at which its body meets walls.
    walls: Vec<Wall>,
}

impl ActiveGrab {
    pub fn new(grab: &GrabConstraint, body: &Body, h: f32) -> Self {
        let arm = grab.arm;
        let skew = Mat3::from_cols(arm.cross(Vec3::X), arm.cross(Vec3::Y), arm.cross(Vec3::Z));
        let inertia = body.inverse_inertia;
        let inverse_mass = body.inverse_mass * body.free_axes;
        let mut response = Mat3::from_diagonal(inverse_mass) + skew.transpose() * inertia * skew;
        if body.is_locked() {
            // Along an axis that is locked, and about which the arm does not turn it, the point does not move.
            response += Mat3::from_diagonal(Vec3::splat(RIGID * body.inverse_mass));
        }
        let eases = [body.inverse_mass, trace(&inertia) / 3.0];
        let strengths = [grab.max_force, grab.max_torque];
        let [reach, spin] = [(response, grab.axes[0]), (inertia, grab.axes[1])].both(within);
        let mut held = Self {
            grab: *grab,
            h,
            time: grab.response.max(h),
            fastest_turns: [f32::INFINITY; 2],
            wanted: [Vec3::ZERO; 2],
            masses: [(reach, grab.axes[0]), (spin, grab.axes[1])].both(inverse_within),
            least: [reach, spin].both(|w| trace(&w).max(f32::MIN_POSITIVE).recip()),
            inverse_mass,
            inverse_inertia: inertia,
            braking: std::array::from_fn(|i| (2.0 * BRAKES * strengths[i] * eases[i]).sqrt()),
            impulse: [
                h * grab.force * grab.axes[0],
                h * grab.torque * grab.axes[1],
            ],
            walls: Vec::new(),
        };
        held.aim([Vec3::ZERO; 2]);
        held
    }

    /// Adapts the grab to a step of `dt` s, which may have several substeps, and to the walls of its body. Contacts and arms are those of
    /// the beginning of the step, so an error takes at least `dt` to fade, and the body turns by no more than [`TURN`] or
    /// [`TURN_NEAR_WALLS`].
    pub fn in_step(self, dt: f32, walls: Vec<Wall>) -> Self {
        let (pulled, turned) = match walls.is_empty() {
            true => (TURN / dt, f32::INFINITY),
            false => (TURN_NEAR_WALLS / dt, TURN_NEAR_WALLS / dt),
        };
        let ease = trace(&self.inverse_inertia) / 3.0;
        let holds = self.grab.max_torque * ease * dt >= pulled;
        let mut held = Self {
            time: self.time.max(dt),
            fastest_turns: [if holds { f32::INFINITY } else { pulled }, turned],
            walls,
            ..self
        };
        held.aim([Vec3::ZERO; 2]);
        held
    }

    /// Updates the walls and the wanted velocities in a substep, from the motions of bodies since detection. Contacts correct no faster
    /// than `fastest`, m/s.
    fn aim_among(&mut self, motions: &[Cell<State>], fastest: f32) {
        let body = self.grab.body;
        for wall in &mut self.walls {
            wall.aim(body, motions, self.h, fastest);
        }
        self.aim(motions[body as usize].get().map(Vec4::truncate));
    }

    /// Sets the wanted velocities, after its body has moved and turned since the step began.
    pub fn aim(&mut self, [moved, turned]: [Vec3; 2]) {
        let GrabConstraint {
            arm,
            error,
            turn,
            axes,
            ..
        } = self.grab;
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
        let velocity = towards(error, self.braking[0], self.grab.max_speed);
        let turned = self.inverse_inertia * arm.cross(self.masses[0] * velocity);
        let share = match turned.length() > self.fastest_turns[0] {
            true => self.fastest_turns[0] / turned.length(),
            false => 1.0,
        };
        self.wanted = [velocity * share, spin];
    }

    /// Applies its warm-start impulses to its body.
    pub fn start(&self, velocities: &[Cell<State>]) {
        add(&velocities[self.grab.body as usize], self.warm_start());
    }

    /// Change of the linear and angular velocity of its body by its impulses.
    pub fn warm_start(&self) -> [Vec3; 2] {
        self.answer(self.impulse)
    }

    /// Changes its impulses towards the wanted velocities; `other` returns the velocities of other bodies. Returns the change of the body's
    /// velocity, and Σ W Δλ², J.
    pub fn relax(
        &mut self,
        [linear, angular]: [Vec3; 2],
        other: impl Fn(u32) -> [Vec3; 2],
    ) -> ([Vec3; 2], f32) {
        let wanted = self.allowed([linear, angular], other);
        let spun = self.give(1, wanted[1] - angular);
        let turned = self.answer([Vec3::ZERO, spun]);
        let velocity = linear + (angular + turned[1]).cross(self.grab.arm);
        let pushed = self.give(0, wanted[0] - velocity);
        let moved = self.answer([pushed, Vec3::ZERO]);
        let change = spun.dot(turned[1]) + pushed.dot(moved[0] + moved[1].cross(self.grab.arm));
        ([moved[0], turned[1] + moved[1]], change)
    }

    /// The wanted velocities, limited by walls.
    fn allowed(
        &mut self,
        [linear, angular]: [Vec3; 2],
        other: impl Fn(u32) -> [Vec3; 2],
    ) -> [Vec3; 2] {
        if self.walls.is_empty() {
            return self.wanted;
        }
        // A grab that cannot turn its body leaves its spin free, and also its motion along axes other than its own.
        let GrabConstraint { arm, axes, .. } = self.grab;
        let turns = match self.grab.max_torque > 0.0 {
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

    /// [`relax`](Self::relax) with the velocities of all bodies. Returns Σ W Δλ², J.
    pub fn visit(&mut self, velocities: &[Cell<State>]) -> f32 {
        let of = |body: u32| velocities[body as usize].get().map(Vec4::truncate);
        let (moved, change) = self.relax(of(self.grab.body), of);
        add(&velocities[self.grab.body as usize], moved);
        change
    }

    /// [`visit`](Self::visit) in a substep, after an update from the motions of bodies. Contacts correct no faster than `fastest`, m/s.
    pub fn visit_among(
        &mut self,
        velocities: &[Cell<State>],
        motions: &[Cell<State>],
        fastest: f32,
    ) -> f32 {
        self.aim_among(motions, fastest);
        self.visit(velocities)
    }

    /// The change that a visit would make without earlier impulses and without walls: Σ W Δλ², J.
    pub fn missing(mut self, velocity: [Vec3; 2]) -> f32 {
        self.impulse = [Vec3::ZERO; 2];
        self.walls.clear();
        self.relax(velocity, |_| [Vec3::ZERO; 2]).1
    }

    /// The grab with its resulting force and torque.
    pub fn found(&self) -> GrabConstraint {
        GrabConstraint {
            force: self.impulse[0] / self.h,
            torque: self.impulse[1] / self.h,
            ..self.grab
        }
    }

    /// Adds to an impulse to correct a missing velocity, as far as its strength allows. Returns the amount that was added.
    fn give(&mut self, i: usize, missing: Vec3) -> Vec3 {
        let most = [self.grab.max_force, self.grab.max_torque][i] * self.h;
        let before = self.impulse[i];
        let mut after = before + self.masses[i] * missing;
        if after.length_squared() > most * most {
            // At its limit, the impulse points in the direction of the missing velocity; an effective mass would turn it.
            let missing = missing * self.grab.axes[i];
            after = (before + self.least[i] * missing).clamp_length_max(most);
        }
        self.impulse[i] = after;
        after - before
    }

    fn answer(&self, [push, twist]: [Vec3; 2]) -> [Vec3; 2] {
        [
            self.inverse_mass * push,
            self.inverse_inertia * (self.grab.arm.cross(push) + twist),
        ]
    }
}

fn add(velocity: &Cell<State>, [linear, angular]: [Vec3; 2]) {
    let [moves, turns] = velocity.get();
    velocity.set([moves + linear.extend(0.0), turns + angular.extend(0.0)]);
}

/// The restriction of a response matrix to some axes: rows and columns of the others are zero.
fn within((answer, axes): (Mat3, Vec3)) -> Mat3 {
    Mat3::from_cols(
        answer.x_axis * axes * axes.x,
        answer.y_axis * axes * axes.y,
        answer.z_axis * axes * axes.z,
    )
}

/// The inverse of such a restriction, with zero rows and columns for the other axes.
fn inverse_within((answer, axes): (Mat3, Vec3)) -> Mat3 {
    if axes == Vec3::ONE {
        return inverse(answer);
    }
    let free = Mat3::from_diagonal(trace(&answer) * (Vec3::ONE - axes));
    within((inverse(answer + free), axes))
}

/// The inverse of a matrix. Scaling keeps the determinant of a small one from underflow. Zero for a body that does not react to impulses.
fn inverse(matrix: Mat3) -> Mat3 {
    let scale = trace(&matrix);
    if scale <= 0.0 {
        return Mat3::ZERO;
    }
    (matrix * scale.recip()).inverse() * scale.recip()
}
