//! Soft Step: many short substeps, one sweep each, over contacts that are springs; drystone's default.
//!
//! - **Substeps** instead of iterations (Macklin et al. 2019, "Small Steps in Physics Simulation"; Box2D v3's Soft Step). Contacts
//!   are detected once; normals and arms stay frozen, separations and slips follow the bodies.
//! - **Soft rows** for normals and for anchored friction ([`block`]): a sweep that has not converged then leaves an error
//!   of position that the next substeps take back, not one of velocity that shakes the structure. How stiff they may be is set
//!   by how often sweeps come, [`SoftStep::sweeps_per_period`], and is shared among the patches of a body, since a
//!   brick with six neighbours is held by six springs.
//! - **Sweeps by need** ([`sweep_budget`]): they come at a rate, so that a structure is as stiff at any step, and what is tall, carries much, or
//!   has not settled yet gets more.
//! - **Impulses carry over whole** from substep to substep. With arms frozen they do again what they did, so that forces and
//!   warm start are an extrapolation of the velocities and cost no pass over the contacts.
//! - **Every third substep is followed by a rigid sweep** that only stops motion. Without any, disturbances grow from course to
//!   course in walls and pyramids of 40 courses; those get one after every second, with which, at equal sweeps, arches tremble and
//!   small pyramids drift twice as far.
//! - **Rigid sweeps go down** in very tall structures ([`SweepBudget::downwards`]), from the top to the ground.
//! - **Preload**: a spring gives way under its load, and a tower of springs sinks and leans. So the rows carry their load at rest by
//!   themselves, and springs rest where surfaces meet and where friction took hold: integral action. The mean of a patch is followed
//!   slowly, because a fast one shakes; by how much a point carries more or less than it, as it does where something leans, far
//!   more slowly, or bodies would rock. Where load is taken off, a row holds on to most of it, which makes it the stiffer on that
//!   side; towers stand by that.
//! - **The longest of recent steps** sets the stiffness ([`PatchProblem::longest`]): springs that became stiffer with every short step
//!   would throw what a long one has let sink.
//! - **Blows** ([`blows`]): substeps in which bodies hit each other get more sweeps where they do, and the next begins without the blow.
//! - **Parting** ([`parting`]): bodies that lie deep in each other are moved apart, and get no velocity by it.
//! - **Cold start** ([`cold_start`]): what was just built is given impulses and loads that keep it still, and what bore something that
//!   is gone is relieved of it.
//! - **Patches side by side** ([`lanes`](crate::solver::lanes)): as many as one register holds numbers, four or eight, in blocks whose
//!   patches share no body ([`batches`](crate::solver::batches)); where patches stand in a row, those of several sweeps ([`skewed_sweeps`]).
//!   Light bodies on one that is far heavier are relaxed in rounds ([`rounds`](crate::solver::rounds)).
//! - Points of a patch share one friction force and one twist, held by one anchor.
//!
//! What each part is worth is measured by `examples/study`, and stands in `docs/stability.md`.

mod block;
mod blows;
mod carry;
mod cold_start;
mod edges;
mod gaps;
mod halves;
mod hands;
mod island;
mod kept;
mod kinds;
mod load_statistics;
#[cfg(test)]
mod masonry;
mod parting;
mod pipeline;
mod refresh;
mod skewed_sweeps;
mod sweep_budget;
mod together;
mod upright;
mod visit;

use super::restitution::{self, Bounces};
use super::{PatchProblem, PatchSolver};
use crate::solver::batches::Batches;
#[cfg(target_arch = "x86_64")]
use crate::solver::lanes::F32x8;
use crate::solver::lanes::{F32x4, F32xN};
use crate::solver::width::Width;
use crate::solver::{Lanes, SolveReport};
use block::{Pass, Spring};
use gaps::Gaps;
#[cfg(target_arch = "x86_64")]
use island::{skewed, stands_by_itself};
use kept::{Kept, Scratch};
use load_statistics::LoadStatistics;
use std::f32::consts::TAU;
use sweep_budget::SweepBudget;

/// In very tall structures ([`SweepBudget::downwards`]) loads at rest follow so many times slower. They sway slowly, and loads that follow their
/// swaying push them on: a tower of 200 layers of planks falls after 20 s if they follow as usual, sooner with more or stiffer springs, and drifts by
/// 3 mm in a minute if they follow a tenth as fast.
const SLOWER: f32 = 40.0;

/// Most sweeps that a step may be asked for.
const SWEEPS: usize = 1_000_000;

/// The default contact solver: many short substeps with one sweep each, over contacts that are damped springs. It works on patches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SoftStep {
    /// Damping ratio ζ of soft rows. 5 to 20 work.
    pub damping_ratio: f32,
    /// Sweeps in one period of the spring that a soft row is. Fewer make it stiffer: at 9.5 an arch shakes at Δt 0.1, below 9 tall
    /// stacks do; above 11 they lean.
    pub sweeps_per_period: f32,
    /// Share by which soft rows hold on to a load that is being taken off, 0..1.
    pub preload: f32,
    /// Sweeps in which the mean comes most of the way (1 − 1/e) to a new load. 800 make towers drift.
    pub preload_sweeps: f32,
    /// Longest substep, s. A step takes as many as it needs to stay below; structures that are tall or carry much take more.
    pub max_substep: f32,
    /// Sweeps of a short step, at least; soft and rigid ones together.
    pub min_sweeps: usize,
    /// Sweeps of a step, at most. Springs are as stiff as sweeps come often, so where this is fewer than the step's length and the
    /// structure call for, they are softer.
    pub max_sweeps: usize,
    /// How many patches are relaxed side by side.
    pub lanes: Lanes,
}

impl Default for SoftStep {
    fn default() -> Self {
        Self {
            damping_ratio: 10.0,
            sweeps_per_period: 10.0,
            preload: 0.8,
            preload_sweeps: 1600.0,
            max_substep: 1.0 / 720.0,
            min_sweeps: 4,
            max_sweeps: 192,
            lanes: Lanes::Auto,
        }
    }
}

impl PatchSolver for SoftStep {
    fn name(&self) -> &str {
        "soft-step"
    }

    fn problem(&self) -> Option<String> {
        let (least, most) = (self.min_sweeps, self.max_sweeps);
        if least > SWEEPS || !(1..=SWEEPS).contains(&most) {
            return Some(format!(
                "min_sweeps and max_sweeps of Soft Step are {least} and {most}, and may be {SWEEPS}, the second at least 1"
            ));
        }
        let bounds = [
            ("damping_ratio", self.damping_ratio, 0.0, 1e3),
            ("sweeps_per_period", self.sweeps_per_period, 1.0, 1e6),
            ("preload", self.preload, 0.0, 1.0),
            ("preload_sweeps", self.preload_sweeps, 1.0, 1e9),
            ("max_substep", self.max_substep, 1e-6, 1e3),
        ];
        bounds
            .into_iter()
            .find(|(_, x, least, most)| !(least..=most).contains(&x))
            .map(|(name, x, least, most)| {
                format!("{name} of Soft Step is {x}, and must be between {least} and {most}")
            })
            .or_else(|| self.lanes.problem())
    }

    fn solve(&self, problem: &mut PatchProblem) -> SolveReport {
        let mut found = None;
        match self.width(problem, &mut found) {
            #[cfg(target_arch = "x86_64")]
            Width::Eight => self.solve_in::<F32x8>(problem, found),
            Width::Four => self.solve_in::<F32x4>(problem, None),
        }
    }

    fn solve_each(&self, problems: &mut [PatchProblem]) -> Vec<SolveReport> {
        // Of many at once nobody knows what each was after each sweep.
        if problems.iter().any(|problem| problem.record_history) {
            return problems.iter_mut().map(|one| self.solve(one)).collect();
        }
        match self.lanes.width(|| false) {
            #[cfg(target_arch = "x86_64")]
            Width::Eight => self.solve_together::<F32x8>(problems),
            Width::Four => self.solve_together::<F32x4>(problems),
        }
    }
}

impl SoftStep {
    /// The width for a problem: what it was in the last step, where the patches are the same. If that is eight for the first time, the
    /// blocks are `found` on the way.
    #[cfg(target_arch = "x86_64")]
    fn width(&self, problem: &PatchProblem, found: &mut Option<Batches>) -> Width {
        self.lanes.width(|| {
            was_auto::<F32x8>(problem) || !was_auto::<F32x4>(problem) && fills_eight(problem, found)
        })
    }

    /// The width for a problem.
    #[cfg(not(target_arch = "x86_64"))]
    fn width(&self, _: &PatchProblem, _: &mut Option<Batches>) -> Width {
        Width::Four
    }

    fn solve_in<L: F32xN>(
        &self,
        problem: &mut PatchProblem,
        batches: Option<Batches>,
    ) -> SolveReport {
        let mut kept = problem.memory.take::<Kept<L>>();
        let mut scratch = match &mut kept {
            Some((kept, _)) => std::mem::take(&mut kept.scratch),
            None => Scratch::default(),
        };
        let span = tracing::info_span!("refresh").entered();
        let (budget, bounces) = self.begin::<L>(problem, &mut scratch);
        let gaps = Gaps::of(problem);
        let hits = blows::expected(problem, &gaps);
        let straight = hits || budget.downwards;
        let (mut kept, changed) = Kept::<L>::of(kept, problem, self.lanes, batches, straight);
        let island = &mut kept.island;
        island.deepest = parting::deepest(&gaps);
        let spring = self.spring(budget, problem.dt);
        self.plan_in(budget, problem.dt, &mut scratch.passes);
        let free_merit = island.start(problem, &changed, budget.substeps, &spring, &scratch.passes);
        drop(span);
        let span = tracing::info_span!("sweeps").entered();
        let mut report = SolveReport::new(free_merit, problem.record_history);
        let tell = |change: f32| {
            report.record(change.max(0.0).sqrt());
        };
        match hits {
            true => island.sweep_through_blows(&mut kept.blows, problem, &scratch.passes, tell),
            false => kept.sweep(problem, &scratch.passes, tell),
        }
        drop(span);
        let _span = tracing::info_span!("store").entered();
        if parting::is_needed(&gaps) {
            kept.island.part(problem);
        }
        kept.island.store(problem, self.followed(budget));
        kept.scratch = scratch;
        problem.memory.keep(kept);
        self.end(problem, bounces, budget.substeps);
        report
    }

    /// What a problem needs, and what will bounce in it; contacts that carry nothing yet are given what they will carry.
    fn begin<L: F32xN>(
        &self,
        problem: &mut PatchProblem,
        scratch: &mut Scratch,
    ) -> (SweepBudget, Option<Bounces>) {
        let Scratch {
            body_loads,
            courses,
            ..
        } = scratch;
        let mut statistics = LoadStatistics::of(problem, body_loads);
        let bounces = statistics.bounces.then(|| restitution::find(problem));
        if cold_start::cold_start::<L>(problem, body_loads) {
            statistics = LoadStatistics::of(problem, body_loads);
        }
        let budget = SweepBudget::new(self, problem, (&statistics, &*body_loads), courses);
        (budget, bounces)
    }

    /// After its sweeps.
    fn end(&self, problem: &mut PatchProblem, bounces: Option<Bounces>, substeps: usize) {
        if let Some(bounces) = bounces {
            restitution::bounce(problem, bounces, substeps);
        }
    }

    fn spring(&self, budget: SweepBudget, dt: f32) -> Spring {
        Spring {
            omega: TAU * budget.rate / self.sweeps_per_period,
            damping_ratio: self.damping_ratio,
            h: dt / budget.substeps as f32,
        }
    }

    /// The share by which loads at rest follow what was found.
    fn followed(&self, budget: SweepBudget) -> f32 {
        let slower = match budget.downwards {
            true => SLOWER,
            false => 1.0,
        };
        (budget.sweeps() as f32 / (slower * self.preload_sweeps)).min(1.0)
    }

    /// The sweeps of a step of `dt` s, and what is done after each.
    fn plan(&self, budget: SweepBudget, dt: f32) -> Vec<Pass> {
        let mut passes = Vec::new();
        self.plan_in(budget, dt, &mut passes);
        passes
    }

    /// The same in a list that is there.
    fn plan_in(&self, budget: SweepBudget, dt: f32, passes: &mut Vec<Pass>) {
        let h = dt / budget.substeps as f32;
        passes.clear();
        for substep in 1..=budget.substeps {
            let last = substep == budget.substeps;
            let soft = Pass {
                soft: true,
                down: false,
                first: substep == 1,
                rate: 1.0 / h,
                preload: self.preload,
                drift: Some(h),
                extrapolates: false,
            };
            passes.push(soft);
            if substep % budget.substeps_per_rigid_sweep == 0 || last {
                passes.push(Pass {
                    soft: false,
                    down: budget.downwards,
                    drift: None,
                    ..soft
                });
            }
            if let Some(pass) = passes.last_mut().filter(|_| !last) {
                pass.extrapolates = true;
            }
        }
    }
}

/// Gives contacts that carry nothing yet what they carry while nothing moves, to start from and as loads at rest. Bodies stay as they are.
pub(crate) fn settle(problem: &mut PatchProblem) {
    match SoftStep::default().width(problem, &mut None) {
        #[cfg(target_arch = "x86_64")]
        Width::Eight => settle_in::<F32x8>(problem),
        Width::Four => settle_in::<F32x4>(problem),
    }
}

fn settle_in<L: F32xN>(problem: &mut PatchProblem) {
    let mut body_loads = Vec::new();
    LoadStatistics::of(problem, &mut body_loads);
    cold_start::cold_start::<L>(problem, &body_loads);
}

/// It was so in the last step, by itself, and for what is still so.
#[cfg(target_arch = "x86_64")]
fn was_auto<L: F32xN>(problem: &PatchProblem) -> bool {
    let kept = problem.memory.peek::<Kept<L>>();
    kept.is_some_and(|Kept { island, .. }| {
        island.lanes == Lanes::Auto && island.alone == stands_by_itself(problem)
    })
}

/// A visit to a block of eight costs 1.1 times one of four.
#[cfg(target_arch = "x86_64")]
fn fills_eight(problem: &PatchProblem, found: &mut Option<Batches>) -> bool {
    if problem.patches.len() < HALF_FULL {
        return false;
    }
    found.insert(skewed(F32x8::LANES, problem)).holds(HALF_FULL)
}

/// Patches in the mean block of eight from which on they are the faster: those of a wall of 10 × 10 hold 7, skewed, those of an arch 5.
#[cfg(target_arch = "x86_64")]
const HALF_FULL: usize = 4;
