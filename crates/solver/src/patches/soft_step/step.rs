//! A step of one island, from its problem to its impulses.

use super::contact::smooth::Smooth;
use super::gaps::Gaps;
use super::kept::{Kept, Scratch};
use super::sweeps::Mode;
use super::sweeps::budget::SweepBudget;
use super::sweeps::load_statistics::LoadStatistics;
use super::sweeps::quiet::{first_round, may_be_quiet};
use super::{SoftStep, blows, parting, settling, spinners, start};
use crate::batches::Batches;
use crate::lanes::F32xN;
use crate::patches::restitution::{self, Bounces};
use crate::{PatchProblem, SolveReport};

/// What is found before the sweeps of a problem: their number, which motions are smooth, and the contacts that will bounce.
pub struct Begun {
    pub budget: SweepBudget,
    pub smooth: Smooth,
    bounces: Option<Bounces>,
}

impl SoftStep {
    /// Solves one problem. `found` are its blocks, if they are known.
    pub(crate) fn solve_in<L: F32xN>(
        &self,
        problem: &mut PatchProblem,
        found: Option<Batches>,
    ) -> SolveReport {
        let mut kept = problem.memory.take::<Kept<L>>();
        let mut scratch = kept
            .as_mut()
            .map_or_else(Scratch::default, |kept| std::mem::take(&mut kept.scratch));

        // Loads of contacts that have none yet; then how many sweeps the loads need, and how they run.
        let span = tracing::info_span!("refresh").entered();
        let begun = self.begin::<L>(problem, &mut scratch);
        let budget = begun.budget;
        let gaps = Gaps::of(problem);
        let (mode, mut tops) = mode(problem, &gaps, budget);
        let may_be_quiet = mode != Mode::Blows && may_be_quiet(problem, begun.bounces());
        let passes = self.plan(budget, problem.dt, begun.smooth, &mut scratch.passes);
        let rounds = passes.split_at(match may_be_quiet {
            true => first_round(passes, problem.effort),
            false => passes.len(),
        });
        let threads = problem.threads;
        if may_be_quiet {
            // With so few sweeps, passing blocks from core to core takes longer than a second thread saves.
            problem.threads = 1;
        }

        // Blocks of the last step, or new ones; refreshed, and with the impulses of the warm start.
        let mut kept = Kept::<L>::of(kept, problem, self.lanes, found, mode);
        let island = &mut kept.island;
        island.sweeps_joints = self.sweeps_joints;
        island.spinners.take(&mut tops);
        island.deepest = parting::deepest(&gaps);
        let spring = self.spring(budget, problem.dt);
        let (free_merit, done) =
            island.start_and_sweep(problem, budget.substeps, &spring, rounds.0, mode);
        drop(span);

        let span = tracing::info_span!("sweeps").entered();
        let mut report = SolveReport::new(free_merit, problem.record_history);
        kept.sweep(problem, rounds, (done, threads), mode, &mut |change| {
            report.record(change.max(0.0).sqrt());
        });
        drop(span);

        let _span = tracing::info_span!("store").entered();
        if parting::is_needed(&gaps) {
            kept.island.part(problem);
        }
        kept.island.store(problem, self.followed(budget));
        tops.restore(problem);
        begun.end(problem);
        settling::damp(problem, &scratch.body_loads);
        kept.scratch = scratch;
        problem.memory.keep(kept);
        report
    }

    /// Gives contacts that carry nothing yet their loads, and finds the sweeps that the problem needs and the contacts that will bounce.
    pub(crate) fn begin<L: F32xN>(
        &self,
        problem: &mut PatchProblem,
        scratch: &mut Scratch,
    ) -> Begun {
        let Scratch {
            body_loads,
            courses,
            ..
        } = scratch;
        let mut statistics = LoadStatistics::of(problem, body_loads);
        let slender = problem.bodies.iter().any(blows::lands_slender);
        let bounces = (statistics.bounces || slender).then(|| restitution::find(problem, slender));
        if start::cold_start::<L>(problem, body_loads) {
            statistics = LoadStatistics::of(problem, body_loads);
        }
        let budget = SweepBudget::new(self, problem, (&statistics, &*body_loads), courses);
        let smooth = match statistics.rolls {
            true => Smooth::default(),
            false => Smooth::of(problem),
        };
        Begun {
            budget,
            smooth,
            bounces,
        }
    }
}

/// How the sweeps of a step run, and the tops among its bodies. In a step with blows there are none.
fn mode(problem: &mut PatchProblem, gaps: &Gaps, budget: SweepBudget) -> (Mode, spinners::Found) {
    if blows::expected(problem, gaps) {
        return (Mode::Blows, spinners::Found::default());
    }
    let tops = spinners::Found::of(problem);
    let one_by_one = budget.downwards || !tops.is_empty() || !problem.joints.is_empty();
    match one_by_one {
        true => (Mode::OneByOne, tops),
        false => (Mode::Overlapping, tops),
    }
}

impl Begun {
    /// Whether some contacts may bounce.
    pub fn bounces(&self) -> bool {
        self.bounces.is_some()
    }

    /// Applies restitution after the sweeps.
    pub fn end(self, problem: &mut PatchProblem) {
        if let Some(bounces) = self.bounces {
            restitution::bounce(problem, bounces, self.budget.substeps);
        }
    }
}
