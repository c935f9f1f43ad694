//! Spinners: tops, which spin fast about their axis while they stand on it.
//!
//! The gyroscopic term rotates the angular velocity of a body about its spin. If contacts were solved for the whole step first and the term
//! came after them, both would be wrong for a spin that turns by a large angle in a step: the friction at the tip would hold a point that
//! is about to swing away. So each substep of a spinner ends with its own gyroscopic change. Its inertia and its arms swing with its axis,
//! because all of its contacts lie there. A wheel is no spinner: it touches the ground with other points from substep to substep.

use super::contact::pass::Pass;
use super::island::Island;
use super::joints::Member;
use crate::Body;
use crate::Both;
use crate::batches::Batches;
use crate::lanes::{F32xN, State};
use crate::revision::Revision;
use crate::{PatchConstraint, PatchPoint, PatchProblem};
use glam::{Quat, Vec3, Vec4};

/// A body is a spinner if it turns by more than this in a step, rad.
const MIN_TURN: f32 = 0.05;

/// A patch lies on the axis if the angle between them is below this, as a sine.
const AXIS_SINE: f32 = 0.2;

/// Whether a body may be a spinner. This is false for most bodies.
fn is_fast(body: &Body, dt: f32) -> bool {
    let turns = body.start[1].length_squared() * dt * dt > MIN_TURN * MIN_TURN;
    turns && body.inverse_mass > 0.0 && !body.is_upright()
}

/// A point does not touch if its separation exceeds that of the nearest point by more than this share of the distance between them.
const TOUCHING_SLOPE: f32 = 0.02;

/// From the centre of a patch to the mean of the points that touch, m. A fast top has points at its rim, because it might reach them within
/// the step.
fn touching_center(patch: &PatchConstraint, points: &[PatchPoint]) -> Vec3 {
    let points = &points[patch.range()];
    let nearer = |a: &PatchPoint, b: &PatchPoint| a.separation < b.separation;
    let nearest = points
        .iter()
        .reduce(|a, b| if nearer(b, a) { b } else { a });
    let Some(nearest) = nearest else {
        return Vec3::ZERO;
    };
    let touch = points.iter().filter(|point| {
        let apart = (point.offset - nearest.offset).length();
        point.separation - nearest.separation <= TOUCHING_SLOPE * apart
    });
    let (sum, count) = touch.fold((Vec3::ZERO, 0), |(sum, count), point| {
        (sum + point.offset, count + 1)
    });
    sum / count as f32
}

/// Whether a body with this axis stands on it: its centre of mass and all of its contacts lie on the axis.
fn stands_on(axis: Vec3, body: u32, problem: &PatchProblem) -> bool {
    let arms = problem.patches.iter().flat_map(|patch| {
        let ends = patch.bodies.into_iter().zip(patch.arms);
        let arms = ends.filter(|&(of, _)| of == body);
        arms.map(|(_, arm)| arm + touching_center(patch, problem.points))
    });
    let mut touches = false;
    for arm in arms {
        touches = true;
        if axis.cross(arm).length_squared() > (AXIS_SINE * AXIS_SINE) * arm.length_squared() {
            return false;
        }
    }
    touches
}

/// The spinners of a problem.
fn spinners(problem: &PatchProblem) -> impl Iterator<Item = Spinner> {
    let bodies = (0..).zip(problem.bodies.iter());
    let fast = bodies.filter(|(_, body)| is_fast(body, problem.dt));
    fast.filter_map(|(number, body)| {
        let mut member = Member::new(number);
        member.begin(body);
        let axis = member.axis_of_symmetry(body.start[1])?;
        stands_on(axis, number, problem).then_some(Spinner {
            member,
            axis,
            swing: Quat::IDENTITY,
            last_swing: Quat::IDENTITY,
        })
    })
}

/// The spinners of a problem, and their patches as they were before the centres of these were moved to the points that touch.
#[derive(Default)]
pub struct Found {
    spinners: Vec<Spinner>,
    patches: Vec<(usize, [Vec3; 2])>,
    points: Vec<(usize, Vec3)>,
}

impl Found {
    /// Finds the spinners, and moves the centres of their patches. Friction acts at the centre of a patch, and would hold a top at its rim
    /// otherwise. Problems with joints have none, because joints turn their bodies in substeps anyway.
    pub fn of(problem: &mut PatchProblem) -> Self {
        let mut found = Self::default();
        if !problem.joints.is_empty() {
            return found;
        }
        found.spinners.extend(spinners(problem));
        if found.spinners.is_empty() {
            return found;
        }
        for (number, patch) in problem.patches.iter_mut().enumerate() {
            let is_of = |spinner: &Spinner| patch.bodies.contains(&spinner.member.body);
            if !found.spinners.iter().any(is_of) {
                continue;
            }
            let shift = touching_center(patch, problem.points);
            found.patches.push((number, patch.arms));
            patch.arms = patch.arms.both(|arm| arm + shift);
            for point in patch.range() {
                let offset = &mut problem.points[point].offset;
                found.points.push((point, *offset));
                *offset -= shift;
            }
        }
        found
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.patches.is_empty()
    }

    /// Moves the centres back.
    pub fn restore(self, problem: &mut PatchProblem) {
        for (number, arms) in self.patches {
            problem.patches[number].arms = arms;
        }
        for (number, offset) in self.points {
            problem.points[number].offset = offset;
        }
    }
}

/// The spinners of an island during a step.
#[derive(Default)]
pub struct Spinners {
    spinners: Vec<Spinner>,
    ends: Vec<End>,
    /// Length of a substep, s.
    h: f32,
}

struct Spinner {
    member: Member,
    /// The axis that it spins about, at the beginning of the step.
    axis: Vec3,
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

    /// Takes over the spinners of the next step.
    pub fn take(&mut self, found: &mut Found) {
        self.spinners = std::mem::take(&mut found.spinners);
    }

    /// Begins a step.
    fn begin(&mut self, problem: &PatchProblem, batches: &Batches, substeps: usize) {
        self.ends.clear();
        self.h = problem.dt / substeps as f32;
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
    /// Begins a step of the spinners.
    pub fn begin_spinners(&mut self, problem: &PatchProblem, substeps: usize) {
        self.spinners.begin(problem, &self.batches, substeps);
        for end in &self.spinners.ends {
            // Friction of a finite spot would stop the spin.
            self.blocks[end.block].has_spots[end.lane] = 0.0;
            self.prepared = false;
        }
    }

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
            let swing = Quat::from_rotation_arc(spinner.axis, turn * spinner.axis);
            spinner.last_swing = swing * spinner.swing.inverse();
            spinner.swing = swing;
            motion[1] = swing.to_scaled_axis().extend(0.0);
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
                self.blocks[end.block].has_spots[end.lane] = 1.0;
                if let Some(loaded) = self.loaded.get_mut(end.patch) {
                    *loaded = Revision::next();
                }
            }
        }
    }
}
