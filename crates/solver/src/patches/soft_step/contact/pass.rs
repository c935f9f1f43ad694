//! The parameters of a pass: one sweep, and what follows it.

use crate::lanes::State;
use std::cell::Cell;

/// The parameters of one pass.
#[derive(Clone, Copy, Debug)]
pub struct Pass {
    /// Rows are springs; otherwise they are rigid.
    pub soft: bool,
    /// The sweep goes from the last block to the first.
    pub down: bool,
    /// This is the first substep of the step.
    pub first: bool,
    /// Inverse length of a substep, 1/s.
    pub rate: f32,
    /// Share of a load that is being taken off which soft rows hold on to.
    pub preload: f32,
    /// After the pass, bodies drift for this time, s.
    pub drift: Option<f32>,
    /// Another substep follows the pass.
    pub extrapolates: bool,
    /// The speed that a body gains in a substep that falls, m/s; 0 if bodies drift with the velocities at the ends of substeps.
    pub fall: f32,
    /// What they stand on accelerates, so that also bodies that do not turn drift smoothly.
    pub shaken: bool,
}

/// The acceleration below which a motion is smooth, over that of free fall. A blow is more.
const SMOOTH_ACCELERATION: f32 = 1.5;

/// The speed from which on a body drifts smoothly, over that gained in a substep. Bodies at rest are held by springs whose damping counts
/// on the velocity at the end of a substep.
const SMOOTH_SPEED: f32 = 4.0;

/// The angular speeds between which a body rocks, rad/s. What turns faster rolls or tumbles.
const ROCKS: std::ops::Range<f32> = 0.1..4.0;

impl Pass {
    /// Finishes the pass for a body, after the last visit to it. The forces of the next substep and the contact impulses of the last one
    /// are an extrapolation of its velocity.
    #[inline(always)]
    pub fn end(&self, velocity: &Cell<State>, before: &Cell<State>, motion: &Cell<State>) {
        self.drift(velocity, before, motion);
        self.extrapolate(velocity, before);
    }

    /// Moves a body, if bodies drift after this pass: by its velocity at the end of the substep, or, if its motion is fast and smooth, by
    /// the mean of those at the beginning and at the end. With that at the end alone, a body that swings down onto an edge would arrive
    /// there with less energy than it has lost in height.
    #[inline(always)]
    pub fn drift(&self, velocity: &Cell<State>, before: &Cell<State>, motion: &Cell<State>) {
        let Some(h) = self.drift else { return };
        let (now, was) = (velocity.get(), before.get());
        let [linear, angular] = motion.get();
        let gained = [now[0] - was[0], now[1] - was[1]];
        let fall2 = self.fall * self.fall;
        let is_smooth = gained[0].length_squared()
            < SMOOTH_ACCELERATION * SMOOTH_ACCELERATION * fall2
            && (self.shaken || {
                let square = now[1].length_squared();
                square > ROCKS.start * ROCKS.start && square < ROCKS.end * ROCKS.end
            })
            && now[0].length_squared() > SMOOTH_SPEED * SMOOTH_SPEED * fall2;
        let back = if is_smooth { 0.5 * h } else { 0.0 };
        motion.set([
            linear + (h * now[0] - back * gained[0]),
            angular + (h * now[1] - back * gained[1]),
        ]);
    }

    /// Extrapolates the velocity of a body, if another substep follows.
    #[inline(always)]
    pub fn extrapolate(&self, velocity: &Cell<State>, before: &Cell<State>) {
        if self.extrapolates {
            let now = velocity.get();
            let was = before.replace(now);
            velocity.set([now[0] + (now[0] - was[0]), now[1] + (now[1] - was[1])]);
        }
    }
}
