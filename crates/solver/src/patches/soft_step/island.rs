//! An island during a step. Its blocks live as long as its contacts do.

use super::contact::block::{Block, Points};
use super::grabs::GrabPlaces;
use super::joints::Joints;
use super::joints::swept::Swept;
use super::spinners::Spinners;
use super::sweeps::layout::fixed_bodies_rest;
use super::sweeps::pipeline::Pipeline;
use crate::batches::Batches;
use crate::grab::ActiveGrab;
use crate::lanes::{F32xN, State};
use crate::revision::Revision;
use crate::rounds::{ROUND_SIZE, RoundEnds, Rounds};
use crate::{Lanes, PatchConstraint, PatchProblem};
use glam::Mat3;

/// A body with more neighbours than this gets a slower correction from each of them than the settings allow.
const CROWD_NEIGHBOURS: f32 = 6.0;

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
                        let seat = first_seat + seat.body * ROUND_SIZE as u32 + seat.number;
                        self.write_to(lane, side, seat);
                    }
                    None if moves(body) => self.write_to(lane, side, body),
                    None => {}
                }
            }
            // The sum of all corrections would throw out a body that overlaps many others.
            let slowdown = (CROWD_NEIGHBOURS * 0.5 * shared).min(1.0);
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
    /// The setting for joints.
    pub sweeps_joints: bool,
    /// By patch: the angular frequency of its springs, rad/s. Empty if all have that of the island's spring.
    pub frequencies: Vec<f32>,
    /// Fastest correction, m/s.
    pub fastest: f32,
    /// The result of [`fixed_bodies_rest`].
    pub fixed_bodies_rest: bool,
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
    /// Joints that are swept.
    pub swept: Swept<L>,
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
            sweeps_joints: false,
            frequencies: Vec::new(),
            fastest: problem.max_correction_speed,
            fixed_bodies_rest: fixed_bodies_rest(problem),
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
            swept: Swept::default(),
            spinners: Spinners::default(),
            pipeline: None,
        }
    }
}
