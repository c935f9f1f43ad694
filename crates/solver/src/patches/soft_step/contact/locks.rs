//! Locked axes: bodies whose inverse mass differs from axis to axis, or that do not turn about some axis.
//!
//! A block has one inverse mass for each body, and keeps one for each axis beside it only if one of its bodies is locked. So a visit to any
//! other block costs one comparison more, and no memory.

use crate::Body;
use crate::Both;
use crate::lanes::{F32xN, Kernel, SpatialVec, State, Symmetric, Vec3xN};
use std::cell::Cell;

/// Inverse masses of the bodies of a block along the world axes, 1/kg.
#[derive(Clone, Debug)]
pub struct Locks<L> {
    inverse_masses: [Vec3xN<L>; 2],
}

impl<L: F32xN> Locks<L> {
    /// No locked axes, for bodies with these inverse masses, 1/kg.
    pub fn free(inverse_mass: &[L; 2]) -> Self {
        let inverse_masses = inverse_mass.both(|mass| Vec3xN {
            x: mass,
            y: mass,
            z: mass,
        });
        Self { inverse_masses }
    }

    /// Loads the locked axes of a body.
    pub fn load(&mut self, lane: usize, side: usize, body: &Body) {
        self.inverse_masses[side].set(lane, body.inverse_mass * body.free_axes);
    }

    /// Changes a relative velocity by a force on both bodies.
    #[inline(always)]
    pub fn respond(&self, force: Vec3xN<L>, velocity: Vec3xN<L>) -> Vec3xN<L> {
        let [a, b] = self.inverse_masses;
        along_axes(a + b, force, velocity)
    }
}

/// A velocity after an impulse on a body with these inverse masses. Along an axis without inverse mass it keeps every bit.
#[inline(always)]
fn along_axes<L: F32xN>(
    inverse_masses: Vec3xN<L>,
    impulse: Vec3xN<L>,
    velocity: Vec3xN<L>,
) -> Vec3xN<L> {
    Vec3xN {
        x: inverse_masses.x.mul_add(impulse.x, velocity.x),
        y: inverse_masses.y.mul_add(impulse.y, velocity.y),
        z: inverse_masses.z.mul_add(impulse.z, velocity.z),
    }
}

/// Changes the velocities of a block's bodies by a force and a torque at its centre, in world axes.
pub struct PushLocked<'a, L: F32xN> {
    pub locks: &'a Locks<L>,
    pub inverse_inertia: &'a [Symmetric<L>; 2],
    /// From the centre of each body to that of the block, m.
    pub arms: &'a [Vec3xN<L>; 2],
    pub targets: &'a [L::Bodies; 2],
    pub force: Vec3xN<L>,
    pub torque: Vec3xN<L>,
    pub motions: [SpatialVec<L>; 2],
    pub velocities: &'a [Cell<State>],
}

impl<L: F32xN> Kernel for PushLocked<'_, L> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (force, torque) = (self.force, self.torque);
        let [mass_a, mass_b] = self.locks.inverse_masses;
        let [inertia_a, inertia_b] = self.inverse_inertia;
        let [a, b] = self.motions;
        let at_a = self.arms[0].cross_add(force, torque);
        let at_b = self.arms[1].cross_add(force, torque);
        let opposite = Vec3xN {
            x: -force.x,
            y: -force.y,
            z: -force.z,
        };
        let a = SpatialVec {
            linear: along_axes(mass_a, force, a.linear),
            angular: inertia_a.apply_add(at_a, a.angular),
        };
        let b = SpatialVec {
            linear: along_axes(mass_b, opposite, b.linear),
            angular: inertia_b.apply_neg_add(at_b, b.angular),
        };
        L::scatter(self.velocities, &self.targets[0], &a);
        L::scatter(self.velocities, &self.targets[1], &b);
    }
}

/// Inverse masses and inertias that are added to those of the rows of a block with locked axes. Along a locked axis a row has nearly none,
/// up to rounding, and the effective mass that follows from that would be any number. An effective mass is the size of a step: the impulses
/// that a row finds do not depend on it.
#[derive(Clone, Copy, Default)]
pub struct Ease<L> {
    /// Of velocities, 1/kg.
    pub linear: L,
    /// Of spins, 1/(kg·m²).
    pub angular: L,
}

/// Share of the sum of inverse masses or inertias.
const EASE: f32 = 1e-4;

impl<L: F32xN> Ease<L> {
    /// For a block with these inverse masses, and this response of normals.
    #[inline(always)]
    pub fn of_locks(inverse_mass: &[L; 2], normals: &Symmetric<L>) -> Self {
        let share = L::splat(EASE);
        Self {
            linear: share * (inverse_mass[0] + inverse_mass[1]),
            angular: share * (normals.yy + normals.zz),
        }
    }
}
