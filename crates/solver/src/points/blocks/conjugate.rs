//! Sweeps with a conjugate direction between them, for [`Nncg`](crate::Nncg).
//!
//! A step of the impulses along the direction, λ ← λ + β p, is postponed until a sweep visits the point. Bodies make the step at once,
//! along a direction of their own: v is linear in λ, so q = M⁻¹Jᵀp follows from the changes of v in each sweep, as p does from the changes
//! of λ. So a direction costs no further pass over the contacts.

use super::visit::{Masses, Motion, Relax};
use super::{Blocks, Cone, Points};
use crate::joint::PlainJoint;
use crate::lanes::{F32xN, State, Vec3xN};
use crate::points::{Direction, PointProblem};
use glam::Vec3;

/// Pairs in blocks, and the direction of conjugate gradients through their impulses and velocities.
pub struct Conjugate<L: F32xN, C> {
    blocks: Blocks<L, C>,
    /// By point.
    steps: Vec<Steps<L>>,
    /// By body: q, and v before the last sweep.
    motions: Vec<[State; 2]>,
    /// By grab: p, N·s and N·m·s, and λ before the last sweep.
    grabs: Vec<[[Vec3; 2]; 2]>,
    /// By row of all joints: p, and λ before the last sweep, N·s or N·m·s.
    joints: Vec<[f32; 2]>,
    /// Share of the direction by which points still have to move.
    beta: f32,
}

/// The steps of the points of a [`Points`].
#[derive(Clone, Copy, Default)]
struct Steps<L> {
    /// p, N·s.
    direction: Vec3xN<L>,
    /// r: change in the last sweep, N·s.
    gradient: Vec3xN<L>,
}

impl<L: F32xN, C: Cone> Conjugate<L, C> {
    pub fn of(problem: &PointProblem) -> Self {
        let mut blocks = Blocks::of(problem);
        let rows = blocks.joints.iter_mut().flat_map(PlainJoint::impulses);
        let joints = rows.map(|impulse| [0.0, *impulse]).collect();
        let velocities = blocks.velocities[..problem.bodies.len()].iter();
        Self {
            joints,
            steps: vec![Steps::default(); blocks.points.len()],
            motions: velocities.map(|&v| [State::default(), v]).collect(),
            grabs: blocks
                .grabs
                .iter()
                .map(|held| [[Vec3::ZERO; 2], held.impulse])
                .collect(),
            blocks,
            beta: 0.0,
        }
    }

    /// One sweep, the normal and the friction of one point after the other. Returns Σ Wᵢᵢ Δλᵢ², J.
    pub fn sweep(&mut self, direction: Direction) -> f32 {
        let relax = PointByPoint {
            beta: self.beta,
            steps: &mut self.steps,
        };
        self.beta = 0.0;
        self.blocks.sweep_by(direction, relax)
    }

    /// Moves by β along the direction. The new direction is β times itself plus the change of the last sweep.
    pub fn turn(&mut self, beta: f32) {
        self.beta = beta;
        for (held, [direction, before]) in self.blocks.grabs.iter_mut().zip(&mut self.grabs) {
            for i in 0..2 {
                let gradient = held.impulse[i] - before[i];
                let step = beta * direction[i];
                held.impulse[i] += step;
                direction[i] = step + gradient;
                before[i] = held.impulse[i];
            }
        }
        let rows = self.blocks.joints.iter_mut();
        let rows = rows.flat_map(PlainJoint::impulses);
        for (impulse, [direction, before]) in rows.zip(&mut self.joints) {
            let gradient = *impulse - *before;
            let step = beta * *direction;
            *impulse += step;
            *direction = step + gradient;
            *before = *impulse;
        }
        for (velocity, [direction, before]) in
            self.blocks.velocities.iter_mut().zip(&mut self.motions)
        {
            for i in 0..2 {
                let gradient = velocity[i] - before[i];
                let step = beta * direction[i];
                velocity[i] += step;
                direction[i] = step + gradient;
                before[i] = velocity[i];
            }
        }
    }

    /// Stores impulses and velocities in the problem, as [`Blocks::store`].
    pub fn store(&self, problem: &mut PointProblem) {
        self.blocks.store(problem);
    }
}

/// The normal and the friction of one point after the other: [`Grouping::Point`](crate::Grouping::Point).
struct PointByPoint<'a, L> {
    beta: f32,
    steps: &'a mut [Steps<L>],
}

impl<L: F32xN> Relax<L> for PointByPoint<'_, L> {
    const PASSES: u32 = 1;

    #[inline(always)]
    fn relax<C: Cone>(
        &mut self,
        _: u32,
        number: usize,
        point: &mut Points<L>,
        masses: &Masses<L>,
        motion: &mut Motion<L>,
        change: &mut L,
    ) {
        let steps = &mut self.steps[number];
        let step = steps.direction.scale(L::splat(self.beta));
        steps.direction = step + steps.gradient;
        point.impulse = point.impulse + step;
        let before = point.impulse;
        point.relax_normal(masses, motion, change);
        point.relax_friction::<C>(masses, motion, change);
        steps.gradient = point.impulse - before;
    }
}
