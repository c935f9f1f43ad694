//! Which step this is, and how long.

use bevy_ecs::prelude::*;
use bevy_math::ops;

/// How long a step may be, s. Shorter ones can't be divided by in single precision, longer ones are none.
pub const LENGTHS: std::ops::RangeInclusive<f32> = 1e-7..=60.0;

/// The step at hand; a substep of it where there are several. Written by [`step`](crate::step).
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
pub struct StepTime {
    /// Length of the substep at hand, s.
    pub dt: f32,
    /// Length of the one before, s; of this one if it is the first.
    pub last: f32,
    /// The longest of recent substeps, s: this one, or a longer one that fades within half a second. Errors of position are taken
    /// back as fast as it allows, so that a short step among long ones does not make a blow of what the long ones left. With
    /// steps of one length it is that.
    pub longest: f32,
    /// Number of the substep at hand, from 0.
    pub substep: usize,
    /// How many there are.
    pub substeps: usize,
}

impl Default for StepTime {
    fn default() -> Self {
        Self {
            dt: 0.0,
            last: 0.0,
            longest: 0.0,
            substep: 0,
            substeps: 1,
        }
    }
}

impl StepTime {
    /// The substep after this one, of a step of `dt` s in so many.
    pub(crate) fn next(&self, dt: f32, substep: usize, substeps: usize) -> Self {
        let dt = dt / substeps as f32;
        let faded = self.longest * ops::exp(-dt / Self::FADES);
        Self {
            dt,
            last: if self.dt > 0.0 { self.dt } else { dt },
            longest: dt.max(faded),
            substep,
            substeps,
        }
    }

    /// The time for which a force of the last step is taken to go on, s.
    #[inline]
    pub(crate) fn carried(&self) -> f32 {
        self.dt.min(self.last)
    }

    /// How long it takes the longest step to fade to 1/e, s.
    const FADES: f32 = 0.5;

    /// Length of the whole step, s.
    #[inline]
    pub fn whole(&self) -> f32 {
        self.dt * self.substeps as f32
    }

    /// True in the last substep.
    #[inline]
    pub fn is_last(&self) -> bool {
        self.substep + 1 == self.substeps
    }
}
