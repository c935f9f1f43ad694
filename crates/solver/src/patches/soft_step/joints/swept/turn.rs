//! Swept joints follow the motion of their bodies: how bodies have turned since the beginning of the step, and what of joints turns along.

use super::block::{AngularRow, JointBlock};
use crate::joint::Bend;
use crate::lanes::{F32xN, Kernel, SpatialVec, State, Symmetric, Vec3xN};
use std::cell::Cell;

/// Bodies side by side, one in each lane.
#[derive(Clone, Debug, Default)]
pub struct BodyBlock<L: F32xN> {
    pub bodies: L::Bodies,
    /// At the beginning of the step, world axes; none for a body without inverse inertia.
    pub inertia: Symmetric<L>,
    pub inverse_inertia: Symmetric<L>,
}

/// The states of bodies during a step, by body of the island.
#[derive(Clone, Debug, Default)]
pub struct Turned {
    /// The vector part of the rotation since the beginning of the step, whose scalar part is positive; and xx, yy, zz of the inverse
    /// inertia.
    pub rotations: Vec<State>,
    /// xy, xz, yz of the inverse inertia; and the gyroscopic change of the spin in this substep, rad/s.
    pub others: Vec<State>,
}

/// A rotation in each lane, as a quaternion.
#[derive(Clone, Copy)]
struct Rotation<L> {
    vector: Vec3xN<L>,
    scalar: L,
}

impl<L: F32xN> Rotation<L> {
    #[inline(always)]
    fn of(vector: Vec3xN<L>) -> Self {
        let scalar = (L::ONE - vector.dot(vector)).max(L::ZERO).sqrt();
        Self { vector, scalar }
    }

    #[inline(always)]
    fn turn(&self, v: Vec3xN<L>) -> Vec3xN<L> {
        let twice = self.vector.cross(v);
        let twice = twice + twice;
        self.vector
            .cross_add(twice, twice.scale_add(self.scalar, v))
    }

    #[inline(always)]
    fn turn_back(&self, v: Vec3xN<L>) -> Vec3xN<L> {
        let twice = v.cross(self.vector);
        let twice = twice + twice;
        twice.cross_add(self.vector, twice.scale_add(self.scalar, v))
    }

    /// A matrix that turns along.
    #[inline(always)]
    fn turn_matrix(&self, m: &Symmetric<L>) -> Symmetric<L> {
        let x = self.turn_column(m, L::ONE, L::ZERO, L::ZERO);
        let y = self.turn_column(m, L::ZERO, L::ONE, L::ZERO);
        let z = self.turn_column(m, L::ZERO, L::ZERO, L::ONE);
        Symmetric {
            xx: x.x,
            yy: y.y,
            zz: z.z,
            xy: x.y,
            xz: x.z,
            yz: y.z,
        }
    }

    #[inline(always)]
    fn turn_column(&self, m: &Symmetric<L>, x: L, y: L, z: L) -> Vec3xN<L> {
        self.turn(m.apply(self.turn_back(Vec3xN { x, y, z })))
    }

    /// The rotation of `other` relative to it, as a vector in the axes at the beginning of the step, rad, for small ones.
    #[inline(always)]
    fn relative(&self, other: &Self) -> Vec3xN<L> {
        let along = other.vector.scale(self.scalar);
        let half = self.vector.scale_neg_add(other.scalar, along) - self.vector.cross(other.vector);
        let sixth = L::splat(1.0 / 6.0);
        let longer = half.dot(half).mul_add(sixth, L::ONE);
        half.scale(longer + longer)
    }
}

/// Turns bodies by a drift.
pub struct Drift<'a, L: F32xN> {
    pub bodies: &'a [BodyBlock<L>],
    pub rotations: &'a [Cell<State>],
    /// Velocities of the drift.
    pub velocities: &'a [Cell<State>],
    /// Its length, s.
    pub h: f32,
}

impl<L: F32xN> Kernel for Drift<'_, L> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let quarter = L::splat(0.25 * self.h * self.h);
        let (half, third) = (L::splat(0.5 * self.h), L::splat(1.0 / 3.0));
        for block in self.bodies {
            let spin = L::gather(self.velocities, &block.bodies).angular;
            let mut state = L::gather(self.rotations, &block.bodies);
            let now = Rotation::of(state.linear);
            // The tangent of half the angle, to the third order.
            let longer = (spin.dot(spin) * quarter).mul_add(third, L::ONE);
            let turn = spin.scale(half * longer);
            let scale = turn.dot(turn).mul_add(L::ONE, L::ONE).sqrt().inverse();
            let vector = turn.scale_add(now.scalar, now.vector) + turn.cross(now.vector);
            state.linear = vector.scale(scale);
            L::scatter(self.rotations, &block.bodies, &state);
        }
    }
}

/// Turns the inertias of bodies along, and finds the gyroscopic change of their spins in the next substep: they keep their angular
/// momentum.
pub struct Spin<'a, L: F32xN> {
    pub bodies: &'a [BodyBlock<L>],
    pub rotations: &'a [Cell<State>],
    pub others: &'a [Cell<State>],
    /// Velocities with which the substep ended, and those with which the next one begins.
    pub ended: &'a [Cell<State>],
    pub velocities: &'a [Cell<State>],
    pub h: f32,
}

impl<L: F32xN> Kernel for Spin<'_, L> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let h = L::splat(self.h);
        for block in self.bodies {
            let mut state = L::gather(self.rotations, &block.bodies);
            let mut other = L::gather(self.others, &block.bodies);
            let rotation = Rotation::of(state.linear);
            let inverse = rotation.turn_matrix(&block.inverse_inertia);
            state.angular = Vec3xN {
                x: inverse.xx,
                y: inverse.yy,
                z: inverse.zz,
            };
            other.linear = Vec3xN {
                x: inverse.xy,
                y: inverse.xz,
                z: inverse.yz,
            };
            let spin = rotation.turn_back(L::gather(self.ended, &block.bodies).angular);
            let momentum = block.inertia.apply(spin);
            let energy = spin.dot(momentum);
            let moment = momentum.cross(spin).scale(h);
            let mut next = block.inverse_inertia.apply_add(moment, spin);
            // An explicit step gains energy.
            let gained = next.dot(block.inertia.apply(next));
            let scale = (energy * gained.inverse()).sqrt().min(L::ONE);
            let scale = gained.select_above(L::ZERO, scale, L::ONE);
            next = next.scale(scale);
            let change = rotation.turn(next - spin);
            let mut velocity = L::gather(self.velocities, &block.bodies);
            velocity.angular = velocity.angular + (change - other.angular);
            other.angular = change;
            L::scatter(self.rotations, &block.bodies, &state);
            L::scatter(self.others, &block.bodies, &other);
            L::scatter(self.velocities, &block.bodies, &velocity);
        }
    }
}

/// How fast errors of position are corrected.
#[derive(Clone, Copy, Debug, Default)]
pub struct Correction {
    /// Fastest correction, m/s and rad/s.
    pub fastest: f32,
    /// Length of a substep, s.
    pub h: f32,
}

/// Finds arms, masses and wanted rates for where bodies are. Impulses that were applied along the old directions are applied along the new
/// ones.
pub struct Refresh<'a, L: F32xN> {
    pub blocks: &'a mut [JointBlock<L>],
    pub rows: &'a mut [AngularRow<L>],
    pub turned: [&'a [Cell<State>]; 2],
    pub motions: &'a [Cell<State>],
    pub velocities: &'a [Cell<State>],
    pub correction: Correction,
    /// Impulses are a part of the velocities.
    pub are_applied: bool,
}

impl<L: F32xN> Kernel for Refresh<'_, L> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self {
            blocks,
            rows,
            turned,
            motions,
            velocities,
            correction,
            are_applied,
        } = self;
        for block in blocks {
            let rows = &mut rows[block.range()];
            let mut a = L::gather(velocities, &block.bodies[0]);
            let mut b = L::gather(velocities, &block.bodies[1]);
            if are_applied {
                let none = Vec3xN::default();
                let (push, moment) = (none - block.impulse, none - block.moment(rows));
                block.push(push, moment, &mut a, &mut b);
            }
            let rotation_a = block.follow::<0>(turned);
            let rotation_b = block.follow::<1>(turned);
            // Forces turn along with A.
            let own = Rotation::of(block.rotation).turn_back(block.impulse);
            block.impulse = rotation_a.turn(own);
            block.rotation = rotation_a.vector;
            let moved_a = L::gather(motions, &block.bodies[0]).linear;
            let moved_b = L::gather(motions, &block.bodies[1]).linear;
            let arm_a = rotation_a.turn(block.start_arms[0]);
            let arm_b = rotation_b.turn(block.start_arms[1]);
            let way_a = moved_a + (arm_a - block.start_arms[0]);
            let way_b = moved_b + (arm_b - block.start_arms[1]);
            let gap = block.start_gap + (way_b - way_a);
            block.arms = [arm_a + gap, arm_b];
            block.held = rotation_a.turn(block.start_held);
            block.mass = block.response().inverse();
            for row in &mut *rows {
                row.follow(block, &rotation_a, &rotation_b, &correction);
            }
            let (push, moment) = (block.impulse, block.moment(rows));
            block.push(push, moment, &mut a, &mut b);
            block.ask(gap, &a, &b, &correction);
            L::scatter(velocities, &block.bodies[0], &a);
            L::scatter(velocities, &block.bodies[1], &b);
        }
    }
}

impl<L: F32xN> JointBlock<L> {
    /// Takes over the inverse inertia of a side, and returns its rotation.
    #[inline(always)]
    fn follow<const SIDE: usize>(&mut self, turned: [&[Cell<State>]; 2]) -> Rotation<L> {
        let state = L::gather(turned[0], &self.bodies[SIDE]);
        let other = L::gather(turned[1], &self.bodies[SIDE]);
        self.inverse_inertia[SIDE] = Symmetric {
            xx: state.angular.x,
            yy: state.angular.y,
            zz: state.angular.z,
            xy: other.linear.x,
            xz: other.linear.y,
            yz: other.linear.z,
        };
        Rotation::of(state.linear)
    }

    /// The change of the relative velocity of the anchors by a push.
    #[inline(always)]
    fn response(&self) -> Symmetric<L> {
        let x = self.respond(L::ONE, L::ZERO, L::ZERO);
        let y = self.respond(L::ZERO, L::ONE, L::ZERO);
        let z = self.respond(L::ZERO, L::ZERO, L::ONE);
        Symmetric {
            xx: x.x,
            yy: y.y,
            zz: z.z,
            xy: x.y,
            xz: x.z,
            yz: y.z,
        }
    }

    #[inline(always)]
    fn respond(&self, x: L, y: L, z: L) -> Vec3xN<L> {
        let push = Vec3xN { x, y, z };
        let a = self.inverse_inertia[0].apply(self.arms[0].cross(push));
        let b = self.inverse_inertia[1].apply(self.arms[1].cross(push));
        let turned = a.cross(self.arms[0]) + b.cross(self.arms[1]);
        push.scale_add(self.inverse_mass[0] + self.inverse_mass[1], turned)
    }

    /// Finds the wanted velocities of the anchors.
    #[inline(always)]
    fn ask(&mut self, gap: Vec3xN<L>, a: &SpatialVec<L>, b: &SpatialVec<L>, of: &Correction) {
        let back = Vec3xN {
            x: back(gap.x, self.slack[0], self.softness.bias_rate, of),
            y: back(gap.y, self.slack[0], self.softness.bias_rate, of),
            z: back(gap.z, self.slack[0], self.softness.bias_rate, of),
        };
        let inward_a = a.angular.cross(a.angular.cross(self.arms[0]));
        let inward_b = b.angular.cross(b.angular.cross(self.arms[1]));
        let rigid = (inward_a - inward_b).scale(L::splat(Bend::inward_rate(1.0, of.h)));
        self.wanted = [rigid + back, rigid];
    }
}

/// The rate that corrects an error beyond rounding.
#[inline(always)]
fn back<L: F32xN>(error: L, slack: L, bias_rate: L, of: &Correction) -> L {
    let beyond = error - error.max(-slack).min(slack);
    let fastest = L::splat(of.fastest);
    let rate = beyond * bias_rate;
    -(rate.max(-fastest).min(fastest))
}

/// A bound that nothing reaches, N·m·s.
const NO_BOUND: f32 = 1e30;

impl<L: F32xN> AngularRow<L> {
    /// Finds its direction, its mass and its law.
    #[inline(always)]
    fn follow(&mut self, block: &JointBlock<L>, a: &Rotation<L>, b: &Rotation<L>, of: &Correction) {
        self.direction = a.turn(self.start_direction);
        let [one, other] = &block.inverse_inertia;
        let response = other.apply_add(self.direction, one.apply(self.direction));
        self.mass = self.direction.dot(response).inverse();
        let turned = a.relative(b);
        let value = self.start_direction.dot(turned) + self.start_value;

        let (above, below) = (value - self.most, value - self.least);
        // Nearer to the upper limit than to the lower one.
        let nearer = above + below;
        let error = nearer.select_above(L::ZERO, above, below);
        let open = nearer.select_above(L::ZERO, above.min(L::ZERO), below.max(L::ZERO));
        let open = self.is_locked.select_above(L::ZERO, L::ZERO, open);
        let none = L::splat(NO_BOUND);
        let high = nearer.select_above(L::ZERO, L::ZERO, none);
        let low = nearer.select_above(L::ZERO, -none, L::ZERO);
        let high = self.is_locked.select_above(L::ZERO, none, high);
        let low = self.is_locked.select_above(L::ZERO, -none, low);

        let closes = -(open * L::splat(1.0 / of.h));
        let is_open = open.max(-open);
        let rate = is_open.select_above(
            L::ZERO,
            closes,
            back(error, block.slack[1], block.softness.bias_rate, of),
        );
        self.wanted = [
            self.reach.select_above(L::ZERO, L::ZERO, rate),
            self.reach.select_above(L::ZERO, L::ZERO, closes),
        ];
        self.low = self.reach.select_above(L::ZERO, -self.reach, low);
        self.high = self.reach.select_above(L::ZERO, self.reach, high);
        self.impulse = self.impulse.max(self.low).min(self.high);
    }
}
