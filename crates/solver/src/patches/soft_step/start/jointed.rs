//! Loads of structures with joints that stand on loose bodies.
//!
//! How much each foot of a table bears is known to its joints alone, so their [direct solve](crate::patches::soft_step::joints) finds it.
//! Then the bodies under the feet hand it down. These may lie on another structure with joints, which passes it on to its own feet in the
//! next round.

use super::MAX_PLACED_SPEED;
use super::hand_down::{self, Limits};
use crate::Both;
use crate::contact_row::add_to;
use crate::lanes::{F32xN, cells};
use crate::patches::soft_step::SoftStep;
use crate::patches::soft_step::contact::pass::Pass;
use crate::patches::soft_step::contact::spring::Spring;
use crate::patches::soft_step::island::Island;
use crate::patches::soft_step::joints::Contacts;
use crate::{Body, Lanes, PatchProblem};
use glam::Vec3;
use std::f32::consts::TAU;

/// Upper bound of rounds; as many structures may stand on each other.
const MAX_ROUNDS: usize = 16;

/// Rounds end when no foot changes by more than this share of the largest load.
const SETTLED_SHARE: f32 = 1e-5;

/// Contacts between bodies with and without joints, on which structures stand that were just built.
struct Feet {
    /// The patch, and its side of the body without joints.
    patches: Vec<(usize, usize)>,
    /// By body: it has no joints, and bears what stands on it.
    supports: Vec<bool>,
}

impl Feet {
    /// The feet that carry nothing yet, if any of them stands on a body that moves. `jointed` tells by body whether joints hold it.
    fn find(problem: &PatchProblem, closed: f32, jointed: &[bool]) -> Option<Self> {
        let is_new = |forces: &[f32]| forces.iter().all(|&force| force == 0.0);
        if !problem.joints.iter().any(|joint| is_new(&joint.forces)) {
            return None;
        }
        let moves = |body: usize| problem.bodies[body].inverse_mass > 0.0;
        let mut patches = Vec::new();
        for (number, patch) in problem.patches.iter().enumerate() {
            let bodies = patch.bodies.both(|body| body as usize);
            let side = match bodies.both(|body| jointed[body] && moves(body)) {
                [true, false] => 1,
                [false, true] => 0,
                _ => continue,
            };
            let mut points = problem.points[patch.range()].iter();
            if points.all(|point| point.normal_impulse == 0.0 && point.rest_impulse == 0.0) {
                patches.push((number, side));
            }
        }
        let support = |&(patch, side): &(usize, usize)| {
            let patch = &problem.patches[patch];
            patch.bodies[side] as usize
        };
        if !patches.iter().any(|foot| moves(support(foot))) {
            return None;
        }
        let stands = hand_down::standing(problem, closed, jointed);
        let bodies = problem.bodies.iter().zip(stands).zip(jointed);
        let slow =
            |body: &Body| body.start[0].length_squared() <= MAX_PLACED_SPEED * MAX_PLACED_SPEED;
        let supports = bodies.map(|((body, stands), jointed)| stands && !jointed && slow(body));
        let supports: Vec<bool> = supports.collect();
        patches.retain(|foot| !moves(support(foot)) || supports[support(foot)]);
        let is_loose = |foot: &(usize, usize)| moves(support(foot));
        patches
            .iter()
            .any(is_loose)
            .then_some(Self { patches, supports })
    }

    /// Finds the loads of the feet. Returns the impulse of each of their points, N·s.
    fn solve<L: F32xN>(&self, problem: &PatchProblem, closed: f32) -> Vec<Vec<f32>> {
        let pass = Pass::whole(problem.dt);
        let (mut island, _) = Island::<L>::at_rest(problem, closed, &pass);
        island.joints.place(problem, &island.batches);
        let default = SoftStep::default();
        let spring = Spring {
            omega: TAU * pass.rate / default.sweeps_per_period,
            damping_ratio: default.damping_ratio,
            h: problem.dt,
        };
        let contacts = Contacts {
            blocks: &mut island.blocks,
            points: &mut island.points,
            velocities: cells(&mut island.velocities),
            motions: cells(&mut island.motions),
        };
        let supports = &self.supports;
        island
            .joints
            .begin_on(supports, problem, &spring, 1, Lanes::Four, contacts);
        let mut found = vec![Vec::new(); problem.patches.len()];
        for (block, patches) in island.blocks.iter().zip(island.batches.iter()) {
            let points = &island.points[block.range()];
            for (lane, patch) in patches {
                let count = problem.patches[patch as usize].range().len();
                let impulses = points.iter().take(count).map(|point| point.impulse[lane]);
                found[patch as usize] = impulses.collect();
            }
        }
        let feet = self.patches.iter();
        feet.map(|&(patch, _)| std::mem::take(&mut found[patch]))
            .collect()
    }
}

/// Gives the contacts under structures with joints that were just built on loose bodies their impulses and loads at rest, and the contacts
/// below too. Returns whether there were any.
pub fn bear<L: F32xN>(problem: &mut PatchProblem, limits: Limits, jointed: &[bool]) -> bool {
    if jointed.is_empty() {
        return false;
    }
    let Some(feet) = Feet::find(problem, limits.closed, jointed) else {
        return false;
    };
    for _ in 0..MAX_ROUNDS {
        let mut before = Vec::new();
        for &(patch, _) in &feet.patches {
            for point in &mut problem.points[problem.patches[patch].range()] {
                before.push(point.normal_impulse);
                (point.normal_impulse, point.rest_impulse) = (0.0, 0.0);
            }
        }
        let found = feet.solve::<L>(problem, limits.closed);
        let mut before = before.into_iter();
        let mut motions = vec![[Vec3::ZERO; 2]; problem.bodies.len()];
        let mut pressed = vec![false; problem.bodies.len()];
        let (mut changed, mut largest) = (0f32, 0f32);
        for (&(number, side), impulses) in feet.patches.iter().zip(found) {
            let patch = &problem.patches[number];
            let support = patch.bodies[side] as usize;
            let sign = if side == 0 { 1.0 } else { -1.0 };
            let points = problem.points[patch.range()].iter_mut();
            for ((point, impulse), before) in points.zip(impulses).zip(&mut before) {
                (point.normal_impulse, point.rest_impulse) = (impulse, impulse);
                let change = impulse - before;
                changed = changed.max(change.abs());
                largest = largest.max(impulse);
                let push = sign * change * patch.normal;
                let answer = problem.bodies[support].answer(push, patch.arms[side] + point.offset);
                add_to(&mut motions[support], answer);
            }
            pressed[support] |= feet.supports[support];
        }
        if changed <= SETTLED_SHARE * largest {
            break;
        }
        hand_down::pass_on(problem, limits, pressed, motions);
    }
    true
}
