//! Small islands solved together: their patches lie side by side in the blocks of one problem.
//!
//! A body that lies alone on the ground fills one lane of eight. So the small islands of a step that get the same sweeps form one problem.
//! They share no body that moves, the patches of each island keep their order, and its springs keep their frequency. So the result of each
//! island equals bit for bit that of solving it alone, except for the sign of zeros. 50 dominoes take 1.35 times as long one by one.

use super::gaps::Gaps;
use super::island::Island;
use super::step::Begun;
use super::sweeps::layout::batches;
use super::sweeps::quiet::{first_round, may_be_quiet};
use super::{SoftStep, blows, parting, spinners};
use crate::lanes::F32xN;
use crate::patches::PatchSolver;
use crate::sort;
use crate::{Body, Memory, PatchConstraint, PatchPoint, PatchProblem, SolveReport};
use glam::Vec3;
use std::ops::Range;

/// Several problems, joined into one.
#[derive(Default)]
struct Joint {
    bodies: Vec<Body>,
    patches: Vec<PatchConstraint>,
    points: Vec<PatchPoint>,
    /// By patch: the number of its problem.
    owners: Vec<u32>,
    /// By problem: its bodies.
    members: Vec<Range<usize>>,
    /// Velocities of surfaces, by patch.
    surfaces: Vec<(u32, Vec3)>,
}

impl Joint {
    fn of<'a, 'p: 'a>(problems: impl Iterator<Item = &'a PatchProblem<'p>>) -> Self {
        let mut joint = Self::default();
        for (owner, problem) in (0..).zip(problems) {
            let (body, point) = (joint.bodies.len() as u32, joint.points.len() as u32);
            let patches = problem.patches.iter().map(|patch| PatchConstraint {
                bodies: patch.bodies.map(|of| of + body),
                first: patch.first + point,
                ..*patch
            });
            let first = joint.patches.len() as u32;
            let surfaces = problem.surfaces.iter();
            let surfaces = surfaces.map(|&(patch, velocity)| (patch + first, velocity));
            joint.surfaces.extend(surfaces);
            joint.patches.extend(patches);
            joint.owners.resize(joint.patches.len(), owner);
            joint.bodies.extend_from_slice(problem.bodies);
            joint.members.push(body as usize..joint.bodies.len());
            joint.points.extend_from_slice(problem.points);
        }
        joint
    }

    /// The joint problem, with the settings of `like`.
    fn problem<'a>(&'a mut self, like: &PatchProblem, memory: &'a mut Memory) -> PatchProblem<'a> {
        PatchProblem {
            bodies: &mut self.bodies,
            patches: &mut self.patches,
            points: &mut self.points,
            grabs: &mut [],
            joints: &mut [],
            surfaces: &self.surfaces,
            memory,
            threads: 1,
            ..*like
        }
    }

    /// Copies results back to the problems; those of problems that are to be solved again are left out.
    fn give_back<'a, 'p: 'a>(
        &self,
        problems: impl Iterator<Item = &'a mut PatchProblem<'p>>,
        again: &[bool],
    ) {
        let (mut bodies, mut patches) = (&*self.bodies, &*self.patches);
        let mut points = &*self.points;
        for (problem, &again) in problems.zip(again) {
            let bodies = next(&mut bodies, problem.bodies.len());
            let points = next(&mut points, problem.points.len());
            let found = next(&mut patches, problem.patches.len());
            if again {
                continue;
            }
            problem.bodies.copy_from_slice(bodies);
            problem.points.copy_from_slice(points);
            for (patch, found) in problem.patches.iter_mut().zip(found) {
                *patch = PatchConstraint {
                    bodies: patch.bodies,
                    first: patch.first,
                    ..*found
                };
            }
        }
    }
}

/// A problem that is ready for its sweeps.
struct Ready {
    /// Its index.
    number: usize,
    begun: Begun,
    /// Whether it may be [quiet](super::sweeps::quiet).
    may_be_quiet: bool,
}

/// Takes the first `count` items from a list.
fn next<'a, T>(list: &mut &'a [T], count: usize) -> &'a [T] {
    let (first, rest) = list.split_at(count);
    *list = rest;
    first
}

impl SoftStep {
    /// Solves each problem: those that get the same sweeps together, and those with joints, blows or deep overlaps alone. `L` are the lanes
    /// in which a problem is solved alone, and `W` those in which problems are solved together. Both give the same bits.
    pub fn solve_together<L: F32xN, W: F32xN>(
        &self,
        problems: &mut [PatchProblem],
    ) -> Vec<SolveReport> {
        let mut reports = vec![SolveReport::default(); problems.len()];
        let mut ready = Vec::with_capacity(problems.len());
        for (number, problem) in problems.iter_mut().enumerate() {
            let gaps = Gaps::of(problem);
            let has_joints = !problem.joints.is_empty();
            if has_joints || blows::expected(problem, &gaps) || parting::is_needed(&gaps) {
                reports[number] = self.solve(problem);
                continue;
            }
            // The kept state will be out of date after this step.
            problem.memory.discard();
            let begun = self.begin::<L>(problem, &mut Default::default());
            ready.push(Ready {
                number,
                may_be_quiet: may_be_quiet(problem, begun.bounces()),
                begun,
            });
        }
        let sweeps = |ready: &Ready| {
            let Begun { budget, smooth, .. } = &ready.begun;
            (budget.plan(), ready.may_be_quiet, smooth.kind())
        };
        sort::by_key(&mut ready, |ready| {
            let ((substeps, per_rigid_sweep, downwards), may_be_quiet, smooth) = sweeps(ready);
            let flags = smooth << 2 | u64::from(downwards) << 1 | u64::from(may_be_quiet);
            (substeps, per_rigid_sweep, flags)
        });
        for group in ready.chunk_by(|a, b| sweeps(a) == sweeps(b)) {
            let mut may_be_quiet = group[0].may_be_quiet;
            let mut rest: Vec<&Ready> = group.iter().collect();
            while !rest.is_empty() {
                let mut joint = Joint::of(rest.iter().map(|ready| &problems[ready.number]));
                let like = &problems[rest[0].number];
                let (found, again) = self.solve_joint::<W>(&mut joint, like, &rest, may_be_quiet);
                may_be_quiet = false;
                let mut members: Vec<_> = problems.iter_mut().map(Some).collect();
                let members = rest.iter().filter_map(|ready| members[ready.number].take());
                joint.give_back(members, &again);
                for (ready, report) in rest.iter().zip(found) {
                    reports[ready.number] = report;
                }
                let mut again = again.into_iter();
                rest.retain(|_| again.next() == Some(true));
            }
        }
        for Ready { number, begun, .. } in ready {
            begun.end(&mut problems[number]);
        }
        reports
    }

    /// Solves problems that get the same sweeps, with the settings of one of them. If some are quiet, the others are to be solved again by
    /// themselves, with all sweeps: the second result says which.
    fn solve_joint<L: F32xN>(
        &self,
        joint: &mut Joint,
        like: &PatchProblem,
        ready: &[&Ready],
        may_be_quiet: bool,
    ) -> (Vec<SolveReport>, Vec<bool>) {
        let mut memory = Memory::default();
        let owners = std::mem::take(&mut joint.owners);
        let members = std::mem::take(&mut joint.members);
        let count = members.len();
        let mut problem = joint.problem(like, &mut memory);
        let mut tops = spinners::Found::of(&mut problem);
        let batches = batches(L::LANES, &problem);
        let mut island = Island::<L>::new(&problem, batches);
        island.spinners.take(&mut tops);
        let budget = ready[0].begun.budget;
        let spring = self.spring(budget, problem.dt);
        let mut passes = Vec::new();
        let passes = self.plan(budget, problem.dt, ready[0].begun.smooth, &mut passes);
        let frequencies = owners.iter().map(|&owner| {
            let own = ready[owner as usize].begun.budget;
            self.spring(own, problem.dt).omega
        });
        island.frequencies.extend(frequencies);
        island.start(&problem, budget.substeps, &spring, passes);
        let round = match may_be_quiet {
            true => first_round(passes, problem.effort),
            false => passes.len(),
        };
        let (first, others) = passes.split_at(round);
        for pass in first {
            island.sweep_alone(pass);
        }
        let mut again = vec![false; count];
        if !others.is_empty() {
            let is_quiet = |bodies: Range<usize>| island.are_almost_still(bodies, &problem);
            again = members
                .into_iter()
                .map(|bodies| !is_quiet(bodies))
                .collect();
            if again.contains(&false) {
                island.skip(others);
            } else {
                again.fill(false);
                for pass in others {
                    island.sweep_alone(pass);
                }
            }
        }
        let sweeps = match island.skipped {
            0 => passes.len(),
            _ => first.len(),
        };
        island.store(&mut problem, self.followed(budget));
        tops.restore(&mut problem);
        let (free, last) = (
            island.by_owner(&island.missing, &owners, count),
            island.by_owner(&island.changes, &owners, count),
        );
        let merits = free.into_iter().zip(last);
        let reports =
            merits.map(|(free, last)| SolveReport::of(free.sqrt(), sweeps, last.max(0.0).sqrt()));
        (reports.collect(), again)
    }
}

impl<L: F32xN> Island<L> {
    /// Sums of the values in lanes over the patches of each problem.
    fn by_owner(&self, lanes: &[L], owners: &[u32], count: usize) -> Vec<f32> {
        let mut sums = vec![0.0; count];
        for (found, patches) in lanes.iter().zip(self.batches.iter()) {
            for (lane, patch) in patches {
                sums[owners[patch as usize] as usize] += found[lane];
            }
        }
        sums
    }
}
