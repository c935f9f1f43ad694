//! Bonded patches that break within a step.
//!
//! A patch breaks in the substep in which its stress exceeds its strength, and holds nothing from then on: if it held until the end of the
//! step, a bonded wall would stop a blow of any strength. The contact of its bodies is found in the next step.
//!
//! Breaking relieves the neighbours. So of the patches that would break, one breaks only if no other of its two bodies is nearer to
//! breaking; the others get another substep. An overloaded cantilever breaks at its root, and falls in one piece.
//!
//! The filtered stress outlasts the relief, and the stress of a single substep may be that of a blow. Only if both exceed the strength, the
//! patch breaks.

use super::Joints;
use super::log::Log;
use super::row::JointRow;
use crate::joint::{MortarFailure, Section, Utilization};
use glam::Vec3;

/// A patch whose bodies are farther from where it holds them than this share of its size was moved by an edit, and has broken. Bonds yield
/// by a thousandth of that at most.
const MISFIT_FACTOR: f32 = 0.02;

/// The lesser utilization of a section by the filtered forces and by those of a substep; none if the latter do not exceed its strength.
pub fn lesser(section: &Section, filtered: [Vec3; 2], now: [Vec3; 2]) -> Option<Utilization> {
    let now = section.utilization(now).share;
    (now > 1.0).then(|| {
        let lasting = section.utilization(filtered);
        Utilization {
            share: lasting.share.min(now),
            ..lasting
        }
    })
}

/// The utilization of a section whose strength is exceeded.
fn exceeded(log: &Log) -> Option<Utilization> {
    log.used.filter(|used| used.share > 1.0)
}

impl Joints {
    /// Breaks the sections whose bodies were moved apart since the last step.
    pub fn break_misfits(&mut self) {
        for (link, log) in self.links.iter().zip(&mut self.logs) {
            let joint = &self.joints[link.joint];
            let Some(section) = &joint.section else {
                continue;
            };
            let size = section.area.sqrt();
            let slack = joint.slack[0] + size * joint.slack[1];
            if link.misfit(&self.rows, size) > MISFIT_FACTOR * size + slack {
                log.broke = Some(Utilization {
                    share: f32::INFINITY,
                    stress: 0.0,
                    how: MortarFailure::Misfit,
                });
                self.rows[link.rows.clone()]
                    .iter_mut()
                    .for_each(JointRow::release);
            }
        }
    }

    /// Breaks the sections whose strength has been exceeded in a substep.
    pub fn break_sections(&mut self) {
        if !self.logs.iter().any(|log| exceeded(log).is_some()) {
            return;
        }
        let mut most = vec![0.0_f32; self.members.len()];
        for (link, log) in self.links.iter().zip(&self.logs) {
            let Some(used) = exceeded(log) else {
                continue;
            };
            for end in link.ends {
                // Fixed bodies pass nothing on.
                if self.members[end].moves {
                    most[end] = most[end].max(used.share);
                }
            }
        }
        for piece in &mut self.pieces {
            for number in piece.links.clone() {
                let (link, log) = (&self.links[number], &mut self.logs[number]);
                let Some(used) = exceeded(log) else {
                    continue;
                };
                if link.ends.into_iter().any(|end| used.share < most[end]) {
                    continue;
                }
                log.broke = Some(used);
                log.used = None;
                self.rows[link.rows.clone()]
                    .iter_mut()
                    .for_each(JointRow::release);
                (piece.is_stale, piece.is_refreshed, piece.is_calm) = (true, true, false);
            }
        }
    }
}
