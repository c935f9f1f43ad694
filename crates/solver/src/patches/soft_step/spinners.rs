//! Spinners: bodies that turn by much in a step while contacts hold them, such as tops, coins and wheels.
//!
//! The gyroscopic term rotates the angular velocity of a body about its spin. If contacts were solved for the whole step first and the term came
//! after them, both would be wrong for a spin that turns by a large angle in a step: the friction at the tip of a top would hold a point that is
//! about to swing away. So each substep of a spinner ends with its own gyroscopic change, and its inertia turns with it. Its arms swing with the
//! principal axis that it spins about, but do not turn about it: the tip of a top lies on that axis, and a wheel touches the ground with other points from
//! substep to substep.

use super::block::Pass;
use super::island::Island;
use super::joints::{Joints, Member};
use crate::Both;
use crate::PatchProblem;
use crate::batches::Batches;
use crate::lanes::{F32xN, State};
use crate::revision::Revision;
use crate::{Body, body::trace};
use glam::{Quat, Vec3, Vec4};

/// A body is a spinner if it turns by more than this in a step, rad.
const FAST: f32 = 0.05;

/// The inertia of a body counts as that of a ball if its moments differ by less than this share of their sum. A ball has no gyroscopic term.
const ALIKE: f32 = 1e-3;

/// Whether the solver turns a body in its substeps.
fn spins(body: &Body, dt: f32) -> bool {
    let turns = body.start[1].length_squared() * dt * dt > FAST * FAST;
    turns && body.inverse_mass > 0.0 && !body.is_upright() && !is_alike(body)
}

fn is_alike(body: &Body) -> bool {
    let i = body.inverse_inertia;
    let third = trace(&i) / 3.0;
    let others = [i.x_axis.x, i.y_axis.y, i.z_axis.z].map(|moment| moment - third);
    let mixed = [i.x_axis.y, i.x_axis.z, i.y_axis.z];
    let largest = others.into_iter().chain(mixed).map(f32::abs);
    largest.fold(0.0, f32::max) < ALIKE * third
}

/// Whether some body of a problem is a spinner.
pub fn any(problem: &PatchProblem) -> bool {
    problem.bodies.iter().any(|body| spins(body, problem.dt))
}

/// The spinners of an island during a step. Bodies with joints are none, because joints turn their bodies in substeps anyway.
#[derive(Default)]
pub struct Spinners {
    spinners: Vec<Spinner>,
    ends: Vec<End>,
    /// Length of a substep, s.
    h: f32,
}

struct Spinner {
    member: Member,
    /// The principal axis that it spins about, at the beginning of the step, if there is one.
    axis: Option<Vec3>,
    /// How that axis has swung since the beginning of the step.
    swing: Quat,
    /// How it has swung in the last substep.
    last_swing: Quat,
}

/// A spinner as one side of a patch.
struct End {
    /// Its index among the spinners.
    spinner: usize,
    patch: usize,
    block: usize,
    lane: usize,
    side: usize,
    /// From its centre of mass to the centre of the patch at the beginning of the step, m.
    arm: Vec3,
}

impl Spinners {
    pub fn is_empty(&self) -> bool {
        self.spinners.is_empty()
    }

    /// Finds the spinners of a step.
    pub fn begin(
        &mut self,
        problem: &PatchProblem,
        joints: &Joints,
        batches: &Batches,
        substeps: usize,
    ) {
        self.spinners.clear();
        self.ends.clear();
        self.h = problem.dt / substeps as f32;
        for (number, body) in problem.bodies.iter().enumerate() {
            if spins(body, problem.dt) && !joints.hold(number) {
                let mut member = Member::new(number as u32);
                member.begin(body);
                self.spinners.push(Spinner {
                    axis: member.axis_of(body.start[1]),
                    member,
                    swing: Quat::IDENTITY,
                    last_swing: Quat::IDENTITY,
                });
            }
        }
        if self.spinners.is_empty() {
            return;
        }
        for (block, lanes) in batches.iter().enumerate() {
            for (lane, patch) in lanes {
                let ends = problem.patches[patch as usize];
                for (side, body) in ends.bodies.into_iter().enumerate() {
                    // They are in the order of bodies.
                    let found = self
                        .spinners
                        .binary_search_by_key(&body, |spinner| spinner.member.body);
                    self.ends.extend(found.ok().map(|spinner| End {
                        spinner,
                        patch: patch as usize,
                        block,
                        lane,
                        side,
                        arm: ends.arms[side],
                    }));
                }
            }
        }
    }

    /// Stores how they have moved. `motions` are those of the island.
    pub fn store(&self, problem: &mut PatchProblem, motions: &[State]) {
        for Spinner { member, .. } in &self.spinners {
            let body = &mut problem.bodies[member.body as usize];
            let motion = member.motion_of_step(&motions[member.body as usize]);
            body.motion = Some(motion.both(|motion| motion / problem.dt));
            body.motion_is_exact = true;
        }
    }
}

impl<L: F32xN> Island<L> {
    /// Turns the spinners after a drift.
    pub fn turn_spinners(&mut self, pass: &Pass, velocities_are_extrapolated: bool) {
        if pass.drift.is_none() {
            return;
        }
        let drifted = match velocities_are_extrapolated {
            true => &self.before,
            false => &self.velocities,
        };
        let Spinners { spinners, ends, h } = &mut self.spinners;
        for spinner in &mut *spinners {
            let member = &mut spinner.member;
            let velocity = drifted[member.body as usize].both(Vec4::truncate);
            let motion = &mut self.motions[member.body as usize];
            let turn = Quat::from_scaled_axis(*h * velocity[1]) * member.placement.turned;
            // Contacts do not see how far it has spun, only how far its axis has swung.
            if let Some(axis) = spinner.axis {
                let swing = Quat::from_rotation_arc(axis, turn * axis);
                spinner.last_swing = swing * spinner.swing.inverse();
                spinner.swing = swing;
                motion[1] = swing.to_scaled_axis().extend(0.0);
            }
            member.drift(velocity, motion.both(Vec4::truncate), *h);
            member.refresh();
        }
        for end in &*ends {
            let Spinner { member, swing, .. } = &spinners[end.spinner];
            let block = &mut self.blocks[end.block];
            block.turn(end.lane, end.side, &member.inverse_inertia);
            block.arms[end.side].set(end.lane, *swing * end.arm);
        }
        for ends in ends.chunk_by(|a, b| a.block == b.block) {
            let block = &mut self.blocks[ends[0].block];
            let points = block.range();
            block.prepare(&mut self.points[points]);
        }
    }

    /// Adds their gyroscopic change at the end of a substep, after velocities were extrapolated if another substep follows.
    pub fn carry_spins(&mut self, pass: &Pass) {
        if !pass.extrapolates && pass.soft {
            return;
        }
        for spinner in &mut self.spinners.spinners {
            let member = &mut spinner.member;
            let (now, ended) = match pass.extrapolates {
                true => {
                    let body = member.body as usize;
                    (&mut self.velocities[body][1], &mut self.before[body][1])
                }
                false => {
                    let now = &mut self.velocities[member.body as usize][1];
                    *now = member.carry_spin(now.truncate()).extend(0.0);
                    continue;
                }
            };
            // The impulses of the next substep act at arms that have swung, and so does the change of the spin by them.
            let gained = spinner.last_swing * (*now - *ended).truncate();
            // The next extrapolation does not include the gyroscopic change.
            *ended = member.carry_spin(ended.truncate()).extend(0.0);
            *now = *ended + gained.extend(0.0);
        }
        if !pass.extrapolates {
            // The next step loads them anew. Islands that are solved together are not kept.
            for end in &self.spinners.ends {
                if let Some(loaded) = self.loaded.get_mut(end.patch) {
                    *loaded = Revision::next();
                }
            }
        }
    }
}
