//! The sweeps of a step, in order, and the spring that their rate allows.

use super::budget::SweepBudget;
use crate::patches::soft_step::SoftStep;
use crate::patches::soft_step::contact::pass::Pass;
use crate::patches::soft_step::contact::smooth::Smooth;
use crate::patches::soft_step::contact::spring::Spring;
use std::f32::consts::TAU;

/// Factor by which loads at rest follow more slowly in very tall structures ([`SweepBudget::downwards`]). Such structures sway slowly, and
/// loads that follow the sway amplify it: a tower of 200 layers of planks falls after 20 s if they follow as usual, sooner with more or
/// stiffer springs, and drifts by 3 mm in a minute if they follow a tenth as fast.
const TALL_SLOWDOWN: f32 = 40.0;

impl SoftStep {
    /// The spring of a soft row in a step of `dt` s.
    pub(crate) fn spring(&self, budget: SweepBudget, dt: f32) -> Spring {
        Spring {
            omega: TAU * budget.rate / self.sweeps_per_period,
            damping_ratio: self.damping_ratio,
            h: dt / budget.substeps as f32,
        }
    }

    /// The share by which loads at rest follow the impulses of a step.
    pub(crate) fn followed(&self, budget: SweepBudget) -> f32 {
        let slower = match budget.downwards {
            true => TALL_SLOWDOWN,
            false => 1.0,
        };
        (budget.followed / (slower * self.preload_sweeps)).min(1.0)
    }

    /// The sweeps of a step of `dt` s, in order, in a list that is written anew.
    pub(crate) fn plan<'a>(
        &self,
        budget: SweepBudget,
        dt: f32,
        smooth: Smooth,
        passes: &'a mut Vec<Pass>,
    ) -> &'a [Pass] {
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
                smooth,
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
        passes
    }
}
