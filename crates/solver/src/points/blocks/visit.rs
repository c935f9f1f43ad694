//! One visit to a block: relaxes its rows and applies their impulses to the bodies.

use super::Cone;
use super::block::{Block, Patches, Points};
use crate::lanes::{F32xN, Kernel, SpatialVec, State, Symmetric, Vec3xN};
use std::cell::Cell;

/// The motion of two bodies during a visit.
#[derive(Clone, Copy)]
pub struct Motion<L> {
    /// Velocity of the centre of A against that of B, m/s.
    linear: Vec3xN<L>,
    /// Spins of A and B, rad/s.
    angular: [Vec3xN<L>; 2],
}

/// Inverse masses and inertias, in the frame of a patch.
pub struct Masses<'a, L> {
    /// Inverse mass of A and B together, 1/kg.
    inverse_mass: L,
    /// Inverse inertias of A and B, 1/(kg·m²).
    inverse_inertia: &'a [Symmetric<L>; 2],
}

/// The order in which the rows of a pair are relaxed.
pub trait Relax<L: F32xN>: Sized {
    /// Number of passes of a visit through the points of a pair.
    const PASSES: u32;

    /// Relaxes the rows of a point that are due in this pass, for the `number`-th of all points; adds Wᵢᵢ Δλᵢ² to `change`.
    fn relax<C: Cone>(
        &mut self,
        pass: u32,
        number: usize,
        point: &mut Points<L>,
        masses: &Masses<L>,
        motion: &mut Motion<L>,
        change: &mut L,
    );
}

/// All normals, then all friction: [`Grouping::Pair`](crate::Grouping::Pair).
pub struct PairByPair;

impl<L: F32xN> Relax<L> for PairByPair {
    const PASSES: u32 = 2;

    #[inline(always)]
    fn relax<C: Cone>(
        &mut self,
        pass: u32,
        _: usize,
        point: &mut Points<L>,
        masses: &Masses<L>,
        motion: &mut Motion<L>,
        change: &mut L,
    ) {
        if pass == 0 {
            point.relax_normal(masses, motion, change);
        } else {
            point.relax_friction::<C>(masses, motion, change);
        }
    }
}

impl<L: F32xN> Block<L> {
    /// One projected Gauss–Seidel visit. Returns Σ Wᵢᵢ Δλᵢ², J.
    #[inline(always)]
    pub fn visit<C: Cone, R: Relax<L>>(
        &self,
        patches: &[Patches<L>],
        points: &mut [Points<L>],
        velocities: &[Cell<State>],
        forwards: bool,
        relax: &mut R,
    ) -> L {
        let a = L::gather(velocities, &self.bodies[0]);
        let b = L::gather(velocities, &self.bodies[1]);
        let start = Motion {
            linear: a.linear - b.linear,
            angular: [a.angular, b.angular],
        };
        let mut visit = Visit {
            inverse_mass: self.inverse_mass,
            points,
            forwards,
            relax,
            change: L::ZERO,
        };
        let gain = if let [patch] = patches {
            visit.all_of::<C>(patch, &start)
        } else {
            L::run_rarely(Several::<_, _, C> {
                visit: &mut visit,
                patches,
                start,
                cone: std::marker::PhantomData,
            })
        };
        let change = visit.change;
        let a = SpatialVec {
            linear: gain.linear.scale_add(self.shares[0], a.linear),
            angular: a.angular + gain.angular[0],
        };
        let b = SpatialVec {
            linear: gain.linear.scale_neg_add(self.shares[1], b.linear),
            angular: b.angular + gain.angular[1],
        };
        L::scatter(velocities, &self.targets[0], &a);
        L::scatter(velocities, &self.targets[1], &b);
        change
    }
}

/// The state of a visit.
struct Visit<'a, L, R> {
    /// Inverse mass of A and B together, 1/kg.
    inverse_mass: L,
    /// The points of all blocks.
    points: &'a mut [Points<L>],
    forwards: bool,
    relax: &'a mut R,
    change: L,
}

impl<L: F32xN, R: Relax<L>> Visit<'_, L, R> {
    /// All passes over one patch. Returns the change of the motion, in world axes.
    #[inline(always)]
    fn all_of<C: Cone>(&mut self, patch: &Patches<L>, start: &Motion<L>) -> Motion<L> {
        let local = start.local(patch);
        let mut motion = local;
        for pass in 0..R::PASSES {
            self.pass::<C>(pass, patch, &mut motion);
        }
        motion.less(&local).world(patch)
    }

    /// One pass over all points of a patch.
    #[inline(always)]
    fn pass<C: Cone>(&mut self, pass: u32, patch: &Patches<L>, motion: &mut Motion<L>) {
        let masses = Masses {
            inverse_mass: self.inverse_mass,
            inverse_inertia: &patch.inverse_inertia,
        };
        let range = patch.points();
        let (first, last) = (range.start, range.end.wrapping_sub(1));
        let points = &mut self.points[range];
        for i in 0..points.len() {
            let number = if self.forwards { first + i } else { last - i };
            let point = &mut points[number - first];
            self.relax
                .relax::<C>(pass, number, point, &masses, motion, &mut self.change);
        }
    }
}

/// A visit to pairs that touch in several patches, so that the motion is transformed into one frame after the other.
struct Several<'a, 'b, L, R, C> {
    visit: &'a mut Visit<'b, L, R>,
    patches: &'a [Patches<L>],
    start: Motion<L>,
    cone: std::marker::PhantomData<C>,
}

impl<L: F32xN, R: Relax<L>, C: Cone> Kernel for Several<'_, '_, L, R, C> {
    type Output = Motion<L>;

    #[inline(always)]
    fn run(self) -> Motion<L> {
        let Self {
            visit,
            patches,
            start,
            ..
        } = self;
        let mut motion = start;
        for pass in 0..R::PASSES {
            for i in 0..patches.len() {
                let i = if visit.forwards {
                    i
                } else {
                    patches.len() - 1 - i
                };
                let patch = &patches[i];
                let before = motion.local(patch);
                let mut after = before;
                visit.pass::<C>(pass, patch, &mut after);
                motion = motion.plus(&after.less(&before).world(patch));
            }
        }
        motion.less(&start)
    }
}

impl<L: F32xN> Motion<L> {
    #[inline(always)]
    fn local(&self, patch: &Patches<L>) -> Self {
        let frame = patch.frame();
        let [a, b] = self.angular;
        Self {
            linear: frame.local(self.linear),
            angular: [frame.local(a), frame.local(b)],
        }
    }

    #[inline(always)]
    fn world(&self, patch: &Patches<L>) -> Self {
        let frame = patch.frame();
        let [a, b] = self.angular;
        Self {
            linear: frame.world(self.linear),
            angular: [frame.world(a), frame.world(b)],
        }
    }

    #[inline(always)]
    fn plus(&self, o: &Self) -> Self {
        Self {
            linear: self.linear + o.linear,
            angular: [
                self.angular[0] + o.angular[0],
                self.angular[1] + o.angular[1],
            ],
        }
    }

    #[inline(always)]
    fn less(&self, o: &Self) -> Self {
        Self {
            linear: self.linear - o.linear,
            angular: [
                self.angular[0] - o.angular[0],
                self.angular[1] - o.angular[1],
            ],
        }
    }
}

/// Response of a spin to an impulse at an arm: I⁻¹ (r × axis).
mod effect {
    use super::*;

    /// Arm r × n = (0, r₂, −r₁).
    #[inline(always)]
    pub fn of_normal<L: F32xN>(i: &Symmetric<L>, arm: &Vec3xN<L>) -> Vec3xN<L> {
        Vec3xN {
            x: i.xy.mul_sub(arm.z, i.xz * arm.y),
            y: i.yy.mul_sub(arm.z, i.yz * arm.y),
            z: i.yz.mul_sub(arm.z, i.zz * arm.y),
        }
    }

    /// Arm r × t1 = (−r₂, 0, r_n).
    #[inline(always)]
    pub fn of_first<L: F32xN>(i: &Symmetric<L>, arm: &Vec3xN<L>) -> Vec3xN<L> {
        Vec3xN {
            x: i.xz.mul_sub(arm.x, i.xx * arm.z),
            y: i.yz.mul_sub(arm.x, i.xy * arm.z),
            z: i.zz.mul_sub(arm.x, i.xz * arm.z),
        }
    }

    /// Arm r × t2 = (r₁, −r_n, 0).
    #[inline(always)]
    pub fn of_second<L: F32xN>(i: &Symmetric<L>, arm: &Vec3xN<L>) -> Vec3xN<L> {
        Vec3xN {
            x: i.xx.mul_sub(arm.y, i.xy * arm.x),
            y: i.xy.mul_sub(arm.y, i.yy * arm.x),
            z: i.xz.mul_sub(arm.y, i.yz * arm.x),
        }
    }
}

impl<L: F32xN> Points<L> {
    /// The normal row; see [`PointConstraint::relax_normal`](crate::PointConstraint::relax_normal).
    #[inline(always)]
    pub fn relax_normal(&mut self, masses: &Masses<L>, motion: &mut Motion<L>, change: &mut L) {
        let [arm_a, arm_b] = &self.arms;
        let [a, b] = &mut motion.angular;
        let excess = motion.linear.x - self.target.x;
        let at_a = a.z.neg_mul_add(arm_a.y, a.y.mul_add(arm_a.z, excess));
        let at_b = b.y.mul_sub(arm_b.z, b.z * arm_b.y);
        let residual = at_a - at_b;
        let normal = self.normal_mass.neg_mul_add(residual, self.impulse.x);
        let normal = normal.max(L::ZERO);
        let step = normal - self.impulse.x;
        self.impulse.x = normal;

        let [inertia_a, inertia_b] = masses.inverse_inertia;
        motion.linear.x = masses.inverse_mass.mul_add(step, motion.linear.x);
        *a = effect::of_normal(inertia_a, arm_a).scale_add(step, *a);
        *b = effect::of_normal(inertia_b, arm_b).scale_neg_add(step, *b);
        *change = (self.diagonal.x * step).mul_add(step, *change);
    }

    /// The friction rows; see [`PointConstraint::relax_friction`](crate::PointConstraint::relax_friction).
    #[inline(always)]
    pub fn relax_friction<C: Cone>(
        &mut self,
        masses: &Masses<L>,
        motion: &mut Motion<L>,
        change: &mut L,
    ) {
        let [arm_a, arm_b] = &self.arms;
        let [a, b] = &mut motion.angular;
        let excess = [
            motion.linear.y - self.target.y,
            motion.linear.z - self.target.z,
        ];
        let at_a = [
            a.x.neg_mul_add(arm_a.z, a.z.mul_add(arm_a.x, excess[0])),
            a.y.neg_mul_add(arm_a.x, a.x.mul_add(arm_a.y, excess[1])),
        ];
        let at_b = [
            b.z.mul_sub(arm_b.x, b.x * arm_b.z),
            b.x.mul_sub(arm_b.y, b.y * arm_b.x),
        ];
        let residual = [at_a[0] - at_b[0], at_a[1] - at_b[1]];
        let before = [self.impulse.y, self.impulse.z];
        let limit = self.friction * self.impulse.x;
        let after = C::step(&self.tangential, before, residual, limit);
        let step = [after[0] - before[0], after[1] - before[1]];
        [self.impulse.y, self.impulse.z] = after;

        let [inertia_a, inertia_b] = masses.inverse_inertia;
        motion.linear.y = masses.inverse_mass.mul_add(step[0], motion.linear.y);
        motion.linear.z = masses.inverse_mass.mul_add(step[1], motion.linear.z);
        *a = effect::of_first(inertia_a, arm_a).scale_add(step[0], *a);
        *a = effect::of_second(inertia_a, arm_a).scale_add(step[1], *a);
        *b = effect::of_first(inertia_b, arm_b).scale_neg_add(step[0], *b);
        *b = effect::of_second(inertia_b, arm_b).scale_neg_add(step[1], *b);
        *change = (self.diagonal.y * step[0]).mul_add(step[0], *change);
        *change = (self.diagonal.z * step[1]).mul_add(step[1], *change);
    }
}
