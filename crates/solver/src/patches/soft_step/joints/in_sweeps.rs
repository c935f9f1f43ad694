//! The joints of an island in its sweeps.

use crate::lanes::{F32xN, cells};
use crate::patches::soft_step::contact::pass::Pass;
use crate::patches::soft_step::island::Island;
use crate::patches::soft_step::joints::Contacts;

impl<L: F32xN> Island<L> {
    /// Solves the joints in a sweep, after its contacts. Returns Σ Δλ times what each row lacked, J.
    pub fn visit_joints(&mut self, pass: &Pass) -> f32 {
        if self.joints.is_empty() {
            return 0.0;
        }
        let contacts = Contacts {
            blocks: &mut self.blocks,
            points: &mut self.points,
            velocities: cells(&mut self.velocities),
            motions: cells(&mut self.motions),
        };
        let solved = self.joints.visit(pass, contacts);
        solved + self.swept.visit(pass.soft, cells(&mut self.velocities))
    }

    /// Lets the joints follow the drift of bodies.
    pub fn drift_joints(&mut self, pass: &Pass, velocities_are_extrapolated: bool) {
        if self.joints.is_empty() || pass.drift.is_none() {
            return;
        }
        let drifted = match velocities_are_extrapolated {
            true => &mut self.before,
            false => &mut self.velocities,
        };
        self.joints.drift(cells(drifted), cells(&mut self.motions));
        self.swept.drift(cells(drifted));
    }

    /// Ends a substep for the joints, after velocities were extrapolated, if it ends with this pass.
    pub fn end_joints(&mut self, pass: &Pass) {
        if !self.joints.is_empty() && (pass.extrapolates || !pass.soft) {
            let ended = cells(&mut self.before);
            let velocities = cells(&mut self.velocities);
            self.joints
                .end_substep(!pass.extrapolates, ended, velocities);
            let ended = &mut self.before;
            let states = [&mut *self.velocities, &mut *self.motions];
            self.swept.end_substep(!pass.extrapolates, ended, states);
        }
    }
}
