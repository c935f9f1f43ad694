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
//!   that are tall, carry much, or have not settled yet get more of them, and so do piles that have nearly stopped.
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
//! - **The longest of recent steps** sets the stiffness ([`PatchProblem::max_recent_dt`]): springs that became stiffer in every short step
//!   would throw the bodies that had sunk in a long one.
//! - **Blows** ([`blows`]): where bodies hit each other, a substep gets more sweeps, and the next substep begins without the blow.
//! - **Joints** ([`joints`]) are solved directly, after the contacts of every sweep. Sweeps of their islands do not overlap.
//! - **Bonded structures** ([`bonded`]) are one rigid body each while their bonds hold.
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

pub(super) mod blows;
mod bonded;
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
mod step;
mod sweeps;
mod together;

use super::{PatchProblem, PatchSolver};
use crate::lanes::F32x4;
#[cfg(target_arch = "x86_64")]
use crate::lanes::{F32x8, F32x8AsFour};
use crate::width::Width;
use crate::{Lanes, SolveReport};
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::{Reflect, std_traits::ReflectDefault};
use sweeps::load_statistics::LoadStatistics;

/// Upper bound of the settings for sweeps per step.
const MAX_SWEEPS: usize = 1_000_000;

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
    /// Ragdolls (eight limited joints and more) and nets are relaxed in sweeps instead of being solved directly: a third to a twentieth of
    /// the time, and joints that open by up to a centimetre in a fall instead of a tenth of a millimetre. Bodies that carry many times
    /// their own weight, as links of a chain or legs of a table, are always solved directly. If false, bodies that mortar bonds are solved
    /// joint by joint, and not as one body. Default: true.
    pub sweeps_joints: bool,
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
            sweeps_joints: true,
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
        if least > MAX_SWEEPS || !(1..=MAX_SWEEPS).contains(&most) {
            return Some(format!(
                "min_sweeps and max_sweeps of Soft Step are {least} and {most}, and may be {MAX_SWEEPS}, the second at least 1"
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
        self.solve_bonded(problem)
            .unwrap_or_else(|| self.solve_plain(problem))
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
    /// Solves a problem with each body as one of its own.
    fn solve_plain(&self, problem: &mut PatchProblem) -> SolveReport {
        let mut found = None;
        match self.width(problem, &mut found) {
            #[cfg(target_arch = "x86_64")]
            Width::Eight => self.solve_in::<F32x8>(problem, found),
            Width::Four => self.solve_in::<F32x4>(problem, None),
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
