//! The loads on the bodies of a structure in a step, as impulses.
//!
//! A body of a structure that accelerates needs a force for that, and it passes on the rest of its load. So its load is the impulse of
//! contacts, weight and other forces, less what its own part of the acceleration takes: that of the whole, with its centripetal and
//! gyroscopic parts. These loads are in equilibrium, unless something that does not move holds the structure.

use super::reduced::{MemberOf, Reduced};
use super::structure::Structure;
use super::whole::{Twist, Whole};
use crate::{Body, Both, JointConstraint, PatchConstraint, PatchProblem};
use glam::{DVec3, Vec3};

/// An impulse and a moment about the centre of mass, N·s and N·m·s.
pub type Load = [DVec3; 2];

/// Loads change within a step if they differ at its end from their mean by more than this share of all.
const STEADY: f64 = 0.05;

/// The loads on a structure.
#[derive(Clone, Debug, Default)]
pub struct Loads {
    /// By member: over the step, and at the rate of its end.
    pub mean: Vec<Load>,
    pub last: Vec<Load>,
    /// The sum of the sizes of all impulses, and of their changes within the step, N·s.
    all: f64,
    changes: f64,
}

impl Loads {
    /// Whether they are the same during the whole step.
    pub fn are_steady(&self) -> bool {
        self.changes <= STEADY * self.all
    }

    fn add(&mut self, member: usize, mean: Load, last: Load) {
        self.all += mean[0].length();
        self.changes += (mean[0] - last[0]).length();
        for i in 0..2 {
            self.mean[member][i] += mean[i];
            self.last[member][i] += last[i];
        }
    }
}

/// The loads of each structure that was solved as one body. `problem` still has the velocities with which the step began.
pub fn loads(
    problem: &PatchProblem,
    (structures, wholes): (&[Structure], &[Option<Whole>]),
    reduced: &Reduced,
    member_of: &MemberOf,
) -> Vec<Loads> {
    let each = structures.iter().zip(wholes);
    let mut all: Vec<Loads> = each
        .map(|(structure, whole)| match whole {
            Some(whole) => forces(structure, whole, problem.bodies),
            None => Loads::default(),
        })
        .collect();
    for (patch, &source) in reduced.patches.iter().zip(&reduced.source) {
        let source = &problem.patches[source as usize];
        for side in 0..2 {
            if let Some((structure, member)) = member_of[source.bodies[side] as usize] {
                let arm = source.arms[side];
                let [mean, last] = push(patch, arm, side, reduced);
                all[structure as usize].add(member as usize, mean, last);
            }
        }
    }
    for (joint, &source) in reduced.joints.iter().zip(&reduced.joint_source) {
        let source = &problem.joints[source as usize];
        for side in 0..2 {
            if let Some((structure, member)) = member_of[source.bodies[side] as usize] {
                let [mean, last] = pull(joint, source, side, problem.dt);
                all[structure as usize].add(member as usize, mean, last);
            }
        }
    }
    for ((structure, whole), loads) in structures.iter().zip(wholes).zip(&mut all) {
        if let Some(whole) = whole
            && !structure.is_anchored
        {
            let solved = &reduced.bodies[structure.members[0] as usize];
            let [_, spin] = solved.motion.unwrap_or([solved.linear, solved.angular]);
            let spin = spin.as_dvec3();
            for list in [&mut loads.mean, &mut loads.last] {
                balance(whole, spin, f64::from(problem.dt), list);
            }
        }
    }
    all
}

/// The impulses of weight and other forces, and of velocities that differ from those of the whole.
fn forces(structure: &Structure, whole: &Whole, bodies: &[Body]) -> Loads {
    let of = |member: usize| &bodies[structure.members[member] as usize];
    let start = match structure.is_anchored {
        true => Twist::default(),
        false => whole.velocities(|member| of(member).start),
    };
    let count = structure.members.len();
    let mut loads = Loads {
        mean: vec![Load::default(); count],
        last: vec![Load::default(); count],
        ..Loads::default()
    };
    for (member, (mass, inertia)) in whole.masses.iter().enumerate() {
        let body = of(member);
        let [push, turn] = body.push().both(Vec3::as_dvec3);
        let given = [*mass * push, *inertia * turn];
        loads.add(member, given, given);
        let [linear, angular] = body.start.both(Vec3::as_dvec3);
        let off = linear - start.linear - start.angular.cross(whole.arms[member]);
        let spun = angular - start.angular;
        loads.add(member, [*mass * off, *inertia * spun], Load::default());
    }
    loads
}

/// The impulse of a patch on a side: over the step, and at the rate of its end.
fn push(patch: &PatchConstraint, arm: Vec3, side: usize, reduced: &Reduced) -> [Load; 2] {
    let sign = if side == 0 { 1.0 } else { -1.0 };
    let (mut sums, mut moments) = ([0.0; 2], [Vec3::ZERO; 2]);
    for point in &reduced.points[patch.range()] {
        for (i, impulse) in [point.normal, point.normal_impulse].into_iter().enumerate() {
            sums[i] += impulse;
            moments[i] += impulse * point.offset;
        }
    }
    let about = patch.twist_impulse * patch.normal + patch.rolling_impulse;
    let friction = [patch.tangential, patch.friction_impulse];
    [0, 1].both(|i| {
        let push = sums[i] * patch.normal + friction[i];
        let moment = arm.cross(push) + moments[i].cross(patch.normal) + about;
        [push, moment].both(|part| sign * part.as_dvec3())
    })
}

/// The impulse of a joint on a side: over the step, and at the rate of its end. `source` is the joint with its own arms.
fn pull(joint: &JointConstraint, source: &JointConstraint, side: usize, dt: f32) -> [Load; 2] {
    let sign = f64::from(if side == 0 { -dt } else { dt });
    // Both sides get it at the anchor of B.
    let arm = match side {
        0 => source.arms[0] + source.gap,
        _ => source.arms[1],
    };
    let [force, torque] = joint.mean;
    let [x, y, z, ..] = joint.forces;
    let end = match joint.distance {
        None => joint.frames[0] * Vec3::new(x, y, z),
        Some(_) => force,
    };
    [force, end].both(|force| {
        let moment = arm.cross(force) + torque;
        [force, moment].both(|part| sign * part.as_dvec3())
    })
}

/// Takes off the part that accelerates each member. `spin` is the angular velocity of the whole, rad/s.
fn balance(whole: &Whole, spin: DVec3, dt: f64, loads: &mut [Load]) {
    let (mut push, mut moment) = (DVec3::ZERO, DVec3::ZERO);
    for (arm, load) in whole.arms.iter().zip(&*loads) {
        push += load[0];
        moment += arm.cross(load[0]) + load[1];
    }
    let gyroscopic = dt * spin.cross(whole.inertia * spin);
    let turn = whole.inertia.inverse() * (moment - gyroscopic);
    let gain = push / whole.mass;
    for (member, load) in loads.iter_mut().enumerate() {
        let (mass, inertia) = &whole.masses[member];
        let arm = whole.arms[member];
        load[0] -= *mass * (gain + turn.cross(arm) + dt * spin.cross(spin.cross(arm)));
        load[1] -= *inertia * turn + dt * spin.cross(*inertia * spin);
    }
}
