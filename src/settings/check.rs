//! Validation of settings before every step. Invalid settings are set back to their last valid value and reported.

use super::{
    Gravity, NarrowphaseSettings, NormalStabilization, SleepSettings, SolverSettings, SpeedLimits,
    StabilizationSettings, Waking,
};
use crate::diagnosis::StepError;
use crate::limits;
use bevy_ecs::prelude::*;
use std::fmt;
use std::sync::Arc;

/// The settings that the last step used. It tells whether settings have changed, and what to go back to if they are invalid.
#[derive(Resource, Clone, Default, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[component(clone_behavior = Ignore)]
pub struct ActiveSettings {
    gravity: Gravity,
    stabilization: StabilizationSettings,
    narrowphase: NarrowphaseSettings,
    solver: SolverSettings,
    sleeping: SleepSettings,
    speeds: SpeedLimits,
    /// The hook of the last step. Code cannot be saved, so it is not known in the first step after loading.
    #[cfg_attr(feature = "serde", serde(skip))]
    hooks: LastHooks,
    steps: u64,
    changes: u64,
    /// Whether some settings differ from those of the step before. Sleeping bodies are woken then.
    pub changed: bool,
    /// Whether [`ContactHooks`](crate::contact::ContactHooks) was replaced, inserted or removed since the step before. Sleeping bodies
    /// whose contacts it decides about are woken then.
    pub(crate) hooks_changed: bool,
}

/// The code of [`ContactHooks`](crate::contact::ContactHooks), which stands above the settings: only whether it is the same matters here.
pub(crate) type ContactCode = Arc<dyn Send + Sync>;

/// The hook of the last step: `None` if that is not known, `Some(None)` if there was none. Its `Debug` tells nothing, as that of code does.
#[derive(Clone, Default)]
struct LastHooks(Option<Option<ContactCode>>);

impl fmt::Debug for LastHooks {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("LastHooks")
    }
}

impl ActiveSettings {
    /// How often settings have been changed.
    pub(crate) fn changes(&self) -> u64 {
        self.changes
    }

    /// Notes whether the hook of contacts is another one than in the last step.
    pub(crate) fn note_hooks(&mut self, now: Option<ContactCode>) {
        let is_same = |last: &Option<ContactCode>| match (last, &now) {
            (Some(last), Some(now)) => Arc::ptr_eq(last, now),
            (last, now) => last.is_none() && now.is_none(),
        };
        let changed = self.hooks.0.as_ref().is_some_and(|last| !is_same(last));
        if changed || self.hooks.0.is_none() {
            self.hooks.0 = Some(now);
        }
        self.hooks_changed = changed;
        self.changes += u64::from(changed);
    }
}

/// Settings that can be invalid.
trait Checked: Resource + Clone {
    const NAME: &'static str;

    /// Returns a sentence that says what is wrong, or `None`.
    fn problem(&self) -> Option<String>;

    fn is_same(&self, other: &Self) -> bool;
}

/// Sets back settings that are invalid or were removed, and notes whether any have changed.
pub(crate) fn check(world: &mut World) {
    let last = world.resource::<ActiveSettings>();
    let is_same = is_same(world, &last.gravity)
        && is_same(world, &last.stabilization)
        && is_same(world, &last.narrowphase)
        && is_same(world, &last.solver)
        && is_same(world, &last.sleeping)
        && is_same(world, &last.speeds);
    if is_same {
        let mut last = world.resource_mut::<ActiveSettings>();
        last.changed = false;
        last.steps += 1;
        return;
    }
    let mut last = world.resource::<ActiveSettings>().clone();
    let changed = [
        take_over(world, &mut last.gravity),
        take_over(world, &mut last.stabilization),
        take_over(world, &mut last.narrowphase),
        take_over(world, &mut last.solver),
        take_over(world, &mut last.sleeping),
        take_over(world, &mut last.speeds),
    ];
    // The first settings are no change.
    last.changed = last.steps > 0 && changed.contains(&true);
    last.steps += 1;
    last.changes += u64::from(last.changed);
    world.insert_resource(last);
}

/// Returns true if a resource is valid and has not changed.
fn is_same<T: Checked>(world: &World, last: &T) -> bool {
    let now = world.get_resource::<T>();
    now.is_some_and(|now| now.is_same(last) && now.problem().is_none())
}

/// Takes over a valid resource into `last`, or sets an invalid one back to it. Returns true if the resource is valid and has changed.
fn take_over<T: Checked + Component>(world: &mut World, last: &mut T) -> bool {
    let problem = match world.get_resource::<T>() {
        Some(now) => match now.problem() {
            None => {
                let changed = !now.is_same(last);
                if changed {
                    *last = now.clone();
                }
                return changed;
            }
            Some(problem) => problem,
        },
        None => "it was removed".to_owned(),
    };
    let error = StepError::InvalidSettings {
        resource: T::NAME,
        why: problem,
    };
    tracing::error!("{error}");
    world.write_message(error);
    world.insert_resource(last.clone());
    false
}

/// Reports the first number that is out of its bounds.
fn out_of_bounds(numbers: &[(&str, f32, std::ops::RangeInclusive<f32>)]) -> Option<String> {
    numbers
        .iter()
        .find(|(_, x, bounds)| !bounds.contains(x))
        .map(|(name, x, bounds)| {
            let (least, most) = (bounds.start(), bounds.end());
            format!("{name} is {x}, and must be between {least:?} and {most:?}")
        })
}

/// Largest length that a setting may have, m.
const LENGTH: f32 = 1e3;
/// Smallest positive speed limit, m/s and rad/s.
const TINY: f32 = 1e-9;

/// Strongest gravity, m/s².
const GRAVITY: f32 = 1e5;

/// Maximum number of substeps.
const SUBSTEPS: usize = 10_000;

impl Checked for Gravity {
    const NAME: &'static str = "Gravity";

    fn problem(&self) -> Option<String> {
        let fine = limits::within(self.0, GRAVITY);
        (!fine).then(|| format!("{} is not finite or above {GRAVITY:.0e} m/s²", self.0))
    }

    fn is_same(&self, other: &Self) -> bool {
        self == other
    }
}

impl Checked for StabilizationSettings {
    const NAME: &'static str = "StabilizationSettings";

    fn problem(&self) -> Option<String> {
        let friction = &self.friction;
        let normal_gain = match self.normal {
            NormalStabilization::Baumgarte { gain }
            | NormalStabilization::BaumgarteOneSided { gain } => gain,
            NormalStabilization::None | NormalStabilization::Envelope => 0.0,
        };
        out_of_bounds(&[
            ("envelope", self.envelope, 0.0..=LENGTH),
            ("ideal_distance", self.ideal_distance, 0.0..=LENGTH),
            ("the gain of `normal`", normal_gain, 0.0..=1.0),
            (
                "max_correction_speed",
                self.max_correction_speed,
                0.0..=limits::SPEED,
            ),
            ("friction.gain", friction.gain, 0.0..=2.0),
            ("friction.tolerance", friction.tolerance, 0.0..=LENGTH),
            (
                "friction.max_error",
                friction.max_error,
                0.0..=f32::INFINITY,
            ),
            (
                "friction.max_separation",
                friction.max_separation,
                0.0..=f32::INFINITY,
            ),
            ("friction.max_turn", friction.max_turn, 0.0..=f32::INFINITY),
            (
                "friction.creep_speed",
                friction.creep_speed,
                0.0..=limits::SPEED,
            ),
        ])
    }

    fn is_same(&self, other: &Self) -> bool {
        self == other
    }
}

impl Checked for SolverSettings {
    const NAME: &'static str = "SolverSettings";

    fn problem(&self) -> Option<String> {
        if !(1..=SUBSTEPS).contains(&self.outer_substeps) {
            let n = self.outer_substeps;
            return Some(format!(
                "outer_substeps is {n}, and must be between 1 and {SUBSTEPS}"
            ));
        }
        self.solver.problem()
    }

    fn is_same(&self, other: &Self) -> bool {
        self.solver == other.solver && self.outer_substeps == other.outer_substeps
    }
}

impl Checked for NarrowphaseSettings {
    const NAME: &'static str = "NarrowphaseSettings";

    fn problem(&self) -> Option<String> {
        out_of_bounds(&[
            ("recycle_share", self.recycle_share, 0.0..=1.0),
            ("match_radius", self.match_radius, 0.0..=LENGTH),
        ])
    }

    fn is_same(&self, other: &Self) -> bool {
        self == other
    }
}

impl Checked for SleepSettings {
    const NAME: &'static str = "SleepSettings";

    fn problem(&self) -> Option<String> {
        let share = match self.waking {
            Waking::Islands => 0.0,
            Waking::ByNeed { share } => share,
        };
        out_of_bounds(&[
            ("linear_speed", self.linear_speed, 0.0..=limits::SPEED),
            ("angular_speed", self.angular_speed, 0.0..=limits::SPIN),
            ("delay", self.delay, 0.0..=f32::INFINITY),
            ("settling", self.settling, 0.0..=1e3),
            ("waking.share", share, 0.0..=f32::INFINITY),
        ])
    }

    fn is_same(&self, other: &Self) -> bool {
        self == other
    }
}

impl Checked for SpeedLimits {
    const NAME: &'static str = "SpeedLimits";

    fn problem(&self) -> Option<String> {
        out_of_bounds(&[
            ("linear", self.linear, TINY..=limits::SPEED),
            ("angular", self.angular, TINY..=limits::SPIN),
        ])
    }

    fn is_same(&self, other: &Self) -> bool {
        self == other
    }
}
