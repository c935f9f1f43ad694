//! The data of pairs of bodies, their patches and their points, in lanes.

use super::Cone;
use crate::Both;
use crate::lanes::{F32xN, Frame, Symmetric, Vec3xN};
use crate::{Body, PointConstraint};
use std::ops::Range;

/// Several pairs of bodies. No two of them share a body that moves.
#[derive(Clone, Copy, Debug, Default)]
pub struct Block<L: F32xN> {
    pub(super) bodies: [L::Bodies; 2],
    /// Indices to which velocities are written. Bodies that nothing moves get `null_target`, or visits that share one would wait for each
    /// other.
    pub(super) targets: [L::Bodies; 2],
    /// Inverse mass of A and B together, 1/kg: response of the velocity of A against B to an impulse.
    pub(super) inverse_mass: L,
    /// The shares of A and B in it.
    pub(super) shares: [L; 2],
    first: u32,
    end: u32,
}

/// The i-th patch of each pair: points with one normal, and the inertias of the bodies in its frame.
#[derive(Clone, Copy, Debug, Default)]
pub struct Patches<L> {
    pub(super) normal: Vec3xN<L>,
    pub(super) tangent: Vec3xN<L>,
    /// Inverse inertias of A and B, 1/(kg·m²).
    pub(super) inverse_inertia: [Symmetric<L>; 2],
    first: u32,
    count: u32,
}

/// The i-th point of each patch, in its frame (n, t1, t2).
#[derive(Clone, Copy, Debug, Default)]
pub struct Points<L> {
    /// From the centres of mass of A and B, m.
    pub(super) arms: [Vec3xN<L>; 2],
    /// b: lower bound of the normal velocity, and demanded tangential velocities, m/s.
    pub(super) target: Vec3xN<L>,
    /// λ, N·s.
    pub(super) impulse: Vec3xN<L>,
    /// Coefficient of friction μ.
    pub(super) friction: L,
    /// Diagonal of W, 1/kg.
    pub(super) diagonal: Vec3xN<L>,
    /// 1/W_nn, kg.
    pub(super) normal_mass: L,
    /// Coefficients of the tangential block, as the friction cone needs them.
    pub(super) tangential: [L; 4],
}

/// Smallest ratio of an off-diagonal element of a matrix to its trace; smaller ones are set to zero. Normals that are an axis up to
/// rounding leave subnormal elements, which are slow: stacks of cubes took twice as long.
const NONE: f32 = 1e-12;

#[inline(always)]
fn flush_small_elements<L: F32xN>(m: Symmetric<L>) -> Symmetric<L> {
    let least = L::splat(NONE) * (m.xx + m.yy + m.zz);
    Symmetric {
        xy: m.xy.max(-m.xy).select_above(least, m.xy, L::ZERO),
        xz: m.xz.max(-m.xz).select_above(least, m.xz, L::ZERO),
        yz: m.yz.max(-m.yz).select_above(least, m.yz, L::ZERO),
        ..m
    }
}

impl<L: F32xN> Block<L> {
    /// An empty block, whose patches begin at `first`. Its lanes read a body that nothing moves, and write to an entry that nothing reads.
    pub fn new(null_body: u32, null_target: u32, first: usize) -> Self {
        Self {
            bodies: [L::bodies(null_body); 2],
            targets: [L::bodies(null_target); 2],
            first: first as u32,
            ..Default::default()
        }
    }

    /// Loads a pair into a lane.
    pub fn load(&mut self, lane: usize, pair: [u32; 2], bodies: &[Body]) {
        let masses = pair.both(|body| bodies[body as usize].inverse_mass);
        let both = masses[0] + masses[1];
        self.inverse_mass[lane] = both;
        for side in 0..2 {
            L::set_body(&mut self.bodies[side], lane, pair[side]);
            if masses[side] > 0.0 {
                L::set_body(&mut self.targets[side], lane, pair[side]);
                self.shares[side][lane] = masses[side] / both;
            }
        }
    }

    pub fn first_patch(&self) -> usize {
        self.first as usize
    }

    /// Sets the end of its patches.
    pub fn close(&mut self, end: usize) {
        self.end = end as u32;
    }

    /// The range of its patches.
    #[inline(always)]
    pub fn patches(&self) -> Range<usize> {
        self.first as usize..self.end as usize
    }
}

impl<L: F32xN> Patches<L> {
    /// Makes room for a patch of `count` points.
    pub fn widen(&mut self, count: usize) {
        self.count = self.count.max(count as u32);
    }

    /// Sets the index of its first point.
    pub fn place(&mut self, first: usize) {
        self.first = first as u32;
    }

    /// The range of its points.
    #[inline(always)]
    pub fn points(&self) -> Range<usize> {
        self.first as usize..(self.first + self.count) as usize
    }

    /// Loads a patch into a lane, in world axes until it is [prepared](Self::prepare).
    pub fn load(&mut self, lane: usize, points: &[PointConstraint], bodies: &[Body]) {
        assert!(lane < L::LANES);
        let [point, ..] = points else { return };
        self.normal.set(lane, point.normal);
        self.tangent.set(lane, point.tangents[0]);
        for (inertia, body) in self.inverse_inertia.iter_mut().zip(point.bodies) {
            inertia.set(lane, &bodies[body as usize].inverse_inertia);
        }
    }

    /// Transforms the patch and its points into its frame.
    #[inline(always)]
    pub fn prepare(&mut self, points: &mut [Points<L>]) {
        let frame = self.frame();
        let [a, b] = self.inverse_inertia;
        self.inverse_inertia = [
            flush_small_elements(frame.local_matrix(&a)),
            flush_small_elements(frame.local_matrix(&b)),
        ];
        for point in points {
            let [a, b] = point.arms;
            point.arms = [frame.local(a), frame.local(b)];
        }
    }

    #[inline(always)]
    pub(super) fn frame(&self) -> Frame<L> {
        Frame::of(self.normal, self.tangent)
    }
}

impl<L: F32xN> Points<L> {
    /// Loads a point into a lane, with arms in world axes.
    pub fn load<C: Cone>(&mut self, lane: usize, constraint: &PointConstraint) {
        assert!(lane < L::LANES);
        self.arms[0].set(lane, constraint.arms[0]);
        self.arms[1].set(lane, constraint.arms[1]);
        self.target.set(lane, constraint.target);
        self.impulse.set(lane, constraint.impulse);
        self.friction[lane] = constraint.friction;
        self.diagonal.set(lane, constraint.diagonal);
        self.normal_mass[lane] = constraint.inverse_normal;
        for (to, from) in self.tangential.iter_mut().zip(C::tangential(constraint)) {
            to[lane] = from;
        }
    }
}
