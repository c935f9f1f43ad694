//! Small islands solved together: their patches lie side by side in the blocks of one problem.
//!
//! A body that lies alone on the ground fills one lane of four. So the small islands of a step that get the same sweeps form one problem.
//! They share no body that moves, and the patches of each island keep their order. So the result of each island equals bit for bit that of solving it
//! alone, except for the sign of zeros.

use super::gaps::Gaps;
use super::island::{Island, batches};
use super::sweep_budget::SweepBudget;
use super::{Bounces, PatchSolver, SoftStep, blows, parting};
use crate::solver::lanes::F32xN;
use crate::solver::{Body, Memory, PatchConstraint, PatchPoint, PatchProblem, SolveReport};
use glam::Vec3;

/// Several problems, joined into one.
#[derive(Default)]
struct Joint {
    bodies: Vec<Body>,
    patches: Vec<PatchConstraint>,
    points: Vec<PatchPoint>,
    /// By patch: the number of its problem.
    owners: Vec<u32>,
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

    /// Copies the results back to the problems.
    fn give_back<'a, 'p: 'a>(&self, problems: impl Iterator<Item = &'a mut PatchProblem<'p>>) {
        let (mut bodies, mut patches) = (&*self.bodies, &*self.patches);
        let mut points = &*self.points;
        for problem in problems {
            problem
                .bodies
                .copy_from_slice(next(&mut bodies, problem.bodies.len()));
            problem
                .points
                .copy_from_slice(next(&mut points, problem.points.len()));
            let found = next(&mut patches, problem.patches.len());
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
struct Begun {
    /// Its index.
    number: usize,
    budget: SweepBudget,
    bounces: Option<Bounces>,
}

/// Takes the first `count` items from a list.
fn next<'a, T>(list: &mut &'a [T], count: usize) -> &'a [T] {
    let (first, rest) = list.split_at(count);
    *list = rest;
    first
}

impl SoftStep {
    /// Solves each problem: those that get the same sweeps together, and those with joints, blows or deep overlaps alone.
    pub(super) fn solve_together<L: F32xN>(
        &self,
        problems: &mut [PatchProblem],
    ) -> Vec<SolveReport> {
        let mut reports = vec![SolveReport::default(); problems.len()];
        let mut begun = Vec::with_capacity(problems.len());
        for (number, problem) in problems.iter_mut().enumerate() {
            let gaps = Gaps::of(problem);
            let has_joints = !problem.joints.is_empty();
            if has_joints || blows::expected(problem, &gaps) || parting::is_needed(&gaps) {
                reports[number] = self.solve(problem);
                continue;
            }
            // The kept state will be out of date after this step.
            problem.memory.discard();
            let (budget, bounces) = self.begin::<L>(problem, &mut Default::default());
            begun.push(Begun {
                number,
                budget,
                bounces,
            });
        }
        begun.sort_by(|a, b| a.budget.compare(&b.budget));
        for group in begun.chunk_by(|a, b| a.budget == b.budget) {
            let first = &group[0];
            let mut joint = Joint::of(group.iter().map(|begun| &problems[begun.number]));
            let like = &problems[first.number];
            let found = self.solve_joint::<L>(&mut joint, like, first.budget, group.len());
            let mut members: Vec<_> = problems.iter_mut().map(Some).collect();
            let members = group
                .iter()
                .filter_map(|begun| members[begun.number].take());
            joint.give_back(members);
            for (begun, report) in group.iter().zip(found) {
                reports[begun.number] = report;
            }
        }
        for begun in begun {
            let problem = &mut problems[begun.number];
            self.end(problem, begun.bounces, begun.budget.substeps);
        }
        reports
    }

    fn solve_joint<L: F32xN>(
        &self,
        joint: &mut Joint,
        like: &PatchProblem,
        budget: SweepBudget,
        count: usize,
    ) -> Vec<SolveReport> {
        let mut memory = Memory::default();
        let owners = std::mem::take(&mut joint.owners);
        let mut problem = joint.problem(like, &mut memory);
        let batches = batches(L::LANES, &problem);
        let mut island = Island::<L>::new(&problem, batches);
        let (spring, passes) = (
            self.spring(budget, problem.dt),
            self.plan(budget, problem.dt),
        );
        island.start(&problem, budget.substeps, &spring, &passes);
        for pass in &passes {
            island.sweep_alone(pass);
        }
        island.store(&mut problem, self.followed(budget));
        let (free, last) = (
            island.by_owner(&island.missing, &owners, count),
            island.by_owner(&island.changes, &owners, count),
        );
        let merits = free.into_iter().zip(last);
        merits
            .map(|(free, last)| SolveReport::of(free.sqrt(), passes.len(), last.max(0.0).sqrt()))
            .collect()
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
