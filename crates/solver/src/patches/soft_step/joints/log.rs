//! The forces of joints over the substeps of a step.

use super::breaking;
use super::piece::Piece;
use super::row::{JointRow, Link};
use crate::Both;
use crate::JointConstraint;
use crate::joint::{Utilization, filter_share};
use glam::Vec3;

/// The forces of a joint over a step.
#[derive(Clone, Copy, Debug, Default)]
pub struct Log {
    /// Sums of force and torque, N and N·m.
    pub sum: [Vec3; 2],
    pub filtered: [Vec3; 2],
    /// Of the last rigid sweep.
    pub late: [Vec3; 2],
    pub peak: [f32; 2],
    /// How near its section is to breaking, if forces of a substep exceed its strength; and how it broke.
    pub used: Option<Utilization>,
    pub broke: Option<Utilization>,
}

/// Records the forces of the substeps of a piece that were not recorded yet. They were the same in all of them.
///
/// Where arms turn, a rigid sweep stops the motion to which the next substep would have given its impulse. In filtered forces, that impulse
/// counts as one of the next substep: a pendulum would seem to pull with 1, 3 and 5 times its weight in turns, and not with 3.
pub fn record(
    piece: &mut Piece,
    (links, rows): (&[Link], &mut [JointRow]),
    logs: &mut [Log],
    (joints, h): (&[JointConstraint], f32),
) {
    let substeps = std::mem::take(&mut piece.unrecorded);
    if substeps == 0 {
        return;
    }
    piece.is_strained = false;
    let links = links[piece.links.clone()].iter();
    // Nearly all joints of a piece have the same filter.
    let (mut filter, mut shares) = (f32::NAN, [0.0; 2]);
    for (link, log) in links.zip(&mut logs[piece.links.clone()]) {
        let joint = &joints[link.joint];
        let (mut forces, mut late) = ([Vec3::ZERO; 2], [Vec3::ZERO; 2]);
        for row in &mut rows[link.rows.clone()] {
            let after = std::mem::take(&mut row.late);
            let kind = usize::from(row.is_angular());
            forces[kind] += row.impulse / h * row.direction;
            late[kind] += after / h * row.direction;
        }
        if filter != joint.filter {
            filter = joint.filter;
            shares = [1, substeps - 1].both(|count| filter_share(count as f32 * h, filter));
        }
        let late = late.both(|force| link.geometry.local(force));
        let carried = std::mem::replace(&mut log.late, late);
        // The first substep has what the one before left over.
        let parts = shares.into_iter().zip([carried, [Vec3::ZERO; 2]]);
        for (share, carried) in parts.take(substeps as usize) {
            for i in 0..2 {
                let force = link.geometry.local(forces[i]) - late[i] + carried[i];
                log.filtered[i] += share * (force - log.filtered[i]);
                log.peak[i] = log.peak[i].max(log.filtered[i].length());
            }
        }
        for (sum, force) in log.sum.iter_mut().zip(forces) {
            *sum += substeps as f32 * force;
        }
        if let Some(section) = &joint.section
            && log.broke.is_none()
        {
            let now = forces.both(|force| link.geometry.local(force));
            log.used = breaking::lesser(section, log.filtered, now);
            piece.is_strained |= log.used.is_some();
        }
    }
}
