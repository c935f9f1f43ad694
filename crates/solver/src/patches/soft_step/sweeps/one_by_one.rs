//! Sweeps one after the other, each over all blocks.

use crate::Both;
use crate::PatchProblem;
use crate::lanes::{F32xN, Kernel, cells};
use crate::patches::soft_step::contact::kinds::{Kinds, Rigid, Soft};
use crate::patches::soft_step::contact::pass::Pass;
use crate::patches::soft_step::island::Island;

impl<L: F32xN> Island<L> {
    /// Runs all sweeps over blocks that are not skewed. Calls `tell` with Σ Wᵢᵢ Δλᵢ² of each, J.
    pub fn sweep(&mut self, problem: &PatchProblem, passes: &[Pass], tell: &mut dyn FnMut(f32)) {
        let bytes = self.bytes();
        let pipeline = self.take_pipeline(problem);
        // A sweep down begins where the one before ends, so only sweeps up follow each other.
        for passes in passes.chunk_by(|before, after| !before.down && !after.down) {
            let shares = pipeline.as_ref().and_then(|pipeline| {
                let shares = pipeline.share(problem.threads, passes.len(), bytes)?;
                Some((pipeline, shares))
            });
            if let Some((pipeline, shares)) = shares {
                pipeline.run(passes, self.work(), shares, tell);
            } else {
                passes.iter().for_each(|pass| tell(self.sweep_alone(pass)));
            }
        }
        self.pipeline = pipeline;
    }

    /// Runs one sweep and finishes its pass. Returns Σ W Δλ², J.
    pub fn sweep_alone(&mut self, pass: &Pass) -> f32 {
        let held_change = self.visit_grabs();
        let change = match pass.soft {
            true => self.sweep_as(Soft { first: pass.first }, pass),
            false => self.sweep_rigidly(pass),
        };
        let jointed_change = self.visit_joints(pass);
        let bodies = self.inertias.len();
        let states = cells(&mut self.velocities).iter().take(bodies);
        let others = cells(&mut self.before).iter().zip(cells(&mut self.motions));
        for (velocity, (before, motion)) in states.zip(others) {
            pass.end(velocity, before, motion);
        }
        self.drift_joints(pass, pass.extrapolates);
        self.turn_spinners(pass, pass.extrapolates);
        self.end_joints(pass);
        self.carry_spins(pass);
        held_change + change + jointed_change
    }

    /// Visits each block once. Returns Σ W Δλ², J.
    pub fn sweep_as(&mut self, kinds: impl Kinds<L>, pass: &Pass) -> f32 {
        L::run(Sweep {
            island: self,
            kinds,
            pass,
        })
    }

    /// Runs one rigid sweep without finishing the pass.
    pub fn sweep_rigidly(&mut self, pass: &Pass) -> f32 {
        self.sweep_as(Rigid, pass)
    }

    /// Visits each grab once. Returns Σ W Δλ², J.
    pub fn visit_grabs(&mut self) -> f32 {
        let mut change = 0.0;
        let [velocities, motions] = [&mut self.velocities, &mut self.motions].both(|l| cells(l));
        for held in &mut self.grabs {
            change += held.visit_among(velocities, motions, self.fastest);
        }
        change
    }
}

/// One sweep, from the first block to the last or in reverse. Returns Σ Wᵢᵢ Δλᵢ², J.
struct Sweep<'a, L: F32xN, K> {
    island: &'a mut Island<L>,
    kinds: K,
    pass: &'a Pass,
}

impl<L: F32xN, K: Kinds<L>> Kernel for Sweep<'_, L, K> {
    type Output = f32;

    #[inline(always)]
    fn run(self) -> f32 {
        let Island {
            blocks,
            points,
            velocities,
            motions,
            changes,
            round_ends,
            ..
        } = self.island;
        let (velocities, motions) = (cells(velocities), cells(motions));
        let mut sum = L::ZERO;
        let count = blocks.len();
        let mut i = 0;
        while i < count {
            let number = match self.pass.down {
                true => count - 1 - i,
                false => i,
            };
            let block = &mut blocks[number];
            let points = &mut points[block.range()];
            changes[number] = block.relax(self.kinds, points, velocities, motions, self.pass);
            round_ends.after(number, velocities);
            sum += changes[number];
            i += 1;
        }
        sum.sum()
    }
}
