//! Soft Step, the default solver of drystone: many short substeps with one sweep each, over contacts that are damped springs. A *sweep*
//! visits every contact once.
//!
//! - **Substeps** instead of iterations (Macklin et al. 2019, "Small Steps in Physics Simulation"; Box2D v3's Soft Step). Contacts are
//!   detected once per step. Normals and arms stay frozen; separations and slips follow the bodies.
//! - **Soft rows** for normals and for anchored friction ([`contact::block`]): a sweep that has not converged leaves an error of position,
//!   which the next substeps correct, and not an error of velocity, which would shake the structure. The stiffness of the rows follows the
//!   rate of sweeps ([`SoftStep::sweeps_per_period`]). The patches of a body share it, since a brick with six neighbours is held by six
//!   springs.
//! - **Sweeps by need** ([`sweeps::budget`]): sweeps come at a rate, so that a structure is equally stiff at any step length. Structures
//!   that are tall, carry much, or have not settled yet get more of them.
//! - **Impulses carry over whole** from substep to substep. With frozen arms they repeat what they did before, so that forces and warm
//!   start are an extrapolation of the velocities and cost no pass over the contacts.
//! - **Every third substep is followed by a rigid sweep** that only stops motion. Without rigid sweeps, disturbances grow from course to
//!   course in walls and pyramids of 40 courses. Those get one after every second substep; at equal sweeps, that makes arches tremble and
//!   small pyramids drift twice as far.
//! - **Rigid sweeps go down** in very tall structures ([`SweepBudget::downwards`]), from the top to the ground.
//! - **Preload**: a spring gives way under its load, and a tower of springs sinks and leans. So each row applies its load at rest by
//!   itself, and its spring rests where the surfaces meet and where friction took hold; this is integral action. The load at rest follows
//!   the mean of a patch slowly, because a fast one shakes. It follows the difference of a point from that mean, which a leaning body
//!   causes, far more slowly, or bodies would rock. A row from which load is taken off holds on to most of it, which makes the row stiffer
//!   on that side; towers need this to stand.
//! - **The longest of recent steps** sets the stiffness ([`PatchProblem::longest`]): springs that became stiffer in every short step would
//!   throw the bodies that had sunk in a long one.
//! - **Blows** ([`blows`]): where bodies hit each other, a substep gets more sweeps, and the next substep begins without the blow.
//! - **Joints** ([`joints`]) are solved directly, after the contacts of every sweep. Sweeps of their islands do not overlap.
//! - **Parting** ([`parting`]): bodies that overlap deeply are moved apart and gain no velocity by it.
//! - **Settling** ([`settling`]): in worlds with sleeping, a tall structure that sways loses speed, so that it comes to rest.
//! - **Cold start** ([`start`]): a structure that was just built gets impulses and loads that keep it still, and the supports of a
//!   removed body lose its load.
//! - **Patches side by side** ([`lanes`](crate::lanes)): four or eight patches, as many as a register holds numbers, are relaxed at
//!   once, in blocks whose patches share no body ([`batches`](crate::batches)). Where patches stand in a row, a block holds patches
//!   of several sweeps ([`sweeps::skewed`]). Light bodies on one that is far heavier are relaxed in rounds
//!   ([`rounds`](crate::rounds)).
//! - The points of a patch share one friction force and one twist, held by one anchor.
//!
//! `examples/study` measures the effect of each part; `docs/stability.md` has the results.

mod blows;
mod contact;
mod gaps;
mod grabs;
mod island;
mod joints;
mod kept;
#[cfg(test)]
mod masonry;
mod parting;
mod refresh;
mod settling;
mod spinners;
mod start;
mod sweeps;
mod together;

use super::restitution::{self, Bounces};
use super::{PatchProblem, PatchSolver};
use crate::batches::Batches;
use crate::lanes::{F32x4, F32xN};
#[cfg(target_arch = "x86_64")]
use crate::lanes::{F32x8, F32x8AsFour};
use crate::width::Width;
use crate::{Lanes, SolveReport};
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::{Reflect, std_traits::ReflectDefault};
use contact::block::{Pass, Spring};
use gaps::Gaps;
#[cfg(target_arch = "x86_64")]
use island::{skewed, stands_by_itself};
use kept::{Kept, Scratch};
use std::f32::consts::TAU;
use sweeps::budget::SweepBudget;
use sweeps::load_statistics::LoadStatistics;
use sweeps::quiet::{first_round, may_be_quiet};

/// Factor by which loads at rest follow more slowly in very tall structures ([`SweepBudget::downwards`]). Such structures sway slowly, and
/// loads that follow the sway amplify it: a tower of 200 layers of planks falls after 20 s if they follow as usual, sooner with more or
/// stiffer springs, and drifts by 3 mm in a minute if they follow a tenth as fast.
const TALL_SLOWDOWN: f32 = 40.0;

/// Upper bound of the settings for sweeps per step.
const SWEEPS: usize = 1_000_000;

/// The default contact solver: many short substeps with one sweep each, over contacts that are damped springs. It works on patches.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect), reflect(Debug, Default))]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SoftStep {
    /// Damping ratio ζ of soft rows. 5 to 20 work.
    pub damping_ratio: f32,
    /// Sweeps per period of the spring of a soft row. Fewer make it stiffer: at 9.5 an arch shakes at Δt 0.1, below 9 tall stacks do; above
    /// 11 they lean.
    pub sweeps_per_period: f32,
    /// Share of a load that is being taken off which soft rows hold on to, 0..1.
    pub preload: f32,
    /// Number of sweeps in which the mean load approaches a new load by 1 − 1/e. 800 make towers drift.
    pub preload_sweeps: f32,
    /// Longest substep, s. A step takes as many substeps as it needs to stay below; structures that are tall or carry much take more.
    pub max_substep: f32,
    /// Minimum number of sweeps in a step, soft and rigid ones together.
    pub min_sweeps: usize,
    /// Maximum number of sweeps in a step. The stiffness of springs follows the rate of sweeps, so springs are softer where the length of
    /// the step and the structure call for more sweeps than this.
    pub max_sweeps: usize,
    /// Number of patches that are relaxed side by side.
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
        // Islands that are solved together have no history of their own.
        if problems.iter().any(|problem| problem.record_history) {
            return problems.iter_mut().map(|one| self.solve(one)).collect();
        }
        match self.lanes.width(|| false) {
            #[cfg(target_arch = "x86_64")]
            Width::Eight => self.solve_together::<F32x8, F32x8>(problems),
            #[cfg(target_arch = "x86_64")]
            Width::Four if F32x8AsFour::is_available() => {
                self.solve_together::<F32x4, F32x8AsFour>(problems)
            }
            Width::Four => self.solve_together::<F32x4, F32x4>(problems),
        }
    }
}

impl SoftStep {
    /// The width for a problem: that of the last step if the patches are the same. If it becomes eight, `found` gets the blocks that were
    /// computed for the decision.
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
            Some(kept) => std::mem::take(&mut kept.scratch),
            None => Scratch::default(),
        };
        let span = tracing::info_span!("refresh").entered();
        let (budget, bounces) = self.begin::<L>(problem, &mut scratch);
        let gaps = Gaps::of(problem);
        let hits = blows::expected(problem, &gaps);
        let mut tops = match hits {
            true => spinners::Found::default(),
            false => spinners::Found::of(problem),
        };
        let spins = !tops.is_empty();
        let straight = hits || spins || budget.downwards || !problem.joints.is_empty();
        let mut kept = Kept::<L>::of(kept, problem, self.lanes, batches, straight);
        let island = &mut kept.island;
        island.spinners.take(&mut tops);
        // With so few sweeps, passing blocks from core to core takes longer than a second thread saves.
        let threads = problem.threads;
        let may_be_quiet = !hits && island.alone && may_be_quiet(problem, bounces.is_some());
        if may_be_quiet {
            problem.threads = 1;
        }
        island.deepest = parting::deepest(&gaps);
        let spring = self.spring(budget, problem.dt);
        self.plan_in(budget, problem.dt, &mut scratch.passes);
        let passes = &*scratch.passes;
        let (first, others) = passes.split_at(match may_be_quiet {
            true => first_round(passes, problem.effort),
            false => passes.len(),
        });
        // Where blows are expected or bodies spin, each sweep ends before the next begins.
        let may_follow = if hits || spins { 0 } else { first.len() };
        let (free_merit, changes) =
            island.start_and_sweep(problem, budget.substeps, &spring, (passes, may_follow));
        drop(span);
        let span = tracing::info_span!("sweeps").entered();
        let mut report = SolveReport::new(free_merit, problem.record_history);
        let mut tell = |change: f32| {
            report.record(change.max(0.0).sqrt());
        };
        let done = changes.len();
        changes.into_iter().for_each(&mut tell);
        match hits {
            true => island.sweep_through_blows(&mut kept.blows, problem, passes, &mut tell),
            false => kept.sweep_if_needed(problem, [&first[done..], others], threads, &mut tell),
        }
        drop(span);
        let _span = tracing::info_span!("store").entered();
        if parting::is_needed(&gaps) {
            kept.island.part(problem);
        }
        kept.island.store(problem, self.followed(budget));
        tops.restore(problem);
        self.end(problem, bounces, budget.substeps);
        settling::damp(problem, &scratch.body_loads);
        kept.scratch = scratch;
        problem.memory.keep(kept);
        report
    }

    /// Finds the sweeps that a problem needs and the contacts that will bounce. Cold-starts contacts that carry nothing yet.
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
        if start::cold_start::<L>(problem, body_loads) {
            statistics = LoadStatistics::of(problem, body_loads);
        }
        let budget = SweepBudget::new(self, problem, (&statistics, &*body_loads), courses);
        (budget, bounces)
    }

    /// Applies restitution after the sweeps.
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

    /// The share by which loads at rest follow the impulses of this step.
    fn followed(&self, budget: SweepBudget) -> f32 {
        let slower = match budget.downwards {
            true => TALL_SLOWDOWN,
            false => 1.0,
        };
        (budget.followed / (slower * self.preload_sweeps)).min(1.0)
    }

    /// The sweeps of a step of `dt` s, in order.
    fn plan(&self, budget: SweepBudget, dt: f32) -> Vec<Pass> {
        let mut passes = Vec::new();
        self.plan_in(budget, dt, &mut passes);
        passes
    }

    /// Like [`plan`](Self::plan), but reuses a list.
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

/// Gives contacts that carry nothing yet the impulses that they have in equilibrium, as warm start and as loads at rest. Bodies do not
/// move. The problem has no joints.
pub fn settle(problem: &mut PatchProblem) {
    let mut body_loads = Vec::new();
    LoadStatistics::of(problem, &mut body_loads);
    let Some(search) = start::start_at_rest(problem, &body_loads) else {
        return;
    };
    match SoftStep::default().width(problem, &mut None) {
        #[cfg(target_arch = "x86_64")]
        Width::Eight => search.run::<F32x8>(problem),
        Width::Four => search.run::<F32x4>(problem),
    }
}

/// Whether [`Lanes::Auto`] chose this width in the last step, and the reason still holds.
#[cfg(target_arch = "x86_64")]
fn was_auto<L: F32xN>(problem: &PatchProblem) -> bool {
    let kept = problem.memory.peek::<Kept<L>>();
    kept.is_some_and(|Kept { island, .. }| {
        island.lanes == Lanes::Auto && island.alone == stands_by_itself(problem)
    })
}

/// Whether blocks of eight are faster. A visit to a block of eight costs 1.1 times one of four.
#[cfg(target_arch = "x86_64")]
fn fills_eight(problem: &PatchProblem, found: &mut Option<Batches>) -> bool {
    if problem.patches.len() < HALF_FULL {
        return false;
    }
    found.insert(skewed(F32x8::LANES, problem)).holds(HALF_FULL)
}

/// Mean number of patches in a block of eight from which on it is faster: skewed, those of a wall of 10 × 10 hold 7, those of an arch 5.
#[cfg(target_arch = "x86_64")]
const HALF_FULL: usize = 4;
