//! Contacts that carry jointed bodies, as a part of the direct solve.
//!
//! A solve that knew nothing of contacts would press the feet of a table into the ground in every sweep, and the contacts would lift them
//! out again: a table of a ton on legs of a kilogram jumps by a quarter of a metre. So the normals of contacts that carry join the solve.
//! Each touches one jointed body, and so it is eliminated first and only adds J Jᵀ/γ to the pivot of that body. Friction stays in the
//! sweep, and so do contacts between two jointed bodies.
//!
//! The other body of a contact may move. It is taken into account as if each contact had an equal part of its mass, which is never stiffer
//! than the truth.

use super::factor::{Numbers, Quad};
use super::member::Member;
use crate::Body;
use crate::Both;
use crate::PatchProblem;
use crate::batches::Batches;
use crate::contact_row::rate;
use crate::lanes::{F32xN, State};
use crate::patches::soft_step::contact::block::{Block, Points};
use crate::patches::soft_step::contact::normals::UNLOADED_FACTOR;
use crate::patches::soft_step::contact::pass::Pass;
use glam::{Vec3, Vec4};
use std::cell::Cell;

/// Compliance of a contact in a cold start, times its effective mass. That of a spring (0.06) would let a table on light legs begin to
/// sink.
const RIGID_COMPLIANCE: f32 = 1e-6;

/// How many times lighter than the jointed body the other one must be, so that the contact is not a part of the solve.
const LIGHT: f32 = 4.0;

/// A patch between a jointed body and one without joints.
#[derive(Clone, Debug)]
pub struct LeafPatch {
    pub patch: usize,
    block: usize,
    lane: usize,
    /// The jointed body among the members, and its side in the patch.
    pub member: usize,
    side: usize,
    /// The other body, if it moves.
    other: Option<Other>,
    /// The other body is so much lighter than the jointed one that sweeps find what the contact carries: it is not a part of the solve. A
    /// brick that is bonded to others counts with all of them, so its contacts always are.
    pub is_light: bool,
    /// The bodies in the island's lists.
    bodies: [usize; 2],
    normal: Vec3,
    arms: [Vec3; 2],
    /// Where the offsets of its points begin and end.
    offsets: std::ops::Range<usize>,
}

#[derive(Clone, Copy, Debug)]
struct Other {
    body: usize,
    inverse_mass: f32,
    free_axes: Vec3,
    inverse_inertia: glam::Mat3,
}

/// A point that carries.
#[derive(Clone, Debug)]
pub struct Leaf {
    /// Patch and point, as one number.
    pub key: u64,
    patch: usize,
    /// Its index among the island's points.
    point: usize,
    pub member: usize,
    /// Its row over the velocities of the jointed body.
    pub numbers: Numbers,
    /// Its own compliance and the response of the other body.
    pub compliance: f64,
    own_compliance: f64,
    /// The rate that it lacks before the solve.
    pub lack: f64,
    pub impulse: f64,
    pub change: f64,
    pub is_active: bool,
    /// Its index among the contacts of the solve, if it is there.
    pub held: Option<usize>,
}

/// A contact that the factorized system or a border of it has.
#[derive(Clone, Debug)]
pub struct Held {
    pub key: u64,
    /// The place of its jointed body, and its row over the unknowns of that.
    pub place: usize,
    pub numbers: Numbers,
    pub compliance: f64,
    /// The factorized system has it.
    pub is_factorized: bool,
    pub border: Option<usize>,
    /// Its index among the leaves of this visit, if it still carries.
    pub leaf: Option<usize>,
}

/// The blocks and bodies of an island.
pub struct Contacts<'a, L: F32xN> {
    pub blocks: &'a mut [Block<L>],
    pub points: &'a mut [Points<L>],
    pub velocities: &'a [Cell<State>],
    pub motions: &'a [Cell<State>],
}

/// The velocities of a body.
#[inline]
pub fn read(list: &[Cell<State>], body: usize) -> [Vec3; 2] {
    list[body].get().map(Vec4::truncate)
}

/// Adds to the velocities of a body.
#[inline]
pub fn add(list: &[Cell<State>], body: usize, [linear, angular]: [Vec3; 2]) {
    let [moves, turns] = list[body].get();
    list[body].set([moves + linear.extend(0.0), turns + angular.extend(0.0)]);
}

impl LeafPatch {
    /// The patches between a jointed body and one without joints, in the order of the blocks. `member_of` returns the member of a body, if
    /// it moves and has joints.
    pub fn find(
        problem: &PatchProblem,
        batches: &Batches,
        member_of: impl Fn(u32) -> Option<usize>,
    ) -> Vec<Self> {
        let mut leaves = Vec::new();
        for (block, lanes) in batches.iter().enumerate() {
            for (lane, patch) in lanes {
                let bodies = problem.patches[patch as usize].bodies;
                let (member, side) = match bodies.both(&member_of) {
                    [Some(member), None] => (member, 0),
                    [None, Some(member)] => (member, 1),
                    _ => continue,
                };
                leaves.push(Self {
                    patch: patch as usize,
                    block,
                    lane,
                    member,
                    side,
                    other: None,
                    is_light: false,
                    bodies: bodies.both(|body| body as usize),
                    normal: Vec3::ZERO,
                    arms: [Vec3::ZERO; 2],
                    offsets: 0..0,
                });
            }
        }
        leaves
    }

    /// Loads the patch of a step.
    pub fn begin(&mut self, problem: &PatchProblem, is_bonded: bool, offsets: &mut Vec<Vec3>) {
        let patch = &problem.patches[self.patch];
        (self.normal, self.arms) = (patch.normal, patch.arms);
        let first = offsets.len();
        offsets.extend(
            problem.points[patch.range()]
                .iter()
                .map(|point| point.offset),
        );
        self.offsets = first..offsets.len();
        let body = self.bodies[1 - self.side];
        let other: &Body = &problem.bodies[body];
        let own = problem.bodies[self.bodies[self.side]].inverse_mass;
        self.is_light = !is_bonded && other.inverse_mass > LIGHT * own;
        self.other = (other.inverse_mass > 0.0).then_some(Other {
            body,
            inverse_mass: other.inverse_mass,
            free_axes: other.free_axes,
            inverse_inertia: other.inverse_inertia,
        });
    }

    /// Adds its points that carry to the leaves.
    pub fn collect<L: F32xN>(
        &self,
        number: usize,
        contacts: &Contacts<L>,
        offsets: &[Vec3],
        pass: &Pass,
        leaves: &mut Vec<Leaf>,
    ) {
        let block = &contacts.blocks[self.block];
        let points = &contacts.points[block.range()];
        let lane = self.lane;
        let own = self.offsets.clone();
        let used = || points.iter().take(own.len());
        if self.is_light {
            return;
        }
        if used().all(|point| point.impulse[lane] <= 0.0) {
            return;
        }
        let soft = &block.softness;
        let give = soft.impulse_scale[lane] / soft.mass_scale[lane].max(f32::MIN_POSITIVE);
        let carried: f32 = used().map(|point| point.impulse[lane]).sum();
        let left = carried * block.share[lane] * block.inverse_load[lane];
        let most = (left * UNLOADED_FACTOR).min(1.0);
        let states = [contacts.velocities, contacts.motions];
        let [velocities, motions] = states.both(|list| self.bodies.both(|body| read(list, body)));
        for (i, point) in used().enumerate() {
            let impulse = point.impulse[lane];
            let mass = point.mass[lane];
            if impulse <= 0.0 || mass <= 0.0 {
                continue;
            }
            let arms = self.arms_of(i, offsets);
            let along = |motions| self.along(arms, motions);
            let rate = along(velocities);
            // The rigid and the soft row of `visit.rs`, with 1/W and the share of an impulse that it gives back as a compliance.
            let compliance = give / mass;
            let lack = if pass.soft {
                let s = point.separation[lane] + along(motions);
                let rest = point.rest_impulse[lane];
                if s * mass > most * block.gives[lane] * rest {
                    -(rate + s * pass.rate)
                } else {
                    let bias = (soft.bias_rate[lane] * s).max(-block.max_speed[lane]);
                    let lost = (rest * left.min(1.0) - impulse).max(0.0);
                    let held = most * rest - pass.preload * lost;
                    -(rate + bias) - compliance * (impulse - held)
                }
            } else {
                -(rate + point.gap[lane] * pass.rate)
            };
            leaves.push(Leaf {
                own_compliance: compliance as f64,
                lack: lack as f64,
                impulse: impulse as f64,
                ..self.leaf(number, i, block.range().start + i, arms)
            });
        }
    }

    /// Adds its points to the leaves if they carry nothing yet, touch a body that bears them, and are not farther apart than `closed` m.
    /// They are almost rigid. A body that moves bears them as if it did not if it is one of `supports`.
    pub fn collect_new<L: F32xN>(
        &self,
        number: usize,
        contacts: &Contacts<L>,
        offsets: &[Vec3],
        (closed, supports): (f32, &[bool]),
        leaves: &mut Vec<Leaf>,
    ) {
        let block = &contacts.blocks[self.block];
        let points = &contacts.points[block.range()];
        let lane = self.lane;
        let used = || points.iter().take(self.offsets.len());
        let carries =
            |point: &Points<L>| point.impulse[lane] > 0.0 || point.rest_impulse[lane] > 0.0;
        let bears = |other: Other| supports.get(other.body).is_some_and(|&bears| bears);
        if !self.other.is_none_or(bears) || used().any(carries) {
            return;
        }
        let mut velocities = self.bodies.both(|body| read(contacts.velocities, body));
        if self.other.is_some() {
            velocities[1 - self.side] = [Vec3::ZERO; 2];
        }
        for (i, point) in used().enumerate() {
            let mass = point.mass[lane];
            if mass <= 0.0 || point.separation[lane] > closed {
                continue;
            }
            let arms = self.arms_of(i, offsets);
            let compliance = (RIGID_COMPLIANCE / mass) as f64;
            leaves.push(Leaf {
                own_compliance: compliance,
                compliance,
                lack: -self.along(arms, velocities) as f64,
                ..self.leaf(number, i, block.range().start + i, arms)
            });
        }
    }

    /// From the centres of mass to one of its points, m.
    fn arms_of(&self, i: usize, offsets: &[Vec3]) -> [Vec3; 2] {
        self.arms.both(|arm| arm + offsets[self.offsets.start + i])
    }

    /// The motion along its normal of A relative to B, at a point.
    fn along(&self, arms: [Vec3; 2], motions: [[Vec3; 2]; 2]) -> f32 {
        rate(self.normal, arms, motions)
    }

    /// The leaf of a point without impulse, with the response of the other body as its compliance. `number` is that of the patch; `point`
    /// is its index among the island's points.
    fn leaf(&self, number: usize, i: usize, point: usize, arms: [Vec3; 2]) -> Leaf {
        let sign = if self.side == 0 { 1.0 } else { -1.0 };
        let push = sign * self.normal;
        let turn = arms[self.side].cross(push);
        let [push, turn] = [push, turn].both(Vec3::as_dvec3);
        let other = self.other.map_or(0.0, |other| {
            let turn = arms[1 - self.side].cross(self.normal);
            let along = self.normal * other.free_axes;
            other.inverse_mass * along.length_squared() + turn.dot(other.inverse_inertia * turn)
        });
        Leaf {
            key: (number as u64) << 32 | i as u64,
            patch: number,
            point,
            member: self.member,
            numbers: [push, turn].both(|v| [v.x, v.y, v.z, 0.0]),
            own_compliance: 0.0,
            compliance: other as f64,
            lack: 0.0,
            impulse: 0.0,
            change: 0.0,
            is_active: true,
            held: None,
        }
    }
}

impl Leaf {
    /// As a contact of the solve. `place` is that of its jointed body.
    pub fn hold(&self, place: usize, is_factorized: bool, leaf: usize) -> Held {
        Held {
            key: self.key,
            place,
            numbers: self.numbers,
            compliance: self.compliance,
            is_factorized,
            border: None,
            leaf: Some(leaf),
        }
    }

    /// Adds its own compliance to its part of the response of the other body, which `leaves` share.
    pub fn share(leaves: &mut [Self], patches: &[LeafPatch]) {
        let other = |leaf: &Self| patches[leaf.patch].other.map(|other| other.body);
        for i in 0..leaves.len() {
            let sharing = match other(&leaves[i]) {
                Some(body) => leaves
                    .iter()
                    .filter(|leaf| other(leaf) == Some(body))
                    .count(),
                None => 0,
            };
            let leaf = &mut leaves[i];
            leaf.compliance = leaf.own_compliance + sharing as f64 * leaf.compliance;
        }
    }

    /// Applies its change to the point and to the other body.
    pub fn apply<L: F32xN>(&self, patches: &[LeafPatch], offsets: &[Vec3], to: &mut Contacts<L>) {
        let patch = &patches[self.patch];
        let block = &to.blocks[patch.block];
        let i = self.point - block.range().start;
        let impulse = (self.impulse + self.change).max(0.0) as f32;
        to.points[self.point].impulse[patch.lane] = impulse;
        if let Some(other) = patch.other {
            let side = 1 - patch.side;
            let sign = if side == 0 { 1.0 } else { -1.0 };
            let push = sign * self.change as f32 * patch.normal;
            let arm = patch.arms[side] + offsets[patch.offsets.start + i];
            let spin = other.inverse_inertia * arm.cross(push);
            add(
                to.velocities,
                other.body,
                [other.inverse_mass * push * other.free_axes, spin],
            );
        }
    }

    /// Makes the impulse of its point the load at rest.
    pub fn rest<L: F32xN>(&self, patches: &[LeafPatch], to: &mut Contacts<L>) {
        let LeafPatch { block, lane, .. } = patches[self.patch];
        let block = &mut to.blocks[block];
        let points = &mut to.points[block.range()];
        let point = &mut points[self.point - block.range().start];
        point.rest_impulse[lane] = point.impulse[lane];
        let load: f32 = points.iter().map(|point| point.rest_impulse[lane]).sum();
        block.inverse_load[lane] = match load > 0.0 {
            true => 1.0 / (block.share[lane] * load),
            false => 0.0,
        };
    }

    /// The rate of its point for velocity changes of the jointed body.
    pub fn rate(&self, change: &Numbers) -> f64 {
        let both = self.numbers.as_flattened().iter();
        both.zip(change.as_flattened()).map(|(a, b)| a * b).sum()
    }

    /// The changes of the jointed body's velocities by its change alone.
    pub fn effect(&self, member: &Member) -> [Vec3; 2] {
        let part = |numbers: Quad| {
            let [x, y, z, _] = numbers.map(|number| (number * self.change) as f32);
            Vec3::new(x, y, z)
        };
        let [push, turn] = self.numbers.both(part);
        member.respond(push, turn)
    }
}
