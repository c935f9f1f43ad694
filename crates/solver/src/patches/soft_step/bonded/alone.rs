//! Which structures can be solved as one body.

use super::structure::{FIXED, Structure};
use crate::{Body, JointConstraint, PatchProblem};
use glam::Vec3;

/// The anchors of a bond may be farther apart than rounding by this share of the size of its patch, and its frames by this angle, rad. If
/// an edit has moved one of its bodies farther, its rows bring the bodies back, or it breaks.
const CLOSED: f32 = 1e-3;

/// A contact of a structure that does not move with a body that does not move either carries nothing, unless they overlap by more than
/// this, m: then something was put there.
const MAX_DEPTH: f32 = 1e-3;

/// Whether a body does not move in this step.
fn rests(body: &Body) -> bool {
    body.start == [Vec3::ZERO; 2] && body.linear == Vec3::ZERO && body.angular == Vec3::ZERO
}

/// By structure: whether it is solved as one body.
pub fn are_whole(structures: &[Structure], problem: &PatchProblem) -> Vec<bool> {
    let bodies = &*problem.bodies;
    let mut are_whole: Vec<bool> = structures
        .iter()
        .map(|of| moves_as_one(of, problem))
        .collect();
    let mut of_body = vec![None; bodies.len()];
    for (number, of) in structures.iter().enumerate() {
        for &body in &of.members {
            of_body[body as usize] = Some(number);
        }
    }
    for grab in problem.grabs.iter() {
        if let Some(of) = of_body[grab.body as usize] {
            are_whole[of] = false;
        }
    }
    let is_fixed = |body: u32| bodies[body as usize].inverse_mass == 0.0;
    let stays = |body: u32| {
        let of = of_body[body as usize];
        is_fixed(body) || of.is_some_and(|of: usize| structures[of].is_anchored)
    };
    let mut take_out = |ends: [u32; 2]| {
        for body in ends {
            if let Some(of) = of_body[body as usize] {
                are_whole[of] = false;
            }
        }
    };
    // Nothing would come of a spring or a motor between two bodies that do not move against each other.
    for joint in problem.joints.iter().filter(|joint| joint.bond.is_none()) {
        let [a, b] = joint.bodies;
        let of = of_body[a as usize];
        if (of.is_some() && of == of_body[b as usize]) || (stays(a) && stays(b)) {
            take_out(joint.bodies);
        }
    }
    for patch in problem.patches.iter() {
        if !patch.bodies.into_iter().all(stays) {
            continue;
        }
        let mut points = problem.points[patch.range()].iter();
        let moves = |&body: &u32| is_fixed(body) && !rests(&bodies[body as usize]);
        let is_pushed = patch.bodies.iter().any(moves);
        if is_pushed || points.any(|point| point.separation < -MAX_DEPTH) {
            take_out(patch.bodies);
        }
    }
    are_whole
}

/// Whether nothing that moves holds a structure, its bodies turn and move freely, and are where its bonds hold them.
fn moves_as_one(structure: &Structure, problem: &PatchProblem) -> bool {
    let bodies = &*problem.bodies;
    let is_free = |&body: &u32| {
        let body = &bodies[body as usize];
        !body.is_locked() && !body.is_upright()
    };
    structure.members.iter().all(is_free)
        && structure.bonds.iter().all(|bond| {
            let joint = &problem.joints[bond.joint];
            let mut ends = bond.ends.iter().zip(&joint.bodies);
            ends.all(|(&end, &body)| end != FIXED || rests(&bodies[body as usize]))
                && is_closed(joint)
        })
}

/// Whether the bodies of a bond are where it holds them.
fn is_closed(joint: &JointConstraint) -> bool {
    let Some(section) = &joint.section else {
        return false;
    };
    let size = section.area.sqrt();
    let turn = joint.frames[0].inverse() * joint.frames[1];
    let turned = 2.0 * turn.xyz().length();
    joint.gap.length() <= joint.slack[0] + CLOSED * size && turned <= joint.slack[1] + CLOSED
}
