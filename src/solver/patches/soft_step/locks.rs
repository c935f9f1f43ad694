//! Locked translations: bodies whose inverse mass differs from axis to axis.
//!
//! A block has one inverse mass for each body, and keeps one for each axis beside it only if one of its bodies is locked. So a visit to any
//! other block costs one comparison more, and no memory.

use super::block::Block;
use crate::solver::Body;
use crate::solver::lanes::{F32xN, Kernel, SpatialVec, State, Vec3xN};
use std::cell::Cell;

/// Inverse masses of the bodies of a block along the world axes, 1/kg.
#[derive(Clone, Debug)]
pub struct Locks<L> {
    inverse_masses: [Vec3xN<L>; 2],
}

impl<L: F32xN> Locks<L> {
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

impl<L: F32xN> Block<L> {
    /// Loads the locked axes of a body, after its inverse mass.
    pub fn load_locks(&mut self, lane: usize, side: usize, body: &Body) {
        if body.is_locked() && self.locks.is_none() {
            let inverse_masses = self.inverse_mass.map(|mass| Vec3xN {
                x: mass,
                y: mass,
                z: mass,
            });
            self.locks = Some(Box::new(Locks { inverse_masses }));
        }
        if let Some(locks) = &mut self.locks {
            locks.inverse_masses[side].set(lane, body.inverse_mass * body.free_axes);
        }
    }
}

/// Changes the velocities of a block's bodies by a force and a torque at its centre, in world axes.
pub struct PushLocked<'a, L: F32xN> {
    pub block: &'a Block<L>,
    pub locks: &'a Locks<L>,
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
        let [inertia_a, inertia_b] = &self.block.inverse_inertia;
        let [a, b] = self.motions;
        let at_a = self.block.arms[0].cross_add(force, torque);
        let at_b = self.block.arms[1].cross_add(force, torque);
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
        L::scatter(self.velocities, &self.block.targets[0], &a);
        L::scatter(self.velocities, &self.block.targets[1], &b);
    }
}
