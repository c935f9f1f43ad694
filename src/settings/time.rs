//! The time of the current step.

use bevy_ecs::prelude::*;
use bevy_math::ops;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::{Reflect, std_traits::ReflectDefault};

/// Number and length of the current substep. Written by [`step`](crate::step()); read-only for other systems.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "bevy_reflect",
    derive(Reflect),
    reflect(Resource, Debug, Default)
)]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[component(clone_behavior = Ignore)]
pub struct StepTime {
    /// Length of the current substep, s.
    pub dt: f32,
    /// Length of the previous substep, s. In the first step it equals [`dt`](Self::dt).
    pub previous_dt: f32,
    /// Length of the longest recent substep, s: the current one, or a longer one, whose length fades by the factor 1/e in half a second.
    /// Position errors are corrected at the rate that this length allows, so that a short step among long ones does not correct in one
    /// blow the errors that the long ones left. It is never less than half a millisecond: errors of position are rounded, and corrected
    /// within microseconds, their rounding would be a speed. With longer steps of equal length it equals [`dt`](Self::dt).
    pub max_recent_dt: f32,
    /// Index of the current substep, from 0.
    pub substep: usize,
    /// Number of substeps in this step.
    pub substeps: usize,
}

impl Default for StepTime {
    fn default() -> Self {
        Self {
            dt: 0.0,
            previous_dt: 0.0,
            max_recent_dt: 0.0,
            substep: 0,
            substeps: 1,
        }
    }
}

impl StepTime {
    /// The time of the next substep, in a step of `dt` s that has `substeps` of them.
    pub(crate) fn next(&self, dt: f32, substep: usize, substeps: usize) -> Self {
        let dt = dt / substeps as f32;
        let faded = self.max_recent_dt * ops::exp(-dt / Self::FADE_TIME);
        Self {
            dt,
            previous_dt: if self.dt > 0.0 { self.dt } else { dt },
            max_recent_dt: dt.max(faded).max(Self::LEAST_RECENT),
            substep,
            substeps,
        }
    }

    /// The time for which a force of the last step is assumed to continue, s.
    #[inline]
    pub(crate) fn carried(&self) -> f32 {
        self.dt.min(self.previous_dt)
    }

    /// The smallest [`max_recent_dt`](Self::max_recent_dt), s. An arch that is built in steps of 10⁻⁷ s throws its stones at 0.9 m/s
    /// without it.
    const LEAST_RECENT: f32 = 5e-4;

    /// Time in which the longest recent step fades to 1/e of its length, s.
    const FADE_TIME: f32 = 0.5;

    /// Length of the whole step, s.
    #[inline]
    pub fn whole(&self) -> f32 {
        self.dt * self.substeps as f32
    }

    /// Returns true in the last substep of a step.
    #[inline]
    pub fn is_last(&self) -> bool {
        self.substep + 1 == self.substeps
    }
}

/// Run condition: whether this is the last substep of a step.
pub(crate) fn is_last(time: Res<StepTime>) -> bool {
    time.is_last()
}
