//! A block of swept joints: several joints side by side, one in each lane, and the visit to them in a sweep.

use crate::lanes::{F32xN, Kernel, SpatialVec, State, Symmetric, Vec3xN};
use crate::patches::soft_step::contact::spring::Softness;
use std::cell::Cell;

/// Joints side by side that share no body that moves.
#[derive(Clone, Debug, Default)]
pub struct JointBlock<L: F32xN> {
    pub bodies: [L::Bodies; 2],
    pub inverse_mass: [L; 2],
    /// In world axes, as of the last refresh.
    pub inverse_inertia: [Symmetric<L>; 2],
    /// From the centres of mass to the anchors of A and B, and from the anchor of A to that of B, at the beginning of the step, m.
    pub start_arms: [Vec3xN<L>; 2],
    pub start_gap: Vec3xN<L>,
    /// From the centres of mass to the anchor of B, as of the last refresh, m. Forces act there on both bodies.
    pub arms: [Vec3xN<L>; 2],
    /// The inverse of the response of the relative velocity of the anchors to a push, kg.
    pub mass: Symmetric<L>,
    /// The push on B, N·s, and the rotation of A at which it was found.
    pub impulse: Vec3xN<L>,
    pub rotation: Vec3xN<L>,
    /// The load at rest, to which it does not yield, N·s: at the beginning of the step, and now.
    pub start_held: Vec3xN<L>,
    pub held: Vec3xN<L>,
    /// The relative velocity that soft sweeps ask for, and the one that rigid sweeps ask for, m/s.
    pub wanted: [Vec3xN<L>; 2],
    /// Errors of position up to this are rounding of poses, m and rad.
    pub slack: [L; 2],
    /// Rows are springs in soft sweeps.
    pub softness: Softness<L>,
    pub record: Record<L>,
    /// Its rows among those of all blocks.
    pub first: u32,
    pub count: u32,
}

/// A row of each joint of a block: a limit of a rotation, a locked rotation, or dry friction.
#[derive(Clone, Copy, Debug, Default)]
pub struct AngularRow<L> {
    /// The rotation at the beginning of the step, rad, and the direction of its rate then.
    pub start_value: L,
    pub start_direction: Vec3xN<L>,
    /// The rotation stays between these, rad.
    pub least: L,
    pub most: L,
    /// 1 if the rotation is locked.
    pub is_locked: L,
    /// Friction: the largest impulse, N·m·s. It has no limits.
    pub reach: L,
    /// As of the last refresh.
    pub direction: Vec3xN<L>,
    pub mass: L,
    /// Bounds of the impulse, N·m·s.
    pub low: L,
    pub high: L,
    /// The rate that soft sweeps ask for, and the one that rigid sweeps ask for, rad/s.
    pub wanted: [L; 2],
    /// The load at rest, N·m·s.
    pub held: L,
    /// N·m·s.
    pub impulse: L,
}

/// The forces of the joints of a block over a step, in world axes.
#[derive(Clone, Copy, Debug, Default)]
pub struct Record<L> {
    /// Sums of pushes and moments on B over substeps, N·s and N·m·s.
    pub sum: [Vec3xN<L>; 2],
    /// Filtered force and torque, N and N·m, and the share by which they follow in a substep.
    pub filtered: [Vec3xN<L>; 2],
    pub share: L,
    /// The largest square of their lengths.
    pub peak: [L; 2],
}

impl<L: F32xN> JointBlock<L> {
    #[inline(always)]
    pub fn range(&self) -> std::ops::Range<usize> {
        self.first as usize..(self.first + self.count) as usize
    }

    /// The velocity of B's anchor relative to the point of A there.
    #[inline(always)]
    fn relative(&self, a: &SpatialVec<L>, b: &SpatialVec<L>) -> Vec3xN<L> {
        let at_a = a.angular.cross_add(self.arms[0], a.linear);
        b.angular.cross_add(self.arms[1], b.linear) - at_a
    }

    /// Changes velocities by a push and a moment on B, and the opposite ones on A.
    #[inline(always)]
    pub fn push(
        &self,
        push: Vec3xN<L>,
        moment: Vec3xN<L>,
        a: &mut SpatialVec<L>,
        b: &mut SpatialVec<L>,
    ) {
        let [at_a, at_b] = [
            self.arms[0].cross_add(push, moment),
            self.arms[1].cross_add(push, moment),
        ];
        a.linear = push.scale_neg_add(self.inverse_mass[0], a.linear);
        b.linear = push.scale_add(self.inverse_mass[1], b.linear);
        a.angular = self.inverse_inertia[0].apply_neg_add(at_a, a.angular);
        b.angular = self.inverse_inertia[1].apply_add(at_b, b.angular);
    }

    /// The moment of its rows on B, N·m·s.
    #[inline(always)]
    pub fn moment(&self, rows: &[AngularRow<L>]) -> Vec3xN<L> {
        let mut moment = Vec3xN::default();
        for row in rows {
            moment = row.direction.scale_add(row.impulse, moment);
        }
        moment
    }

    /// One projected Gauss–Seidel visit: the rotations one by one, then the anchors. The rows of a soft sweep are springs, but for
    /// friction. Returns Σ Δλ times what each row lacked, J.
    #[inline(always)]
    fn relax(&mut self, rows: &mut [AngularRow<L>], velocities: &[Cell<State>], soft: bool) -> L {
        let (mass_scale, impulse_scale, kind) = match soft {
            true => (self.softness.mass_scale, self.softness.impulse_scale, 0),
            false => (L::ONE, L::ZERO, 1),
        };
        let mut a = L::gather(velocities, &self.bodies[0]);
        let mut b = L::gather(velocities, &self.bodies[1]);
        let mut sum = L::ZERO;
        for row in rows {
            let lack = row.wanted[kind] - row.direction.dot(b.angular - a.angular);
            let scale = row.reach.select_above(L::ZERO, L::ONE, mass_scale);
            let yields = row.reach.select_above(L::ZERO, L::ZERO, impulse_scale);
            let kept = yields.neg_mul_add(row.impulse - row.held, row.impulse);
            let now = (row.mass * scale).mul_add(lack, kept);
            let now = now.max(row.low).min(row.high);
            let change = now - row.impulse;
            row.impulse = now;
            sum = change.mul_add(lack, sum);
            let moment = row.direction.scale(change);
            a.angular = self.inverse_inertia[0].apply_neg_add(moment, a.angular);
            b.angular = self.inverse_inertia[1].apply_add(moment, b.angular);
        }
        let lack = self.wanted[kind] - self.relative(&a, &b);
        let found = self.mass.apply(lack).scale(mass_scale);
        let beyond = self.impulse - self.held;
        let change = beyond.scale_neg_add(impulse_scale, found);
        self.impulse = self.impulse + change;
        self.push(change, Vec3xN::default(), &mut a, &mut b);
        L::scatter(velocities, &self.bodies[0], &a);
        L::scatter(velocities, &self.bodies[1], &b);
        change.dot(lack) + sum
    }

    /// Adds the impulses of a substep to its record; `rate` is the inverse length of the substep, 1/s.
    #[inline(always)]
    fn note(&mut self, rows: &[AngularRow<L>], rate: L) {
        let impulses = [self.impulse, self.moment(rows)];
        let record = &mut self.record;
        let mut i = 0;
        while i < 2 {
            record.sum[i] = record.sum[i] + impulses[i];
            let filtered = record.filtered[i];
            let now = (impulses[i].scale(rate) - filtered).scale_add(record.share, filtered);
            record.filtered[i] = now;
            record.peak[i] = record.peak[i].max(now.dot(now));
            i += 1;
        }
    }
}

/// One sweep over all blocks. Returns Σ Δλ times what each row lacked, J.
pub struct Relax<'a, L: F32xN> {
    pub blocks: &'a mut [JointBlock<L>],
    pub rows: &'a mut [AngularRow<L>],
    pub velocities: &'a [Cell<State>],
    pub soft: bool,
}

impl<L: F32xN> Kernel for Relax<'_, L> {
    type Output = f32;

    #[inline(always)]
    fn run(self) -> f32 {
        let mut sum = L::ZERO;
        for block in self.blocks {
            let rows = &mut self.rows[block.range()];
            sum += block.relax(rows, self.velocities, self.soft);
        }
        sum.sum()
    }
}

/// Adds the impulses of a substep to the records of all blocks.
pub struct Note<'a, L: F32xN> {
    pub blocks: &'a mut [JointBlock<L>],
    pub rows: &'a [AngularRow<L>],
    /// Inverse length of the substep, 1/s.
    pub rate: f32,
}

impl<L: F32xN> Kernel for Note<'_, L> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let rate = L::splat(self.rate);
        for block in self.blocks {
            let rows = &self.rows[block.range()];
            block.note(rows, rate);
        }
    }
}
