//! Pairs of bodies side by side: the sweeps of [`Pgs`](super::Pgs) and [`Nncg`](super::Nncg).
//!
//! A lane is a pair of bodies with all of its points, which are relaxed one after the other, in the order and by the rows of
//! [`PointProblem::sweep`]. Pairs that share a body keep their order ([`Batches`]). So the sweep equals the sequential one up to rounding,
//! and converges in the same way. Bodies are read and written once per visit. In between, the motion of a pair is that of A against B and
//! both spins, in the frame of a patch ([`Patches`]): there a normal row has five nonzero numbers, a tangential one as many, and no zero is
//! multiplied.

mod block;
mod cone;
mod conjugate;
mod visit;

use super::{Direction, PointConstraint, PointProblem};
use crate::batches::Batches;
use crate::grab::ActiveGrab;
use crate::joint::PlainJoint;
use crate::lanes::{F32xN, Kernel, State, cells};
use block::{Block, Patches, Points};
pub use cone::{Cone, Disc, Square};
pub use conjugate::Conjugate;
use glam::{Vec3, Vec4};
use std::marker::PhantomData;
use std::ops::Range;
use visit::{PairByPair, Relax};

#[cfg(test)]
mod tests;

/// A problem in lanes.
pub struct Blocks<L: F32xN, C> {
    batches: Batches,
    /// By pair: the range of its constraints.
    pairs: Vec<Range<u32>>,
    blocks: Vec<Block<L>>,
    patches: Vec<Patches<L>>,
    points: Vec<Points<L>>,
    /// By body. Then one entry that nothing moves, for lanes without a pair, and one that nothing reads.
    velocities: Vec<State>,
    /// Grabs. They are visited before the blocks, so that the contacts they press against decide last.
    grabs: Vec<ActiveGrab>,
    /// Joints that have an effect, visited after grabs.
    joints: Vec<PlainJoint>,
    cone: PhantomData<C>,
}

impl<L: F32xN, C: Cone> Blocks<L, C> {
    pub fn of(problem: &PointProblem) -> Self {
        let (bodies, constraints) = (&*problem.bodies, &*problem.constraints);
        let pairs: Vec<_> = pairs(constraints).collect();
        let batches = batches(L::LANES, problem);
        let (null_body, null_target) = (bodies.len() as u32, bodies.len() as u32 + 1);
        let mut blocks = Vec::with_capacity(batches.blocks());
        let mut patches: Vec<Patches<L>> = Vec::with_capacity(batches.blocks());
        let mut points = Vec::with_capacity(constraints.len() / L::LANES * 5 / 4);
        for block_pairs in batches.iter() {
            let mut block = Block::<L>::new(null_body, null_target, patches.len());
            for (lane, pair) in block_pairs.clone() {
                let runs = runs(&constraints[range(&pairs[pair as usize])]);
                for (run, number) in runs.zip(block.first_patch()..) {
                    if number == patches.len() {
                        patches.push(Patches::default());
                    }
                    patches[number].widen(run.len());
                }
                let first = pairs[pair as usize].start as usize;
                block.load(lane, constraints[first].bodies, bodies);
            }
            block.close(patches.len());
            for patch in &mut patches[block.patches()] {
                patch.place(points.len());
                points.resize(patch.points().end, Points::default());
            }
            for (lane, pair) in block_pairs.clone() {
                let runs = runs(&constraints[range(&pairs[pair as usize])]);
                for (patch, run) in patches[block.patches()].iter_mut().zip(runs) {
                    let points = &mut points[patch.points()];
                    patch.load(lane, run, bodies);
                    for (point, constraint) in points.iter_mut().zip(run) {
                        point.load::<C>(lane, constraint);
                    }
                }
            }
            blocks.push(block);
        }
        let mut velocities = Vec::with_capacity(bodies.len() + 2);
        let state = |v: [Vec3; 2]| v.map(|v| v.extend(0.0));
        velocities.extend(bodies.iter().map(|body| state([body.linear, body.angular])));
        velocities.extend([State::default(); 2]);
        L::run(Prepare {
            patches: &mut patches,
            points: &mut points,
        });
        let (grabs, joints) = (problem.held(), problem.plain_joints());
        Self {
            batches,
            pairs,
            blocks,
            patches,
            points,
            velocities,
            grabs,
            joints,
            cone: PhantomData,
        }
    }

    /// One sweep over all pairs, the normals of each first. Returns Σ Wᵢᵢ Δλᵢ², J.
    pub fn sweep(&mut self, direction: Direction) -> f32 {
        self.sweep_by(direction, PairByPair)
    }

    fn sweep_by<R: Relax<L>>(&mut self, direction: Direction, relax: R) -> f32 {
        let grabs = self.grabs.iter_mut();
        let velocities = cells(&mut self.velocities);
        let held: f32 = grabs.map(|held| held.visit(velocities)).sum();
        let joints = self.joints.iter_mut();
        let jointed: f32 = joints.map(|joint| joint.visit(velocities)).sum();
        let swept = L::run(Sweep {
            blocks: self,
            forwards: direction == Direction::Forwards,
            relax,
        });
        held + jointed + swept
    }

    /// Stores impulses and velocities in the problem.
    pub fn store(&self, problem: &mut PointProblem) {
        for (block, block_pairs) in self.blocks.iter().zip(self.batches.iter()) {
            for (lane, pair) in block_pairs {
                let constraints = &mut problem.constraints[range(&self.pairs[pair as usize])];
                let runs = constraints.chunk_by_mut(of_one_patch);
                for (patch, run) in self.patches[block.patches()].iter().zip(runs) {
                    let points = &self.points[patch.points()];
                    for (point, constraint) in points.iter().zip(run) {
                        constraint.impulse = point.impulse.get(lane);
                    }
                }
            }
        }
        for (grab, held) in problem.grabs.iter_mut().zip(&self.grabs) {
            *grab = held.found();
        }
        let mut joints = self.joints.iter();
        for joint in &mut *problem.joints {
            if joint.acts(problem.bodies)
                && let Some(plain) = joints.next()
            {
                *joint = plain.found();
            }
        }
        for (body, velocity) in problem.bodies.iter_mut().zip(&self.velocities) {
            if body.inverse_mass > 0.0 {
                [body.linear, body.angular] = velocity.map(Vec4::truncate);
            }
        }
    }
}

/// The pairs of a problem, in blocks of `lanes` lanes.
pub fn batches(lanes: usize, problem: &PointProblem) -> Batches {
    let constraints = &*problem.constraints;
    let ends = pairs(constraints).map(|pair| constraints[pair.start as usize].bodies);
    Batches::of(lanes, ends, problem.bodies)
}

/// The range of constraints of each pair of bodies.
fn pairs(constraints: &[PointConstraint]) -> impl Iterator<Item = Range<u32>> {
    let mut end = 0;
    let pairs = constraints.chunk_by(|a, b| a.bodies == b.bodies);
    pairs.map(move |pair| {
        let first = end;
        end += pair.len() as u32;
        first..end
    })
}

/// The constraints of each patch of a pair.
fn runs(pair: &[PointConstraint]) -> impl Iterator<Item = &[PointConstraint]> {
    pair.chunk_by(of_one_patch)
}

#[inline]
fn of_one_patch(a: &PointConstraint, b: &PointConstraint) -> bool {
    a.normal == b.normal
}

fn range(pair: &Range<u32>) -> Range<usize> {
    pair.start as usize..pair.end as usize
}

/// Transforms all patches into their frames.
struct Prepare<'a, L> {
    patches: &'a mut [Patches<L>],
    points: &'a mut [Points<L>],
}

impl<L: F32xN> Kernel for Prepare<'_, L> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for patch in self.patches {
            patch.prepare(&mut self.points[patch.points()]);
        }
    }
}

/// One sweep from the first block to the last. Returns Σ Wᵢᵢ Δλᵢ², J.
struct Sweep<'a, L: F32xN, C, R> {
    blocks: &'a mut Blocks<L, C>,
    forwards: bool,
    relax: R,
}

impl<L: F32xN, C: Cone, R: Relax<L>> Kernel for Sweep<'_, L, C, R> {
    type Output = f32;

    #[inline(always)]
    fn run(mut self) -> f32 {
        let Blocks {
            blocks,
            patches,
            points,
            velocities,
            ..
        } = self.blocks;
        let velocities = cells(velocities);
        let mut change = L::ZERO;
        for block in blocks.iter() {
            let patches = &patches[block.patches()];
            change +=
                block.visit::<C, R>(patches, points, velocities, self.forwards, &mut self.relax);
        }
        change.sum()
    }
}
