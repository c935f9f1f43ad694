//! Swept joints: joints that are relaxed in every sweep, as contacts are, instead of being solved directly.
//!
//! A direct solve is exact whatever hangs on a joint, and takes ten times as long as a sweep. Sweeps converge quickly where no body carries
//! many times its own weight. So ragdolls, and nets of so many bodies that a factorization would fill up, are swept, and [the
//! choice](super::choice) is made anew in each step.
//!
//! - A joint holds three translations of its anchors together, by a block of 3 × 3, and any number of rotations one by one: locked or
//!   limited ones, and dry friction.
//! - Joints lie side by side in lanes ([`block`]), in the order in which they were spawned ([`Batches`]).
//! - Directions, masses and errors follow the bodies in every substep ([`turn`]).
//! - Impulses are applied anew where directions have changed, as in the direct solve; they turn along with A.
//! - Rows are springs in soft sweeps. Rigid ones would diverge in nets: with impulses that carry over from substep to substep, the error of
//!   a sweep with the matrix G follows z² = 2μz − μ for each eigenvalue μ of G, which is stable for real μ only.
//! - Springs do not yield to loads at rest, which follow the forces of bodies that are slow.

pub mod block;
mod load;
mod turn;

use super::Joints;
use crate::Both;
use crate::batches::Batches;
use crate::lanes::{F32xN, State, cells};
use crate::patches::soft_step::contact::spring::Spring;
use crate::{Body, PatchProblem};
use block::{AngularRow, JointBlock, Note, Relax};
use std::cell::Cell;
use turn::{BodyBlock, Correction, Drift, Refresh, Spin, Turned};

/// The swept joints of an island.
#[derive(Default)]
pub struct Swept<L: F32xN> {
    /// By joint in the order of its places: its index in the problem.
    joints: Vec<u32>,
    batches: Option<Batches>,
    blocks: Vec<JointBlock<L>>,
    rows: Vec<AngularRow<L>>,
    /// Bodies of these joints that move.
    members: Vec<u32>,
    bodies: Vec<BodyBlock<L>>,
    turned: Turned,
    correction: Correction,
    substeps: usize,
}

impl<L: F32xN> Swept<L> {
    pub fn is_empty(&self) -> bool {
        self.joints.is_empty()
    }

    /// Begins a step, and applies the impulses to begin with to velocities.
    pub fn begin(
        &mut self,
        joints: &Joints,
        problem: &PatchProblem,
        spring: &Spring,
        substeps: usize,
        [velocities, motions]: [&mut [State]; 2],
    ) {
        if joints.has_new_swept() || self.joints != joints.swept() {
            self.joints = joints.swept().to_vec();
            self.batches = None;
        }
        if self.is_empty() {
            return;
        }
        self.correction = Correction {
            fastest: problem.max_correction_speed,
            h: spring.h,
        };
        self.substeps = substeps;
        self.load(joints, problem, spring);
        let mut ended: Vec<State> = problem.bodies.iter().map(start).collect();
        ended.push(State::default());
        self.refresh(&mut ended, velocities, motions, false);
    }

    /// Visits all joints once. Returns Σ Δλ times what each row lacked, J.
    pub fn visit(&mut self, soft: bool, velocities: &[Cell<State>]) -> f32 {
        if self.is_empty() {
            return 0.0;
        }
        L::run(Relax {
            blocks: &mut self.blocks,
            rows: &mut self.rows,
            velocities,
            soft,
        })
    }

    /// Follows a drift of bodies with these velocities.
    pub fn drift(&mut self, velocities: &[Cell<State>]) {
        if self.is_empty() {
            return;
        }
        L::run(Drift {
            bodies: &self.bodies,
            rotations: cells(&mut self.turned.rotations),
            velocities,
            h: self.correction.h,
        });
    }

    /// Ends a substep: records its forces, and prepares the velocities of the next one if there is any. `ended` are the velocities with
    /// which it ended; `velocities` are extrapolated from them.
    pub fn end_substep(
        &mut self,
        is_last: bool,
        ended: &mut [State],
        [velocities, motions]: [&mut [State]; 2],
    ) {
        if self.is_empty() {
            return;
        }
        L::run(Note {
            blocks: &mut self.blocks,
            rows: &self.rows,
            rate: 1.0 / self.correction.h,
        });
        if !is_last {
            self.refresh(ended, velocities, motions, true);
        }
    }

    /// Takes over how bodies have moved.
    fn refresh(
        &mut self,
        ended: &mut [State],
        velocities: &mut [State],
        motions: &mut [State],
        are_applied: bool,
    ) {
        let velocities = cells(velocities);
        let Turned { rotations, others } = &mut self.turned;
        let turned = [rotations, others].both(|list| cells(list));
        L::run(Spin {
            bodies: &self.bodies,
            rotations: turned[0],
            others: turned[1],
            ended: cells(ended),
            velocities,
            h: self.correction.h,
        });
        L::run(Refresh {
            blocks: &mut self.blocks,
            rows: &mut self.rows,
            turned,
            motions: cells(motions),
            velocities,
            correction: self.correction,
            are_applied,
        });
    }
}

/// The velocities with which the last step ended.
fn start(body: &Body) -> State {
    body.start.both(|velocity| velocity.extend(0.0))
}
