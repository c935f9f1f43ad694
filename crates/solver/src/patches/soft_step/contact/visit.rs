//! One visit to a block: relaxes its rows and applies their impulses to the bodies.

use super::block::{Block, Points, on_normals_local};
use super::friction::Hold;
use super::kinds::Kinds;
use super::normals::{NormalRows, Springs};
use super::pass::Pass;
use super::rolling::Roll;
use crate::lanes::{F32xN, SpatialVec, State, Vec3xN};
use std::cell::Cell;

/// The state of a visit.
pub struct Visit<L> {
    /// Relative velocity in the patch's frame: (u_n, u_1, u_2) and (Ω_n, Ω_1, Ω_2).
    pub velocity: SpatialVec<L>,
    /// Sum of the wrenches of its rows so far, in the same frame.
    pub wrench: SpatialVec<L>,
    /// Σ W Δλ² of the normals, J.
    pub change: L,
}

/// The impulses of a patch's normals.
#[derive(Clone, Copy)]
pub struct Carried<L> {
    /// Σλ_n, N·s.
    pub all: L,
    /// Σλ_n times the distances from the centre, N·m·s.
    pub lever: L,
}

impl<L: F32xN> Block<L> {
    /// One projected Gauss–Seidel visit. In soft lanes, rows are springs and correct errors; friction comes before normals, which matter
    /// more. In rigid lanes, rows only stop the motion; normals come before friction, which therefore ends inside its cone. Returns the
    /// change of the normals, Σ W Δλ², J.
    #[inline(always)]
    pub fn relax<K: Kinds<L>>(
        &mut self,
        kinds: K,
        points: &mut [Points<L>],
        velocities: &[Cell<State>],
        motions: &[Cell<State>],
        pass: &Pass,
    ) -> L {
        let frame = self.frame();
        let a = L::gather(velocities, &self.bodies[0]);
        let b = L::gather(velocities, &self.bodies[1]);
        let mut visit = Visit {
            velocity: self.relative(&frame, a, b),
            wrench: SpatialVec::default(),
            change: L::ZERO,
        };
        self.against_surface(&mut visit.velocity);
        let mut rows = NormalRows {
            kinds,
            springs: Springs::default(),
            rate: L::splat(pass.rate),
        };
        if K::SOFT {
            self.account(kinds, points);
            let moved_a = L::gather(motions, &self.bodies[0]);
            let moved_b = L::gather(motions, &self.bodies[1]);
            let moved = self.relative(&frame, moved_a, moved_b);
            let carried = Carried::by(points);
            self.drag(kinds, &carried, &moved);
            let hold = self.hold(kinds, &moved);
            self.relax_friction::<_, true>(kinds, &carried, &mut visit, &hold);
            visit.follow_friction(self);
            rows.springs = self.springs(kinds, &carried, &moved, pass);
        }
        if self.rolls && (K::SOFT || K::RUBS) {
            let carried = Carried::by(points);
            visit = L::run_rarely(Roll {
                block: self,
                kinds,
                carried,
                visit,
            });
        }
        kinds.before_normals(self.first, points);
        visit = rows.relax_normals(points, visit);
        kinds.after_normals(self.first, points, &mut visit.wrench);
        if K::SOFT {
            self.confine(kinds, Carried::by(points).all, &mut visit);
        }
        if K::RIGID && K::RUBS {
            visit.follow_normals(self);
            let carried = Carried::by(points);
            self.relax_friction::<_, false>(kinds, &carried, &mut visit, &Hold::RIGID);
        }
        self.push(&frame, visit.wrench, a, b, velocities);
        visit.change
    }

    /// Adds the impulses of the last substep to the sums over the step.
    #[inline(always)]
    pub fn account<K: Kinds<L>>(&mut self, kinds: K, points: &mut [Points<L>]) {
        for (given, now) in self.given.iter_mut().zip(self.tangential) {
            *given = kinds.add_if_again(*given, now);
        }
        for point in points {
            point.given = kinds.add_if_again(point.given, point.impulse);
        }
    }
}

impl<L: F32xN> Visit<L> {
    /// Adds the response of the tangents to the impulses of the normals.
    #[inline(always)]
    fn follow_normals(&mut self, block: &Block<L>) {
        let given = Vec3xN {
            x: self.wrench.linear.x,
            y: self.wrench.angular.y,
            z: self.wrench.angular.z,
        };
        self.velocity.linear.y += block.tangents_to_normals[0].dot(given);
        self.velocity.linear.z += block.tangents_to_normals[1].dot(given);
        self.velocity.angular.x += block.twist_to_normals.dot(given);
    }

    /// Adds the response of the normals to the impulses of friction.
    #[inline(always)]
    fn follow_friction(&mut self, block: &Block<L>) {
        let before = on_normals_local(&self.velocity);
        let [first, second] = block.tangents_to_normals;
        let after_twist = block
            .twist_to_normals
            .scale_add(self.wrench.angular.x, before);
        let after_two = first.scale_add(self.wrench.linear.y, after_twist);
        let after = second.scale_add(self.wrench.linear.z, after_two);
        self.velocity.linear.x = after.x;
        self.velocity.angular.y = after.y;
        self.velocity.angular.z = after.z;
    }
}

impl<L: F32xN> Carried<L> {
    #[inline(always)]
    pub fn by(points: &[Points<L>]) -> Self {
        let (mut all, mut lever) = (L::ZERO, L::ZERO);
        for point in points {
            all += point.impulse;
            lever = point.impulse.mul_add(point.radius, lever);
        }
        Self { all, lever }
    }
}
