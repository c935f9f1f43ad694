//! Contact forces under a weight that grows slowly from zero.
//!
//! Statics allows any force between bodies that are wedged into each other, and friction of that force then holds bodies that slide in
//! reality: a tongue in a groove stood 12° beyond the slope on which it slides. The real forces follow from how bodies yield (Kao et al.
//! 2022, "Coupled Rigid-Block Analysis"): bodies press where they close, and rub against the surfaces where they slide. So here contacts
//! are the solver's own springs without loads at rest, friction slides as Coulomb's does, and bodies move under a growing weight until they
//! rest, or clearly slide or fall. Only the forces are kept, not the motion.

use crate::Both;
use crate::body::speed_of;
use crate::lanes::{F32xN, State};
use crate::patches::soft_step::SoftStep;
use crate::patches::soft_step::contact::pass::Pass;
use crate::patches::soft_step::contact::smooth::Smooth;
use crate::patches::soft_step::contact::spring::Spring;
use crate::patches::soft_step::island::Island;
use crate::patches::soft_step::sweeps::layout::batches;
use crate::{Body, PatchProblem};
use glam::Vec4;
use std::f32::consts::TAU;

/// Length of a substep, s.
const SUBSTEP: f32 = 1.0 / 720.0;

/// Soft sweeps in a round; one rigid sweep ends it.
const SOFT_SWEEPS_PER_ROUND: usize = 3;
const SWEEPS_PER_ROUND: usize = SOFT_SWEEPS_PER_ROUND + 1;

/// Number of rounds in which weight grows, and upper bound of rounds with the full weight after that.
const GROWING_ROUNDS: usize = 130;
const MAX_HOLDING_ROUNDS: usize = 480;

/// Number of rounds between checks whether bodies rest.
const ROUNDS_PER_CHECK: usize = 10;

/// Bodies rest below the speed that gravity gives in this time, s.
const REST_TIME: f32 = 2e-5;

/// Bodies slide or fall if they are faster than the speed that gravity gives in this time, s, and have not lost this share of their speed
/// in the second half of the rounds.
const MOVING_TIME: f32 = 5e-4;
const LOST_SHARE: f32 = 0.5;

/// Upper bound of visits to patches: no step of a large structure may take seconds.
const MAX_PATCH_VISITS: usize = 20_000_000;

/// The result for bodies under growing weight.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Grown {
    /// The forces hold them, up to a small remaining error.
    Rest,
    /// They slide or fall in spite of the forces.
    Go,
    /// The problem is too large; nothing was done.
    Unknown,
}

/// Replaces the impulses and loads at rest of contacts by those that growing weight causes. Points farther apart than `closed` m get none.
pub fn grow<L: F32xN>(problem: &mut PatchProblem, closed: f32) -> Grown {
    if problem.patches.len() * SWEEPS_PER_ROUND * (GROWING_ROUNDS + MAX_HOLDING_ROUNDS)
        > MAX_PATCH_VISITS
    {
        return Grown::Unknown;
    }
    clear(problem);
    let mut island = Island::<L>::on_springs(problem, closed);
    let passes = passes();
    let weight = SUBSTEP / (problem.dt * GROWING_ROUNDS as f32);
    for _ in 0..GROWING_ROUNDS {
        island.push(problem.bodies, weight);
        island.sweep_each(&passes);
    }
    let gravity = problem.gravity.length();
    let mut halfway = f32::INFINITY;
    let mut speed = f32::INFINITY;
    for round in 1..=MAX_HOLDING_ROUNDS {
        island.sweep_each(&passes);
        if round % ROUNDS_PER_CHECK == 0 {
            speed = island.fastest(problem.bodies);
            if speed <= REST_TIME * gravity {
                break;
            }
        }
        if round == MAX_HOLDING_ROUNDS / 2 {
            halfway = speed;
        }
    }
    island.keep(problem, problem.dt / SUBSTEP);
    match speed > MOVING_TIME * gravity && speed > LOST_SHARE * halfway {
        true => Grown::Go,
        false => Grown::Rest,
    }
}

/// Removes all impulses and loads from contacts.
fn clear(problem: &mut PatchProblem) {
    for patch in problem.patches.iter_mut() {
        patch.friction_impulse = Default::default();
        patch.rolling_impulse = Default::default();
        patch.rest_friction_impulse = Default::default();
        (patch.twist_impulse, patch.rest_twist_impulse) = (0.0, 0.0);
    }
    for point in problem.points.iter_mut() {
        (point.normal_impulse, point.rest_impulse) = (0.0, 0.0);
    }
}

/// The sweeps of a round.
fn passes() -> [Pass; SWEEPS_PER_ROUND] {
    std::array::from_fn(|sweep| {
        let soft = sweep < SOFT_SWEEPS_PER_ROUND;
        Pass {
            soft,
            down: false,
            first: true,
            rate: 1.0 / SUBSTEP,
            preload: 0.0,
            drift: soft.then_some(SUBSTEP),
            // The last soft sweep and the rigid one share a substep.
            extrapolates: sweep + 1 != SOFT_SWEEPS_PER_ROUND,
            smooth: Smooth::default(),
        }
    })
}

impl<L: F32xN> Island<L> {
    /// An island at rest and without weight. Points that are not open touch, and friction is anchored where they are.
    fn on_springs(problem: &PatchProblem, closed: f32) -> Self {
        let rate = SWEEPS_PER_ROUND as f32 / (SOFT_SWEEPS_PER_ROUND as f32 * SUBSTEP);
        let default = SoftStep::default();
        let spring = Spring {
            omega: TAU * rate / default.sweeps_per_period,
            damping_ratio: default.damping_ratio,
            h: SUBSTEP,
        };
        let mut island = Self::new(problem, batches(L::LANES, problem));
        island.begin(problem, 1);
        island.velocities.fill(State::default());
        island.before.fill(State::default());
        // There are no impulses to start from.
        island.refresh(problem, &spring, &passes()[0], closed);
        for block in &mut island.blocks {
            block.anchored = L::ONE;
            (block.slip, block.slip_twist) = ([L::ZERO; 2], L::ZERO);
            block.soften(&spring, L::splat(spring.omega));
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
            let [linear, angular] = state.both(Vec4::truncate);
            speed_of(linear, angular, body.square_gyration())
        };
        let states = bodies.iter().zip(&self.before);
        states.map(speed).fold(0.0, f32::max)
    }
}
