//! Impulses that keep everything still: static equilibrium, if there is one.
//!
//! The search uses rigid sweeps over closed contacts for a whole step, in which bodies move only by their forces. Sweeps go back and forth,
//! since a structure has no preferred direction; the changes that sweeps make are then search directions of a merit function, as in
//! [`Nncg`](crate::Nncg), which explains the method: an arch of 15 needs a tenth of the sweeps. The search starts from the loads
//! that were handed down, or from those of a growing weight, and hardly changes these: of all the forces that statics allows, only those
//! that follow from how bodies yield are real. Structures that stand without friction get none.

use super::STILL_MOTION;
use crate::PatchProblem;
use crate::lanes::{F32xN, Kernel, State, cells};
use crate::patches::soft_step::contact::pass::Pass;
use crate::patches::soft_step::contact::smooth::Smooth;
use crate::patches::soft_step::contact::spring::Spring;
use crate::patches::soft_step::island::Island;
use crate::patches::soft_step::sweeps::layout::batches;

/// Impulses, or changes of them, N·s and N·m·s.
struct Impulses<L> {
    /// Along both tangents and about the normal, by block.
    friction: Vec<[L; 3]>,
    normal: Vec<L>,
}

impl<L: F32xN> Impulses<L> {
    #[inline(always)]
    fn of(island: &Island<L>) -> Self {
        let mut impulses = Self {
            friction: Vec::with_capacity(island.blocks.len()),
            normal: Vec::with_capacity(island.points.len()),
        };
        for block in &island.blocks {
            let [x, y] = block.tangential;
            impulses.friction.push([x, y, block.twist]);
        }
        for point in &island.points {
            impulses.normal.push(point.impulse);
        }
        impulses
    }

    #[inline(always)]
    fn scale(&mut self, share: f32) {
        let share = L::splat(share);
        for x in self.friction.as_flattened_mut() {
            *x = share * *x;
        }
        for x in &mut self.normal {
            *x = share * *x;
        }
    }

    /// Adds `times` times the others.
    #[inline(always)]
    fn add(&mut self, times: f32, others: &Self) {
        let times = L::splat(times);
        let friction = self.friction.as_flattened_mut().iter_mut();
        for (x, other) in friction.zip(others.friction.as_flattened()) {
            *x = times.mul_add(*other, *x);
        }
        for (x, other) in self.normal.iter_mut().zip(&others.normal) {
            *x = times.mul_add(*other, *x);
        }
    }

    /// Their energy Σ W Δλ², J.
    #[inline(always)]
    fn energy(&self, island: &Island<L>) -> f32 {
        let mut sum = L::ZERO;
        for (block, &[x, y, twist]) in island.blocks.iter().zip(&self.friction) {
            sum = x
                .mul_add(x, y * y)
                .mul_add(block.isotropic_mass.inverse(), sum);
            sum = (twist * twist).mul_add(block.twist_mass.inverse(), sum);
        }
        for (point, &change) in island.points.iter().zip(&self.normal) {
            sum = (change * change).mul_add(point.mass.inverse(), sum);
        }
        sum.sum()
    }
}

/// Changes the impulses towards equilibrium, in at most `most` sweeps back and forth, and makes them the loads at rest. Points farther
/// apart than `closed` m get none.
pub fn settle<L: F32xN>(problem: &mut PatchProblem, closed: f32, most: usize) {
    let pass = Pass::whole(problem.dt);
    let (mut island, free) = Island::<L>::at_rest(problem, closed, &pass);
    L::run(Settle {
        island: &mut island,
        free,
        pass,
        most,
    });
    island.keep(problem, 1.0);
}

/// The search for an equilibrium.
struct Settle<'a, L: F32xN> {
    island: &'a mut Island<L>,
    /// Merit of the free motion, J.
    free: f32,
    pass: Pass,
    /// Upper bound of sweeps back and forth.
    most: usize,
}

impl<L: F32xN> Kernel for Settle<'_, L> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { island, pass, .. } = self;
        let back = Pass { down: true, ..pass };
        let mut direction: Option<Impulses<L>> = None;
        let mut last = f32::INFINITY;
        for _ in 0..self.most {
            let before = Impulses::of(island);
            island.sweep_rigidly(&pass);
            island.sweep_rigidly(&back);
            let mut step = Impulses::of(island);
            step.add(-1.0, &before);
            let energy = step.energy(island);
            if energy <= STILL_MOTION * STILL_MOTION * self.free {
                break;
            }
            let beta = energy / last;
            last = energy;
            // Above 1 the direction is stale, and the search starts anew.
            if let Some(mut along) = direction.take()
                && beta <= 1.0
            {
                along.scale(beta);
                island.add(&along);
                step.add(1.0, &along);
            }
            direction = Some(step);
        }
        // The added direction may have left the cone.
        island.sweep_rigidly(&pass);
    }
}

impl Pass {
    /// A rigid pass over a whole step.
    pub fn whole(dt: f32) -> Self {
        Self {
            soft: false,
            down: false,
            first: true,
            rate: 1.0 / dt,
            preload: 0.0,
            drift: None,
            extrapolates: false,
            smooth: Smooth::default(),
        }
    }
}

impl<L: F32xN> Island<L> {
    /// An island at rest whose points touch unless they are open; and the merit of the free motion, J.
    pub fn at_rest(problem: &PatchProblem, closed: f32, pass: &Pass) -> (Self, f32) {
        let mut island = Self::new(problem, batches(L::LANES, problem));
        island.begin(problem, 1);
        island.velocities.fill(State::default());
        island.push(problem.bodies, 1.0);
        let free = island.refresh(problem, &Spring::default(), pass, closed);
        (island, free)
    }

    #[inline(always)]
    fn add(&mut self, change: &Impulses<L>) {
        for (block, friction) in self.blocks.iter_mut().zip(&change.friction) {
            let range = block.range();
            let normal = &change.normal[range.clone()];
            block.add(
                &mut self.points[range],
                *friction,
                normal,
                cells(&mut self.velocities),
            );
        }
    }

    pub fn keep(&self, problem: &mut PatchProblem, whole: f32) {
        for (block, patches) in self.blocks.iter().zip(self.batches.iter()) {
            let found = &self.points[block.range()];
            for (lane, patch) in patches {
                let patch = &mut problem.patches[patch as usize];
                let t1 = block.tangent.get(lane);
                let t2 = patch.normal.cross(t1);
                let [x, y] = block.tangential;
                patch.friction_impulse = whole * (t1 * x[lane] + t2 * y[lane]);
                patch.twist_impulse = whole * block.twist[lane];
                (patch.rest_friction_impulse, patch.rest_twist_impulse) =
                    (patch.friction_impulse, patch.twist_impulse);
                for (point, found) in problem.points[patch.range()].iter_mut().zip(found) {
                    point.normal_impulse = whole * found.impulse[lane];
                    point.rest_impulse = point.normal_impulse;
                }
            }
        }
    }
}
