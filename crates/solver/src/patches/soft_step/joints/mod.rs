//! Joints, solved directly in every sweep, but for ragdolls and nets, which are [swept].
//!
//! Rows that are relaxed one by one need sweeps in proportion to the number of links times the ratio of masses: a chain of 40 links under a
//! load of a thousand links stretches by centimetres, or flies apart. So each connected [piece] of the joint graph is solved as a
//! whole by a [sparse factorization](factor), after the contacts of every soft and every rigid sweep; the other way round it flies apart.
//!
//! - **Rows** ([`row`]) are springs a hundred thousand times as stiff as those of contacts. They are never quite rigid: joints that hold
//!   each other redundantly would have no unique forces.
//! - **Arms turn** within a step: directions, errors, inertias and the factorization are refreshed in each substep for what has turned by
//!   more than 1e-4 rad. Bodies at rest keep them. Rows allow for the curvature of the way
//!   ([`Bend::inward_rate`](crate::joint::Bend::inward_rate)).
//! - **Impulses** are applied anew where arms have turned. The extrapolation of velocities, which contacts use, would repeat forces in
//!   directions in which they no longer act.
//! - **Geometric stiffness** ([`Member::stiffen`]): a light link under a large pull vibrates faster than any substep.
//! - **Contacts** that carry jointed bodies are a part of the solve ([`leaf`]), unless the other body is far lighter.
//! - **[The choice](choice)** which pieces are swept is made in each step, by the loads of their bodies.
//! - **Bounds** of motors, limits and friction hold within the solve ([`piece`]).
//! - **Breaking**: forces pass a low-pass with a time constant, since the force of a single substep grows with the rate of substeps
//!   wherever something hits. Bonded patches break within the step ([`breaking`]), and share loads by their areas ([`sharing`]).

mod borders;
mod breaking;
mod choice;
pub mod factor;
mod in_sweeps;
mod leaf;
mod loads;
mod log;
mod member;
mod piece;
mod pieces;
mod row;
mod sharing;
pub mod springs;
pub mod swept;

use crate::Both;
use crate::joint::{COORDINATES, Times};
use crate::lanes::{F32xN, State, has_fused};
use crate::patches::soft_step::contact::pass::Pass;
use crate::patches::soft_step::contact::spring::Spring;
use crate::{JointConstraint, Lanes, PatchProblem};
use choice::Strain;
use glam::{Mat3, Vec3};
pub use leaf::Contacts;
use leaf::{LeafPatch, read};
use log::{Log, record};
pub use member::{Member, principal};
use piece::{Lists, Piece};
use pieces::Shape;
use row::{JointRow, Link};
use std::cell::Cell;

/// A motor of infinite stiffness takes at least as many substeps to its target.
const MIN_APPROACH_SUBSTEPS: f32 = 4.0;

/// Upper bounds of the speed of bodies that were placed, m/s and rad/s, and of the error of joints between them, m and rad.
const MAX_PLACED_SPEED: f32 = 0.01;
const PLACED_ACCURACY: f32 = 0.005;

/// The joints of an island.
#[derive(Default)]
pub struct Joints {
    /// The bodies and the rows of each joint; the pieces were found for them.
    shape: Vec<Shape>,
    /// By body: it moves. Pieces depend on it.
    moves: Vec<bool>,
    /// Moving bodies, piece by piece, and then fixed ones.
    members: Vec<Member>,
    /// By body: its member if it moves, else `u32::MAX`.
    member_of: Vec<u32>,
    links: Vec<Link>,
    rows: Vec<JointRow>,
    pieces: Vec<Piece>,
    patches: Vec<LeafPatch>,
    offsets: Vec<Vec3>,
    /// By link: what it has done in this step.
    logs: Vec<Log>,
    /// By member of a piece: the push and the moment of its joints, and their geometric stiffness.
    pushes: Vec<[Vec3; 2]>,
    bends: Vec<Mat3>,
    /// The joints of the problem.
    joints: Vec<JointConstraint>,
    /// The joints that are swept in this step.
    swept: Vec<u32>,
    has_new_swept: bool,
    /// By body: the forces on it.
    strains: Vec<Strain>,
    h: f32,
    substeps: usize,
    /// Number of substeps that have drifted.
    drifted: usize,
    /// b of the springs of contacts.
    stiffness: f32,
    bias_rate: f32,
    fastest: f32,
}

impl Joints {
    pub fn is_empty(&self) -> bool {
        self.pieces.is_empty()
    }

    /// Whether joints hold a body.
    pub fn hold(&self, body: usize) -> bool {
        self.member_of
            .get(body)
            .is_some_and(|&member| member != u32::MAX)
    }

    /// Begins a step with substeps of `h` s, and applies the impulses to begin with to velocities.
    pub fn begin<L: F32xN>(
        &mut self,
        problem: &PatchProblem,
        spring: &Spring,
        substeps: usize,
        lanes: Lanes,
        contacts: Contacts<L>,
    ) {
        self.begin_on(&[], problem, spring, substeps, lanes, contacts);
    }

    /// Like [`begin`](Self::begin), but pieces that were just built may also stand on these bodies (by number) that move, as if they did
    /// not.
    pub fn begin_on<L: F32xN>(
        &mut self,
        supports: &[bool],
        problem: &PatchProblem,
        spring: &Spring,
        substeps: usize,
        lanes: Lanes,
        mut contacts: Contacts<L>,
    ) {
        if self.is_empty() {
            return;
        }
        self.h = spring.h;
        self.substeps = substeps;
        self.drifted = 0;
        (self.stiffness, self.bias_rate) = spring.stiffness_and_bias();
        self.fastest = problem.max_correction_speed;
        self.joints.clear();
        self.offsets.clear();
        self.logs.clear();
        if direct(&self.pieces).next().is_none() {
            return;
        }
        self.joints.extend_from_slice(problem.joints);
        self.logs.resize(self.links.len(), Log::default());
        let fixed = self.pieces.last().map_or(0, |piece| piece.members.end);
        for member in &mut self.members[fixed..] {
            member.begin(&problem.bodies[member.body as usize]);
        }
        for number in 0..self.pieces.len() {
            if !self.pieces[number].is_swept {
                self.begin_piece(number, problem);
            }
        }
        let times = self.times();
        self.share_stiffness();
        for piece in direct(&self.pieces) {
            for link in &self.links[piece.links.clone()] {
                let joint = &self.joints[link.joint];
                link.ask(joint, &mut self.rows, &times);
                link.soften(&mut self.rows, self.stiffness);
            }
        }
        self.break_misfits();
        let is_fused = lanes != Lanes::Four && has_fused();
        for piece in direct_mut(&mut self.pieces) {
            piece.is_stale = true;
            piece.is_refreshed = true;
            piece.is_calm = false;
            piece.is_first = true;
            piece.is_strained = false;
            piece.is_fused = is_fused;
        }
        self.restart(contacts.velocities, |member, velocities| {
            let [linear, angular] = read(velocities, member.body as usize);
            let was = problem.bodies[member.body as usize].start[1];
            (linear, was, angular - was)
        });
        self.cold_start(supports, problem, &mut contacts);
    }

    fn begin_piece(&mut self, number: usize, problem: &PatchProblem) {
        let times = self.times();
        let piece = &mut self.pieces[number];
        piece.prepare(&self.links);
        for member in &mut self.members[piece.members.clone()] {
            member.begin(&problem.bodies[member.body as usize]);
        }
        let links = &mut self.links[piece.links.clone()];
        let mut joints = links.iter().map(|link| &self.joints[link.joint]);
        piece.is_bonded = joints.any(|joint| joint.section.is_some());
        for patch in &mut self.patches[piece.patches.clone()] {
            patch.begin(problem, piece.is_bonded, &mut self.offsets);
        }
        for (link, log) in links.iter_mut().zip(&mut self.logs[piece.links.clone()]) {
            let joint = &mut self.joints[link.joint];
            (log.filtered, log.late) = (joint.filtered, joint.late);
            for row in &mut self.rows[link.rows.clone()] {
                *row = JointRow::new(row.coordinate, row.part);
            }
            link.point(joint, &mut self.rows, &self.members);
            link.find_responses(&mut self.rows, &self.members);
            link.start(joint, &mut self.rows, &times);
        }
    }

    /// Finds the impulses of pieces that were just built, and of the contacts on which they stand: whose joints have none yet, and whose
    /// bodies rest where joints want them. Then finds their geometric stiffness.
    fn cold_start<L: F32xN>(
        &mut self,
        supports: &[bool],
        problem: &PatchProblem,
        contacts: &mut Contacts<L>,
    ) {
        let mut lists = Lists {
            members: &mut self.members,
            links: &self.links,
            rows: &mut self.rows,
            patches: &self.patches,
            offsets: &self.offsets,
        };
        // The distance that a body falls from rest in a step.
        let fallen = 0.5 * problem.gravity.length() * problem.dt * problem.dt;
        let closed = fallen.max(PLACED_ACCURACY);
        let joints = &self.joints;
        let mut is_any_cold = false;
        for piece in direct_mut(&mut self.pieces) {
            let links = lists.links[piece.links.clone()].iter();
            let mut forces = links.flat_map(|link| joints[link.joint].forces);
            if forces.all(|force| force == 0.0)
                && piece.is_built(&lists, MAX_PLACED_SPEED, self.bias_rate * PLACED_ACCURACY)
            {
                piece.cold_start(self.h, (closed, supports), &mut lists, contacts);
                piece.is_refreshed = true;
                is_any_cold = true;
            }
        }
        if !is_any_cold {
            return;
        }
        self.restart(contacts.velocities, |member, velocities| {
            let [linear, angular] = read(velocities, member.body as usize);
            let was = problem.bodies[member.body as usize].start[1];
            let [moves, turns] = member.given;
            (linear - moves, was, angular - was - turns)
        });
    }

    fn times(&self) -> Times {
        let left = (self.substeps - self.drifted) as f32;
        Times {
            h: self.h,
            left: self.h * left.max(MIN_APPROACH_SUBSTEPS),
            bias_rate: self.bias_rate,
            fastest: self.fastest,
        }
    }

    /// Solves all pieces. Returns Σ Δλ times what each row lacked, J.
    pub fn visit<L: F32xN>(&mut self, pass: &Pass, mut contacts: Contacts<L>) -> f32 {
        let mut lists = Lists {
            members: &mut self.members,
            links: &self.links,
            rows: &mut self.rows,
            patches: &self.patches,
            offsets: &self.offsets,
        };
        let mut sum = 0.0;
        for piece in direct_mut(&mut self.pieces) {
            if piece.stays_calm(pass, &lists, &contacts) {
                continue;
            }
            record(
                piece,
                (lists.links, &mut *lists.rows),
                &mut self.logs,
                (&self.joints, self.h),
            );
            sum += piece.visit(pass, &mut lists, &mut contacts);
        }
        sum
    }

    /// Follows the drift of bodies after a soft sweep. `velocities` are those with which they drifted.
    pub fn drift(&mut self, velocities: &[Cell<State>], motions: &[Cell<State>]) {
        self.drifted += 1;
        let fixed = self.pieces.last().map_or(0, |piece| piece.members.end);
        for member in &mut self.members[fixed..] {
            let body = member.body as usize;
            member.drift(read(velocities, body), read(motions, body), self.h);
        }
        let times = self.times();
        for piece in direct_mut(&mut self.pieces) {
            for member in &mut self.members[piece.members.clone()] {
                let body = member.body as usize;
                member.drift(read(velocities, body), read(motions, body), self.h);
            }
            let slack = piece.calm() / self.bias_rate.max(f32::MIN_POSITIVE);
            let members = &self.members[piece.members.clone()];
            if piece.is_calm && members.iter().all(|member| member.is_still(slack)) {
                continue;
            }
            piece.is_calm = false;
            let links = &mut self.links[piece.links.clone()];
            for link in links.iter().filter(|link| link.geometry.hinge().is_some()) {
                let [a, b] = link
                    .ends
                    .both(|end| read(velocities, self.members[end].body as usize)[1]);
                let angles = &mut self.joints[link.joint].angles;
                link.geometry.turn_on(angles, self.h * (b - a));
            }
            if links.iter().any(|link| link.is_stale(&self.members)) {
                for member in &mut self.members[piece.members.clone()] {
                    member.refresh();
                }
                for link in links {
                    link.point(&mut self.joints[link.joint], &mut self.rows, &self.members);
                }
                (piece.is_stale, piece.is_refreshed) = (true, true);
            } else {
                for link in links {
                    link.follow(&mut self.rows, &self.members);
                }
            }
            for link in &self.links[piece.links.clone()] {
                let joint = &self.joints[link.joint];
                link.ask(joint, &mut self.rows, &times);
            }
        }
    }

    /// Ends a substep: records its forces, and prepares the velocities of the next one if there is any. `ended` are the velocities with
    /// which it ended; `velocities` are extrapolated from them.
    pub fn end_substep(
        &mut self,
        is_last: bool,
        ended: &[Cell<State>],
        velocities: &[Cell<State>],
    ) {
        for piece in direct_mut(&mut self.pieces) {
            piece.unrecorded += 1;
            if is_last || !piece.is_calm || piece.is_strained {
                record(
                    piece,
                    (&self.links, &mut self.rows),
                    &mut self.logs,
                    (&self.joints, self.h),
                );
            }
        }
        self.break_sections();
        if is_last {
            return;
        }
        self.restart(velocities, |member, velocities| {
            let body = member.body as usize;
            let ([linear, angular], was) = (read(velocities, body), read(ended, body));
            let [moves, turns] = member.given;
            (linear - moves, was[1], angular - was[1] - turns)
        });
    }

    /// Applies the impulses of all pieces whose directions have changed. `bare` returns the velocities of a body without them: the linear
    /// one, the angular one at the end of the last substep, and what it has gained since.
    fn restart(
        &mut self,
        velocities: &[Cell<State>],
        bare: impl Fn(&Member, &[Cell<State>]) -> (Vec3, Vec3, Vec3),
    ) {
        for piece in direct_mut(&mut self.pieces) {
            let is_refreshed = std::mem::take(&mut piece.is_refreshed);
            let members = &mut self.members[piece.members.clone()];
            // Bodies that do not turn need no spin carried over.
            let turns = |member: &Member| !piece.is_calm || member.turns(piece.calm());
            let is_stiffened = members
                .iter()
                .any(|member| member.is_stiffened() && turns(member));
            if !is_refreshed && !is_stiffened {
                continue;
            }
            let (pushes, bends) = (&mut self.pushes, &mut self.bends);
            pushes.clear();
            pushes.resize(members.len(), [Vec3::ZERO; 2]);
            bends.clear();
            bends.resize(members.len(), Mat3::ZERO);
            let first = piece.members.start;
            for link in &self.links[piece.links.clone()] {
                let impulse = link.impulse(&self.rows);
                for (side, end) in link.ends.into_iter().enumerate() {
                    if !piece.members.contains(&end) {
                        continue;
                    }
                    let wrench = link.wrench(side, impulse);
                    for (push, wrench) in pushes[end - first].iter_mut().zip(wrench) {
                        *push += wrench;
                    }
                    let (arm, force) = (link.geometry.arms[side], wrench[0] / self.h);
                    let along = Mat3::from_diagonal(Vec3::splat(arm.dot(force)));
                    let across = Mat3::from_cols(force.x * arm, force.y * arm, force.z * arm);
                    bends[end - first] += along - across;
                }
            }
            let forces = pushes.iter().zip(&*bends);
            for (member, (&[push, moment], bend)) in members.iter_mut().zip(forces) {
                if is_refreshed {
                    member.stiffen(bend, self.h);
                }
                let (linear, was, gained) = bare(member, velocities);
                let carried = member.carry_spin(was) - was;
                let [moves, turns] = member.respond(push, moment);
                member.seen[1] = was + carried;
                // The next substep carries the spin anew, too.
                member.given = [moves, turns + carried];
                let state = [linear + moves, was + gained + member.given[1]];
                velocities[member.body as usize].set(state.both(|velocity| velocity.extend(0.0)));
            }
            piece.is_stale |= is_refreshed;
        }
    }

    /// Stores the results. Loads at rest of contacts have followed by the share `rate`.
    pub fn store(&self, problem: &mut PatchProblem, motions: &[State], rate: f32) {
        if self.is_empty() {
            return;
        }
        for piece in direct(&self.pieces) {
            loads::follow(&self.patches[piece.patches.clone()], problem, rate);
            self.store_piece(piece, problem, motions);
        }
    }

    fn store_piece(&self, piece: &Piece, problem: &mut PatchProblem, motions: &[State]) {
        let links = self.links[piece.links.clone()].iter();
        for (link, log) in links.zip(&self.logs[piece.links.clone()]) {
            let joint = &mut problem.joints[link.joint];
            joint.forces = [0.0; COORDINATES];
            for row in &self.rows[link.rows.clone()] {
                joint.forces[row.coordinate] += row.impulse / self.h;
            }
            joint.rest = joint.forces;
            joint.mean = log.sum.both(|sum| sum / self.substeps as f32);
            (joint.filtered, joint.late, joint.peak) = (log.filtered, log.late, log.peak);
            joint.broke = log.broke;
            joint.angles = link.angles(&self.joints[link.joint], &self.members);
        }
        let members = self.members[piece.members.clone()].iter();
        for member in members.filter(|member| member.moves) {
            let body = &mut problem.bodies[member.body as usize];
            let motion = member.motion_of_step(&motions[member.body as usize]);
            body.motion = Some(motion.both(|motion| motion / problem.dt));
            body.motion_is_exact = true;
        }
    }
}

/// The pieces that are solved directly in this step.
fn direct(pieces: &[Piece]) -> impl Iterator<Item = &Piece> {
    pieces.iter().filter(|piece| !piece.is_swept)
}

fn direct_mut(pieces: &mut [Piece]) -> impl Iterator<Item = &mut Piece> {
    pieces.iter_mut().filter(|piece| !piece.is_swept)
}
