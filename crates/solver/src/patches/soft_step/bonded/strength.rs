//! Whether the bonds of a structure hold the loads of a step.
//!
//! Bonds break by filtered forces, within the step, by the rules of [joints](crate::patches::soft_step::joints). So a structure whose bonds
//! may not hold is solved once more, joint by joint; this module finds whether that is necessary. Loads that do not change within the step
//! decide it exactly. Of other loads, as of a blow, only the sum is known, so they count as if they came in an instant.

use super::loads::Loads;
use super::stiffness::BondForce;
use super::structure::Structure;
use super::whole::Whole;
use crate::Both;
use crate::joint::filter_share;
use crate::{JointConstraint, PatchProblem};
use glam::{DVec3, Vec3};

/// Bonds that loads of an instant would use to more than this share of their strength are solved once more.
const MAX_SHARE: f32 = 0.5;

/// A blow lasts at least this time, s: a substep.
const INSTANT: f32 = 1.0 / 720.0;

/// The forces in the bonds of a structure in a step.
#[derive(Clone, Debug, Default)]
pub struct Forces {
    /// By bond, in the axes of its joint, N and N·m: the mean over the step, and that at its end; the latter is empty if they are the same.
    mean: Vec<[Vec3; 2]>,
    last: Vec<[Vec3; 2]>,
}

impl Structure {
    /// The forces of its bonds.
    pub fn forces(&mut self, whole: &Whole, loads: &Loads, dt: f32, is_fused: bool) -> Forces {
        let back = whole.turn.inverse();
        let is_held = self.is_anchored;
        let (mut turned, mut found) = (Vec::new(), Vec::<BondForce>::new());
        let mut under = |loads: &[[DVec3; 2]]| {
            turned.clear();
            turned.extend(loads.iter().map(|load| load.both(|part| back * part)));
            self.stiffness
                .forces(&turned, is_held, is_fused, &mut found);
            let rate = 1.0 / f64::from(dt);
            let forces = found
                .iter()
                .map(|force| force.both(|part| (rate * part).as_vec3()));
            forces.collect::<Vec<_>>()
        };
        Forces {
            mean: under(&loads.mean),
            last: match loads.are_steady() {
                true => Vec::new(),
                false => under(&loads.last),
            },
        }
    }
}

impl Forces {
    /// Whether bonds may break under them within the step.
    pub fn may_break(&self, structure: &Structure, problem: &PatchProblem) -> bool {
        let dt = problem.dt;
        let is_steady = self.last.is_empty();
        structure.bonds.iter().zip(&self.mean).any(|(bond, force)| {
            let joint = &problem.joints[bond.joint];
            let share = |forces: [Vec3; 2]| bond.section().utilization(forces).share;
            let filtered = share(filtered(joint, force, dt));
            if is_steady {
                return filtered > 1.0 && share(*force) > 1.0;
            }
            let rise = dt / joint.filter.max(INSTANT);
            let blow = [0, 1].both(|i| rise * force[i]);
            let top = [0, 1].both(|i| joint.filtered[i] + blow[i]);
            filtered.max(share(blow)).max(share(top)) > MAX_SHARE
        })
    }

    /// Stores them in the problem.
    pub fn store(&self, structure: &Structure, problem: &mut PatchProblem) {
        let dt = problem.dt;
        for (number, (bond, mean)) in structure.bonds.iter().zip(&self.mean).enumerate() {
            let joint = &mut problem.joints[bond.joint];
            let [force, torque] = *self.last.get(number).unwrap_or(mean);
            joint.forces = Default::default();
            joint.forces[..3].copy_from_slice(&force.to_array());
            joint.forces[3..6].copy_from_slice(&torque.to_array());
            joint.rest = joint.forces;
            let before = joint.filtered;
            joint.filtered = filtered(joint, mean, dt);
            let larger = |i: usize| before[i].length().max(joint.filtered[i].length());
            joint.peak = [larger(0), larger(1)];
            joint.mean = mean.both(|part| joint.frames[0] * part);
            joint.late = [Vec3::ZERO; 2];
            (joint.angles, joint.broke) = (None, None);
        }
    }
}

/// The filtered forces of a joint after a step under forces, N and N·m.
fn filtered(joint: &JointConstraint, forces: &[Vec3; 2], dt: f32) -> [Vec3; 2] {
    let share = filter_share(dt, joint.filter);
    [0, 1].both(|i| joint.filtered[i] + share * (forces[i] - joint.filtered[i]))
}
