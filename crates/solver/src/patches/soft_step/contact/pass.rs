//! The parameters of a pass: one sweep, and what follows it.

use super::smooth::Smooth;
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
    /// Which motions are smooth.
    pub smooth: Smooth,
}

impl Pass {
    /// Finishes the pass for a body, after the last visit to it. The forces of the next substep and the contact impulses of the last one
    /// are an extrapolation of its velocity.
    #[inline(always)]
    pub fn end(&self, velocity: &Cell<State>, before: &Cell<State>, motion: &Cell<State>) {
        self.drift(velocity, before, motion);
        self.extrapolate(velocity, before);
    }

    /// Moves a body, if bodies drift after this pass: by its velocity at the end of the substep or, in a smooth motion, by the mean of
    /// those at the beginning and at the end.
    #[inline(always)]
    pub fn drift(&self, velocity: &Cell<State>, before: &Cell<State>, motion: &Cell<State>) {
        let Some(h) = self.drift else { return };
        let (now, was) = (velocity.get(), before.get());
        let gained = [now[0] - was[0], now[1] - was[1]];
        let back = match self.smooth.is(now, gained, h) {
            true => 0.5 * h,
            false => 0.0,
        };
        let [linear, angular] = motion.get();
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
