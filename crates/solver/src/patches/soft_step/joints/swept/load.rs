//! Loads joints into blocks as a step begins, and stores them as it ends.

use super::block::{AngularRow, JointBlock};
use super::turn::BodyBlock;
use super::{Joints, Swept};
use crate::Both;
use crate::batches::Batches;
use crate::joint::{COORDINATES, Geometry, Part, Placement, filter_share, is_angular, rows_of};
use crate::lanes::{F32xN, State};
use crate::patches::soft_step::contact::spring::{Softness, Spring};
use crate::{Body, JointAxis, JointConstraint, PatchProblem, sort};
use glam::{Quat, Vec3};

/// How much higher the frequency of the springs of a piece that is no net is than that of contacts. With 1, a joint of a ragdoll opens by
/// 24 mm in a fall, with 2 by 12, with 3 by 8, with 4 by 5, but then some tremble by 0.7 mm/s. A net of 50 × 50 trembles with 2.
const SMALL_STIFFER: f32 = 3.0;

/// Loads of bodies that are faster than this are not loads at rest, m/s.
const REST_SPEED: f32 = 0.2;

/// Time in which the load at rest approaches a new load by 1 − 1/e, s.
const REST_TIME: f32 = 1.0;

impl<L: F32xN> Swept<L> {
    /// Loads its joints and their bodies.
    pub(super) fn load(&mut self, joints: &Joints, problem: &PatchProblem, spring: &Spring) {
        let batches = self.batches.take().unwrap_or_else(|| self.lay_out(problem));
        self.load_bodies(problem);
        self.rows.clear();
        let h = self.correction.h;
        let null = problem.bodies.len() as u32;
        let nets = spring.softness(L::splat(spring.omega), L::ONE);
        let small = spring.softness(L::splat(SMALL_STIFFER * spring.omega), L::ONE);
        for (block, lanes) in self.blocks.iter_mut().zip(batches.iter()) {
            *block = JointBlock::new(null);
            block.first = self.rows.len() as u32;
            for (lane, number) in lanes {
                let joint = &problem.joints[self.joints[number as usize] as usize];
                block.load(lane, joint, (problem, h));
                let softness = match joints.is_in_net(joint) {
                    true => &nets,
                    false => &small,
                };
                block.soften(lane, softness);
                if !has_rows(joint) {
                    continue;
                }
                let geometry = Geometry::new(joint, [Placement::START; 2]);
                let first = block.first as usize;
                for (number, (coordinate, part)) in angular_rows(joint).enumerate() {
                    if first + number == self.rows.len() {
                        self.rows.push(AngularRow::default());
                    }
                    let row = &mut self.rows[first + number];
                    row.load(lane, (coordinate, part), joint, &geometry, h);
                }
                split_friction(&mut self.rows[first..], lane, joint, h);
            }
            block.count = self.rows.len() as u32 - block.first;
        }
        self.batches = Some(batches);
    }

    /// Finds the places of its joints.
    fn lay_out(&mut self, problem: &PatchProblem) -> Batches {
        let ends = |&joint: &u32| problem.joints[joint as usize].bodies;
        let batches = Batches::of(L::LANES, self.joints.iter().map(ends), problem.bodies);
        self.blocks.clear();
        self.blocks.resize(batches.blocks(), JointBlock::default());
        self.members.clear();
        self.members.extend(self.joints.iter().flat_map(ends));
        sort::values(&mut self.members);
        self.members.dedup();
        batches
    }

    fn load_bodies(&mut self, problem: &PatchProblem) {
        let null = problem.bodies.len();
        for list in [&mut self.turned.rotations, &mut self.turned.others] {
            list.clear();
            list.resize(null + 1, State::default());
        }
        self.bodies.clear();
        for members in self.members.chunks(L::LANES) {
            let mut block = BodyBlock {
                bodies: L::bodies(null as u32),
                ..Default::default()
            };
            for (lane, &member) in members.iter().enumerate() {
                let body = &problem.bodies[member as usize];
                L::set_body(&mut block.bodies, lane, member);
                block.inverse_inertia.set(lane, &body.inverse_inertia);
                if body.inverse_inertia.determinant() > 0.0 {
                    block.inertia.set(lane, &body.inverse_inertia.inverse());
                }
            }
            self.bodies.push(block);
        }
    }

    /// Stores forces and motions in the problem.
    pub fn store(&self, problem: &mut PatchProblem, motions: &[State]) {
        let Some(batches) = self.batches.as_ref().filter(|_| !self.is_empty()) else {
            return;
        };
        let rotation = |body: u32| {
            let vector = self.turned.rotations[body as usize][0].truncate();
            let scalar = (1.0 - vector.length_squared()).max(0.0).sqrt();
            Quat::from_vec4(vector.extend(scalar))
        };
        for (block, lanes) in self.blocks.iter().zip(batches.iter()) {
            for (lane, number) in lanes {
                let joint = &mut problem.joints[self.joints[number as usize] as usize];
                let placements = joint.bodies.both(|body| Placement {
                    moved: motions[body as usize][0].truncate(),
                    turned: rotation(body),
                });
                let rows = &self.rows[block.range()];
                let bodies = joint.bodies.both(|body| &problem.bodies[body as usize]);
                let is_slow = bodies.into_iter().all(is_slow);
                let times = (self.correction.h, self.substeps);
                block.store(lane, rows, joint, placements, times, is_slow);
            }
        }
        for &member in &self.members {
            let body = &mut problem.bodies[member as usize];
            if body.inverse_mass > 0.0 {
                let moved = motions[member as usize][0].truncate();
                let turned = rotation(member).to_scaled_axis();
                body.motion = Some([moved, turned].both(|motion| motion / problem.dt));
                body.motion_is_exact = true;
            }
        }
    }
}

/// Whether a body is slow enough for its loads to be those at rest.
fn is_slow(body: &Body) -> bool {
    body.linear.length_squared() < REST_SPEED * REST_SPEED
}

/// The coordinates and parts of the rows that act on rotations.
fn angular_rows(joint: &JointConstraint) -> impl Iterator<Item = (usize, Part)> + '_ {
    rows_of(joint).filter(|&(coordinate, _)| is_angular(coordinate))
}

fn has_rows(joint: &JointConstraint) -> bool {
    joint.swing.is_some() || joint.axes[3..].iter().any(|axis| *axis != JointAxis::FREE)
}

impl<L: F32xN> JointBlock<L> {
    /// An empty block. Its lanes have a body that nothing moves.
    fn new(null: u32) -> Self {
        Self {
            bodies: [L::bodies(null); 2],
            ..Default::default()
        }
    }

    fn load(&mut self, lane: usize, joint: &JointConstraint, (problem, h): (&PatchProblem, f32)) {
        for side in 0..2 {
            let body = joint.bodies[side];
            L::set_body(&mut self.bodies[side], lane, body);
            self.inverse_mass[side][lane] = problem.bodies[body as usize].inverse_mass;
            self.start_arms[side].set(lane, joint.arms[side]);
            self.slack[side][lane] = joint.slack[side];
            let filtered = joint.frames[0] * joint.filtered[side];
            self.record.filtered[side].set(lane, filtered);
        }
        self.start_gap.set(lane, joint.gap);
        let [x, y, z, ..] = joint.forces;
        self.impulse
            .set(lane, joint.frames[0] * (h * Vec3::new(x, y, z)));
        let [x, y, z, ..] = joint.rest;
        self.start_held
            .set(lane, joint.frames[0] * (h * Vec3::new(x, y, z)));
        self.record.share[lane] = filter_share(h, joint.filter);
    }

    fn soften(&mut self, lane: usize, softness: &Softness<L>) {
        let own = &mut self.softness;
        own.bias_rate[lane] = softness.bias_rate[lane];
        own.mass_scale[lane] = softness.mass_scale[lane];
        own.impulse_scale[lane] = softness.impulse_scale[lane];
    }

    fn store(
        &self,
        lane: usize,
        rows: &[AngularRow<L>],
        joint: &mut JointConstraint,
        placements: [Placement; 2],
        (h, substeps): (f32, usize),
        is_slow: bool,
    ) {
        let duration = h * substeps as f32;
        let back = (placements[0].turned * joint.frames[0]).inverse();
        let force = back * (self.impulse.get(lane) / h);
        let mut forces = [0.0; COORDINATES];
        forces[..3].copy_from_slice(&force.to_array());
        for (row, (coordinate, _)) in rows.iter().zip(angular_rows(joint)) {
            forces[coordinate] += row.impulse[lane] / h;
        }
        joint.forces = forces;
        // A load that followed the forces of a swing would give it energy.
        let share = match is_slow {
            true => (duration / REST_TIME).min(1.0),
            false => 0.0,
        };
        for (rest, force) in joint.rest.iter_mut().zip(forces) {
            *rest += share * (force - *rest);
        }
        let record = &self.record;
        joint.mean = record.sum.both(|sum| sum.get(lane) / duration);
        joint.filtered = record.filtered.both(|force| back * force.get(lane));
        joint.peak = record.peak.both(|square| square[lane].sqrt());
        joint.late = [Vec3::ZERO; 2];
        joint.broke = None;
        joint.angles = match has_rows(joint) {
            true => Geometry::new(joint, placements).angles(),
            false => None,
        };
    }
}

impl<L: F32xN> AngularRow<L> {
    fn load(
        &mut self,
        lane: usize,
        (coordinate, part): (usize, Part),
        joint: &JointConstraint,
        geometry: &Geometry,
        h: f32,
    ) {
        let axis = joint.axis(coordinate);
        let found = geometry.coordinate(coordinate);
        self.start_direction.set(lane, found.direction);
        self.impulse[lane] = 0.0;
        self.held[lane] = h * joint.rest[coordinate];
        match part {
            Part::Friction => self.reach[lane] = h * axis.friction,
            _ => {
                self.start_value[lane] = found.value;
                [self.least[lane], self.most[lane]] = axis.limits;
                self.is_locked[lane] = f32::from(u8::from(axis.is_locked()));
            }
        }
    }
}

/// Divides the moments to begin with among the rows of each rotation: friction first, up to its maximum.
fn split_friction<L: F32xN>(
    rows: &mut [AngularRow<L>],
    lane: usize,
    joint: &JointConstraint,
    h: f32,
) {
    let mut left = joint.forces;
    let mut give = |kind: Part| {
        for (row, (coordinate, part)) in rows.iter_mut().zip(angular_rows(joint)) {
            if part == kind {
                let wanted = h * left[coordinate];
                let given = match part {
                    Part::Friction => wanted.clamp(-row.reach[lane], row.reach[lane]),
                    _ => wanted,
                };
                row.impulse[lane] = given;
                left[coordinate] -= given / h;
            }
        }
    };
    give(Part::Friction);
    give(Part::Hold);
}
