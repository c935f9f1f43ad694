//! Forces that weight makes which grows slowly from zero.
//!
//! Statics lets bodies that are wedged into each other press on each other with any force, and friction then holds what in truth slides:
//! a tongue in a groove stood 12° beyond the slope on which it slides. What contacts really carry follows from how bodies give way
//! (Kao et al. 2022, "Coupled Rigid-Block Analysis"): they press where they close, and rub against where they slide. So here
//! contacts are the solver's own springs, without load, friction slides as Coulomb's does, and bodies move under a weight that grows,
//! until they rest or are seen to go. Nothing of where they come is kept, only the forces.

use super::super::SoftStep;
use super::super::block::{Pass, Spring};
use super::super::island::{Island, batches};
use crate::solver::body::speed_of;
use crate::solver::lanes::{F32xN, State};
use crate::solver::{Body, PatchProblem};
use glam::Vec4;
use std::f32::consts::TAU;

/// Length of a substep, s.
const SUBSTEP: f32 = 1.0 / 720.0;

/// Soft sweeps in a round, which a rigid one ends.
const SOFT_SWEEPS: usize = 3;
const SWEEPS: usize = SOFT_SWEEPS + 1;

/// Rounds in which weight grows, and in which it then stays what it is, at most.
const GROWING: usize = 130;
const HOLDING: usize = 480;

/// After so many of them it is seen whether bodies rest.
const LOOK: usize = 10;

/// What is slower than gravity makes in so many seconds rests.
const RESTS: f32 = 2e-5;

/// What is faster than gravity makes in so many seconds, and has not lost this share of its speed in half of the time in which it might,
/// goes.
const GOES: f32 = 5e-4;
const LOST: f32 = 0.5;

/// Visits to patches at most: no step of a large structure may take seconds.
const PATCH_VISITS: usize = 20_000_000;

/// What becomes of bodies under weight that grows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Grown {
    /// Forces hold them, which are found but for a little.
    Rest,
    /// They slide or fall, against the forces that are found.
    Go,
    /// They are too many: nothing was done.
    Unknown,
}

/// Gives contacts the impulses that weight makes, and makes them the loads at rest, whatever they carried. Points farther apart than
/// `closed` m get none.
pub fn grow<L: F32xN>(problem: &mut PatchProblem, closed: f32) -> Grown {
    if problem.patches.len() * SWEEPS * (GROWING + HOLDING) > PATCH_VISITS {
        return Grown::Unknown;
    }
    clear(problem);
    let mut island = Island::<L>::on_springs(problem, closed);
    let passes = passes();
    let weight = SUBSTEP / (problem.dt * GROWING as f32);
    for _ in 0..GROWING {
        island.push(problem.bodies, weight);
        island.sweep_each(&passes);
    }
    let gravity = problem.gravity.length();
    let mut halfway = f32::INFINITY;
    let mut speed = f32::INFINITY;
    for round in 1..=HOLDING {
        island.sweep_each(&passes);
        if round % LOOK == 0 {
            speed = island.fastest(problem.bodies);
            if speed <= RESTS * gravity {
                break;
            }
        }
        if round == HOLDING / 2 {
            halfway = speed;
        }
    }
    island.keep(problem, problem.dt / SUBSTEP);
    match speed > GOES * gravity && speed > LOST * halfway {
        true => Grown::Go,
        false => Grown::Rest,
    }
}

/// Takes from contacts what they carry.
fn clear(problem: &mut PatchProblem) {
    for patch in problem.patches.iter_mut() {
        patch.warm_tangential = Default::default();
        patch.warm_rolling = Default::default();
        patch.load_tangential = Default::default();
        (patch.warm_twist, patch.load_twist) = (0.0, 0.0);
    }
    for point in problem.points.iter_mut() {
        (point.warm_normal, point.load) = (0.0, 0.0);
    }
}

/// The sweeps of a round.
fn passes() -> [Pass; SWEEPS] {
    std::array::from_fn(|sweep| {
        let soft = sweep < SOFT_SWEEPS;
        Pass {
            soft,
            down: false,
            first: true,
            rate: 1.0 / SUBSTEP,
            preload: 0.0,
            drift: soft.then_some(SUBSTEP),
            // The last soft sweep and the rigid one share a substep.
            extrapolates: sweep + 1 != SOFT_SWEEPS,
        }
    })
}

impl<L: F32xN> Island<L> {
    /// As if everything stood still without weight, touched where it is not open, and stuck there.
    fn on_springs(problem: &PatchProblem, closed: f32) -> Self {
        let rate = SWEEPS as f32 / (SOFT_SWEEPS as f32 * SUBSTEP);
        let default = SoftStep::default();
        let spring = Spring {
            omega: TAU * rate / default.sweeps_per_period,
            damping_ratio: default.damping_ratio,
            h: SUBSTEP,
        };
        let mut island = Self::new(problem, batches(L::LANES, problem));
        island.begin(problem, &[], 1);
        island.velocities.fill(State::default());
        island.before.fill(State::default());
        island.refresh(problem, &spring, &passes()[0], closed);
        for block in &mut island.blocks {
            block.anchored = L::ONE;
            (block.slip, block.slip_twist) = ([L::ZERO; 2], L::ZERO);
            block.soften(&spring);
        }
        island
    }

    fn sweep_each(&mut self, passes: &[Pass]) {
        for pass in passes {
            self.sweep_alone(pass);
        }
    }

    /// The speed of the fastest body at the end of a substep, at its radius of gyration where it turns, m/s.
    fn fastest(&self, bodies: &[Body]) -> f32 {
        let speed = |(body, state): (&Body, &State)| {
            let [linear, angular] = state.map(Vec4::truncate);
            speed_of(linear, angular, body.square_gyration())
        };
        let states = bodies.iter().zip(&self.before);
        states.map(speed).fold(0.0, f32::max)
    }
}
