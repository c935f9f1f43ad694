//! An island during a step. Its blocks live as long as its contacts do.

use super::contact::block::{Block, Pass, Points};
use super::contact::kinds::{Kinds, Rigid, Soft};
use super::grabs::GrabPlaces;
use super::joints::Joints;
use super::spinners::Spinners;
use super::sweeps::pipeline::{self, Pipeline, Work};
use crate::Both;
use crate::batches::Batches;
use crate::grab::ActiveGrab;
use crate::lanes::{F32xN, Kernel, State, cells};
use crate::revision::Revision;
use crate::rounds::{ROUND, RoundEnds, Rounds};
use crate::{Body, Lanes, PatchConstraint, PatchProblem};
use glam::{Mat3, Vec3};
use std::ops::Range;

/// A body with more neighbours than this gets a slower correction from each of them than the settings allow.
const CROWD: f32 = 6.0;

/// The blocks of a problem, not skewed and without rounds.
pub fn batches(lanes: usize, problem: &PatchProblem) -> Batches {
    let patches = problem.patches.iter().map(|patch| patch.bodies);
    Batches::of(lanes, patches, problem.bodies)
}

/// The blocks of a problem: skewed if sweeps may overlap and skewing pays, else in rounds.
pub fn skewed(lanes: usize, problem: &PatchProblem) -> Batches {
    let patches = problem.patches.iter().map(|patch| patch.bodies);
    match stands_by_itself(problem) {
        true => Batches::skewed(lanes, patches, problem.bodies),
        false => Batches::in_rounds(lanes, patches, problem.bodies),
    }
}

pub fn rounds(problem: &PatchProblem) -> Rounds {
    let patches = problem.patches.iter().map(|patch| patch.bodies);
    Rounds::of(patches, problem.bodies)
}

/// Whether bodies that contacts cannot change stand still. Sweeps may overlap only then.
pub fn stands_by_itself(problem: &PatchProblem) -> bool {
    problem.bodies.iter().all(|body| {
        body.inverse_mass > 0.0 || body.start == [Vec3::ZERO; 2] && body.push() == [Vec3::ZERO; 2]
    })
}

/// The number of patches of each body.
pub fn neighbours(problem: &PatchProblem) -> Vec<u32> {
    let mut neighbours = vec![0u32; problem.bodies.len()];
    for body in problem.patches.iter().flat_map(|patch| patch.bodies) {
        neighbours[body as usize] += 1;
    }
    neighbours
}

impl<L: F32xN> Block<L> {
    /// Loads the patches of an empty block. `neighbours` is the number of patches of each body, `rounds` come with the index of their first
    /// seat.
    #[inline(always)]
    pub fn fill<'a>(
        &mut self,
        points: &mut [Points<L>],
        patches: impl Iterator<Item = (usize, u32, &'a PatchConstraint)>,
        problem: &PatchProblem,
        neighbours: &[u32],
        (rounds, first_seat): (&Rounds, u32),
    ) {
        let moves = |body: u32| problem.bodies[body as usize].inverse_mass > 0.0;
        for (lane, number, patch) in patches {
            // Full stiffness is that of a body between two others, which is held by two springs.
            let most = patch.bodies.into_iter().filter(|&body| moves(body));
            let most = most.map(|body| neighbours[body as usize]).max();
            let shared = 2.0 / most.unwrap_or(0).max(2) as f32;
            self.load(points, lane, patch, problem, shared);
            for (side, seat) in rounds.seats(number).into_iter().enumerate() {
                let body = patch.bodies[side];
                match seat {
                    Some(seat) => {
                        let seat = first_seat + seat.body * ROUND as u32 + seat.number;
                        self.write_to(lane, side, seat);
                    }
                    None if moves(body) => self.write_to(lane, side, body),
                    None => {}
                }
            }
            // The sum of all corrections would throw out a body that overlaps many others.
            let slowdown = (CROWD * 0.5 * shared).min(1.0);
            self.set_max_speed(lane, problem.max_correction_speed * slowdown);
        }
    }
}

/// An island during a step: its blocks, and the velocities and motions of its bodies.
pub struct Island<L: F32xN> {
    pub substeps: usize,
    /// Number of substeps that are not taken, because the island is [quiet](super::sweeps::quiet). Contacts give the impulses of the last
    /// one in each of them.
    pub skipped: usize,
    /// Springs see no depth beyond this separation, m.
    pub deepest: f32,
    /// The setting for lanes.
    pub lanes: Lanes,
    /// By patch: the angular frequency of its springs, rad/s. Empty if all have that of the island's spring.
    pub frequencies: Vec<f32>,
    /// Fastest correction, m/s.
    pub fastest: f32,
    /// The result of [`stands_by_itself`].
    pub alone: bool,
    /// After which blocks bodies take over the results of their rounds.
    pub round_ends: RoundEnds,
    /// By body: the inverse inertia with which its blocks were prepared, 1/(kg·m²).
    pub inertias: Vec<Mat3>,
    /// By body: its inverse inertia differs from that of the last step.
    pub turned: Vec<bool>,
    /// Whether that is so for some body.
    pub any_turned: bool,
    /// By patch: the revision of the contact that its lane was loaded from. See [`Memory`](crate::Memory).
    pub loaded: Vec<Revision>,
    /// By patch: its contact has another revision than in the last step.
    pub changed: Vec<bool>,
    /// Whether effective masses were computed.
    pub prepared: bool,
    pub batches: Batches,
    pub blocks: Vec<Block<L>>,
    pub points: Vec<Points<L>>,
    /// By body. Then one entry that nothing moves, for lanes without a patch; one for each block that nothing reads; and the seats of
    /// rounds.
    pub velocities: Vec<State>,
    /// Velocities at the beginning of the substep.
    pub before: Vec<State>,
    /// Motion of the bodies since detection, m and rad.
    pub motions: Vec<State>,
    /// Velocities of the free motion, without impulses of contacts and grabs.
    pub free: Vec<State>,
    /// By block: merit of the free motion, J.
    pub missing: Vec<L>,
    /// By block: Σ W Δλ² of the last sweep, J.
    pub changes: Vec<L>,
    /// Grabs. They are visited before the contacts of their bodies, so that the contacts they press against decide last.
    pub grabs: Vec<ActiveGrab>,
    pub grab_places: GrabPlaces,
    /// Joints. They are solved after all contacts of a sweep.
    pub joints: Joints,
    /// None in a step with blows.
    pub spinners: Spinners,
    /// Present once there are threads for it.
    pub pipeline: Option<Pipeline>,
}

impl<L: F32xN> Island<L> {
    /// Finds the places of grabs among the blocks, and the connected pieces of joints.
    pub fn place_grabs(&mut self, problem: &PatchProblem) {
        self.joints.place(problem, &self.batches);
        if self.grab_places.place(&self.batches, problem) {
            self.pipeline = None;
        }
    }

    pub fn new(problem: &PatchProblem, batches: Batches) -> Self {
        let bodies = &*problem.bodies;
        let null_body = bodies.len() as u32;
        let neighbours = neighbours(problem);
        let first_seat = null_body + 1 + batches.blocks() as u32;
        let mut blocks = Vec::with_capacity(batches.blocks());
        let mut points = Vec::with_capacity(problem.points.len() / L::LANES * 5 / 4);
        // Filling block by block keeps the block in the cache; filling in the order of patches does not.
        for lanes in batches.iter() {
            let patches =
                lanes.map(|(lane, number)| (lane, number, &problem.patches[number as usize]));
            let counts = patches.clone().map(|(.., patch)| patch.count);
            let count = counts.max().unwrap_or(0);
            let first = points.len();
            points.resize(first + count as usize, Points::default());
            let null_target = null_body + 1 + blocks.len() as u32;
            blocks.push(Block::<L>::new(null_body, null_target));
            let block = blocks.last_mut().expect("it was just added");
            block.place(first, count);
            let seats = (batches.rounds(), first_seat);
            block.fill(&mut points[first..], patches, problem, &neighbours, seats);
        }
        Self {
            substeps: 1,
            skipped: 0,
            deepest: f32::NEG_INFINITY,
            lanes: Lanes::Auto,
            frequencies: Vec::new(),
            fastest: problem.max_correction_speed,
            alone: stands_by_itself(problem),
            inertias: bodies.iter().map(|body| body.inverse_inertia).collect(),
            turned: Vec::new(),
            any_turned: false,
            loaded: problem.memory.patches().to_vec(),
            changed: Vec::new(),
            prepared: false,
            round_ends: batches.round_ends(first_seat),
            batches,
            blocks,
            points,
            velocities: Vec::new(),
            before: Vec::new(),
            motions: Vec::new(),
            free: Vec::new(),
            missing: Vec::new(),
            changes: Vec::new(),
            grabs: Vec::new(),
            grab_places: GrabPlaces::default(),
            joints: Joints::default(),
            spinners: Spinners::default(),
            pipeline: None,
        }
    }

    /// Begins a step. The result equals that of an island made anew, to the bit: edits elsewhere in a world must not change a simulation.
    pub fn begin(&mut self, problem: &PatchProblem, substeps: usize) {
        self.substeps = substeps;
        self.skipped = 0;
        self.find_turned(problem.bodies);
        self.changed.clear();
        let revisions = self.loaded.iter_mut().zip(problem.memory.patches());
        self.changed.extend(revisions.map(|(loaded, &now)| {
            let before = std::mem::replace(loaded, now);
            before != now
        }));
        self.changed.resize(problem.patches.len(), false);
        let state = |body: &Body| body.start.both(|velocity| velocity.extend(0.0));
        self.velocities.clear();
        self.velocities.extend(problem.bodies.iter().map(state));
        let seats = self.batches.rounds().count();
        let further = self.velocities.len() + 1 + self.blocks.len() + seats;
        self.velocities.resize(further, State::default());
        self.before.clone_from(&self.velocities);
        self.changes.resize(self.blocks.len(), L::ZERO);
        self.motions.clear();
        self.motions.resize(self.velocities.len(), State::default());
    }

    /// Applies a share of the step's forces to the bodies.
    pub fn push(&mut self, bodies: &[Body], share: f32) {
        for (state, body) in self.velocities.iter_mut().zip(bodies) {
            for (velocity, push) in state.iter_mut().zip(body.push()) {
                *velocity += (push * share).extend(0.0);
            }
        }
    }

    /// Applies the warm-start impulses of some blocks.
    pub fn warm_start(&mut self, blocks: Range<usize>) {
        for lap in 0..self.batches.laps() {
            L::run(Start {
                lanes: self.lanes_of(|of| of == lap),
                island: &mut *self,
                blocks: blocks.clone(),
            });
        }
    }

    /// 1 in the lanes whose laps satisfy `is`, else 0.
    pub fn lanes_of(&self, is: impl Fn(usize) -> bool) -> L {
        let mut lanes = L::ZERO;
        for lane in 0..self.batches.lanes_used() {
            if is(self.batches.lap_of(lane)) {
                lanes[lane] = 1.0;
            }
        }
        lanes
    }

    /// Finds the bodies whose inverse inertia differs from that of the last step.
    pub fn find_turned(&mut self, bodies: &[Body]) {
        let both = self.inertias.iter_mut().zip(bodies);
        self.turned.clear();
        self.turned.extend(both.map(|(before, body)| {
            let turned = *before != body.inverse_inertia;
            *before = body.inverse_inertia;
            turned
        }));
        self.any_turned = self.turned.contains(&true);
    }

    /// Runs all sweeps over blocks that are not skewed. Calls `tell` with Σ Wᵢᵢ Δλᵢ² of each, J.
    pub fn sweep(&mut self, problem: &PatchProblem, passes: &[Pass], tell: &mut dyn FnMut(f32)) {
        let bytes = self.bytes();
        let pipeline = self.take_pipeline(problem);
        // A sweep down begins where the one before ends, so only sweeps up follow each other.
        for passes in passes.chunk_by(|before, after| !before.down && !after.down) {
            let shares = pipeline.as_ref().and_then(|pipeline| {
                let shares = pipeline.share(problem.threads, passes.len(), bytes)?;
                Some((pipeline, shares))
            });
            if let Some((pipeline, shares)) = shares {
                pipeline.run(passes, self.work(), shares, tell);
            } else {
                passes.iter().for_each(|pass| tell(self.sweep_alone(pass)));
            }
        }
        self.pipeline = pipeline;
    }

    /// Runs one sweep and finishes its pass. Returns Σ W Δλ², J.
    pub fn sweep_alone(&mut self, pass: &Pass) -> f32 {
        let held_change = self.visit_grabs();
        let change = match pass.soft {
            true => self.sweep_as(Soft { first: pass.first }, pass),
            false => self.sweep_rigidly(pass),
        };
        let jointed_change = self.visit_joints(pass);
        let bodies = self.inertias.len();
        let states = cells(&mut self.velocities).iter().take(bodies);
        let others = cells(&mut self.before).iter().zip(cells(&mut self.motions));
        for (velocity, (before, motion)) in states.zip(others) {
            pass.end(velocity, before, motion);
        }
        self.drift_joints(pass, pass.extrapolates);
        self.turn_spinners(pass, pass.extrapolates);
        self.end_joints(pass);
        self.carry_spins(pass);
        held_change + change + jointed_change
    }

    /// Visits each block once. Returns Σ W Δλ², J.
    pub fn sweep_as(&mut self, kinds: impl Kinds<L>, pass: &Pass) -> f32 {
        L::run(Sweep {
            island: self,
            kinds,
            pass,
        })
    }

    /// Visits each grab once. Returns Σ W Δλ², J.
    pub fn visit_grabs(&mut self) -> f32 {
        let mut change = 0.0;
        let [velocities, motions] = [&mut self.velocities, &mut self.motions].both(|l| cells(l));
        for held in &mut self.grabs {
            change += held.visit_among(velocities, motions, self.fastest);
        }
        change
    }

    /// Runs one rigid sweep without finishing the pass.
    pub fn sweep_rigidly(&mut self, pass: &Pass) -> f32 {
        self.sweep_as(Rigid, pass)
    }

    /// The pipeline of the last step or a new one, if sweeps may follow each other and may be faster then.
    pub fn take_pipeline(&mut self, problem: &PatchProblem) -> Option<Pipeline> {
        let kept = self.pipeline.take();
        let overlaps = pipeline::is_worthwhile(problem.threads, self.bytes())
            && self.alone
            && self.joints.is_empty()
            && self.spinners.is_empty();
        overlaps.then(|| kept.unwrap_or_else(|| self.find_pipeline(problem)))
    }

    pub fn find_pipeline(&self, problem: &PatchProblem) -> Pipeline {
        let places = &self.grab_places.places;
        Pipeline::of(&self.batches, places, problem, self.round_ends.clone())
    }

    /// The size of all blocks and points.
    pub fn bytes(&self) -> usize {
        size_of_val(&*self.blocks) + size_of_val(&*self.points)
    }

    pub fn work(&mut self) -> Work<'_, L> {
        Work {
            blocks: &mut self.blocks,
            points: &mut self.points,
            velocities: &mut self.velocities,
            before: &mut self.before,
            motions: &mut self.motions,
            grab_places: &self.grab_places.places,
            grabs: &mut self.grabs,
            fastest: self.fastest,
        }
    }
}

/// Applies the warm-start impulses of contacts in some lanes of some blocks.
struct Start<'a, L: F32xN> {
    island: &'a mut Island<L>,
    /// 1 in those lanes, else 0.
    lanes: L,
    blocks: Range<usize>,
}

impl<L: F32xN> Kernel for Start<'_, L> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Island {
            blocks,
            points,
            velocities,
            round_ends,
            ..
        } = self.island;
        let velocities = cells(velocities);
        for number in self.blocks {
            let block = &blocks[number];
            block.warm_start(&points[block.range()], velocities, self.lanes);
            round_ends.after(number, velocities);
        }
    }
}

/// One sweep, from the first block to the last or in reverse. Returns Σ Wᵢᵢ Δλᵢ², J.
struct Sweep<'a, L: F32xN, K> {
    island: &'a mut Island<L>,
    kinds: K,
    pass: &'a Pass,
}

impl<L: F32xN, K: Kinds<L>> Kernel for Sweep<'_, L, K> {
    type Output = f32;

    #[inline(always)]
    fn run(self) -> f32 {
        let Island {
            blocks,
            points,
            velocities,
            motions,
            changes,
            round_ends,
            ..
        } = self.island;
        let (velocities, motions) = (cells(velocities), cells(motions));
        let mut sum = L::ZERO;
        let count = blocks.len();
        let mut i = 0;
        while i < count {
            let number = match self.pass.down {
                true => count - 1 - i,
                false => i,
            };
            let block = &mut blocks[number];
            let points = &mut points[block.range()];
            changes[number] = block.relax(self.kinds, points, velocities, motions, self.pass);
            round_ends.after(number, velocities);
            sum += changes[number];
            i += 1;
        }
        sum.sum()
    }
}

#[cfg(test)]
mod tests;
