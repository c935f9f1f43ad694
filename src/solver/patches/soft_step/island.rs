//! One island on its way through a step: in blocks, which live as long as its contacts do.

use super::Scratch;
use super::block::{Block, Pass, Points, Spring};
use super::blows::Blows;
use super::halves::Part;
use super::kinds::{Kinds, Rigid, Soft};
use super::laps::Laps;
use super::pipeline::{Pipeline, Work};
use super::refresh::{End, Fresh, Refresh};
use crate::solver::batches::Batches;
use crate::solver::grip::Held;
use crate::solver::lanes::{F32xN, Kernel, State, cells};
use crate::solver::rounds::{ROUND, RoundEnds, Rounds};
use crate::solver::walls::Walls;
use crate::solver::{Body, Grip, Lanes, PatchConstraint, PatchProblem};
use glam::{Mat3, Vec3, Vec4};

/// A body that touches more than so many others is not corrected as fast as settings allow by each of them.
const CROWD: f32 = 6.0;

pub fn batches(lanes: usize, problem: &PatchProblem) -> Batches {
    let patches = problem.patches.iter().map(|patch| patch.bodies);
    Batches::of(lanes, patches, problem.bodies)
}

/// Folded where it may be.
pub fn laps(lanes: usize, problem: &PatchProblem) -> Batches {
    let patches = problem.patches.iter().map(|patch| patch.bodies);
    match stands_by_itself(problem) {
        true => Batches::folded(lanes, patches, problem.bodies),
        false => Batches::in_rounds(lanes, patches, problem.bodies),
    }
}

fn rounds(problem: &PatchProblem) -> Rounds {
    let patches = problem.patches.iter().map(|patch| patch.bodies);
    Rounds::of(patches, problem.bodies)
}

/// What contacts cannot change does not move either, and nobody holds anything, so that sweeps may be at it all at once.
pub fn stands_by_itself(problem: &PatchProblem) -> bool {
    problem.grips.is_empty()
        && problem.bodies.iter().all(|body| {
            body.inverse_mass > 0.0
                || body.start == [Vec3::ZERO; 2] && body.push() == [Vec3::ZERO; 2]
        })
}

/// One island on its way through a step.
pub struct Island<L: F32xN> {
    pub(super) substeps: usize,
    /// No point is deeper to its spring than this, a separation, m.
    pub(super) deepest: f32,
    /// What was asked for.
    pub(super) lanes: Lanes,
    /// Fastest correction, m/s.
    pub(super) fastest: f32,
    /// See [`stands_by_itself`].
    pub(super) alone: bool,
    /// Its blocks are not folded and have no rounds, though they might be and have some in another step.
    unfolded: bool,
    /// Bodies take what their rounds have changed.
    pub(super) round_ends: RoundEnds,
    /// By body, 1/(kg·m²): with which blocks were prepared.
    pub(super) inertias: Vec<Mat3>,
    /// By body: its inverse inertia is not that of the last step.
    pub(super) turned: Vec<bool>,
    /// By patch: it was found anew.
    pub(super) changed: Vec<bool>,
    pub(super) batches: Batches,
    pub(super) blocks: Vec<Block<L>>,
    pub(super) points: Vec<Points<L>>,
    /// By body; behind them one that nothing moves, for lanes without a patch, for each block one that nothing reads, and the seats of rounds.
    pub(super) velocities: Vec<State>,
    /// The same when the substep began.
    pub(super) before: Vec<State>,
    /// How far bodies have come since detection, m and rad.
    pub(super) motions: Vec<State>,
    /// By block: what the free motion misses, J.
    pub(super) missing: Vec<L>,
    /// By block: Σ W Δλ² of the last sweep, J.
    pub(super) changes: Vec<L>,
    /// Hands, visited before the blocks: what they press against has the last word.
    pub(super) grips: Vec<Held>,
    /// Made when there are threads for it.
    pub(super) pipeline: Option<Pipeline>,
    /// Made where blocks are folded.
    pub(super) laps: Option<Laps>,
    pub(super) blows: Blows<L>,
    pub(super) scratch: Scratch,
}

impl<L: F32xN> Island<L> {
    /// That of the last step, if it may be, and which of its patches were found anew since. Its blocks are not folded and have no rounds if it
    /// shall be `unfolded`: where a visit, or a sweep, must have ended before the next begins.
    pub fn of(
        kept: Option<(Box<Self>, Vec<u32>)>,
        problem: &PatchProblem,
        lanes: Lanes,
        found: Option<Batches>,
        unfolded: bool,
    ) -> (Box<Self>, Vec<u32>) {
        let alone = stands_by_itself(problem);
        let may_be = |island: &Self, changed: &[u32]| match unfolded {
            true => island.batches.laps() == 1 && !island.batches.has_rounds(),
            // A new mass comes with new patches.
            false => {
                !island.unfolded
                    && (changed.is_empty() || *island.batches.rounds() == rounds(problem))
            }
        };
        let (mut island, changed) = kept
            .filter(|(island, changed)| {
                island.fastest == problem.max_correction_speed
                    && island.alone == alone
                    && may_be(island, changed)
            })
            .unwrap_or_else(|| {
                let batches = match unfolded {
                    true => batches(L::LANES, problem),
                    false => found.unwrap_or_else(|| laps(L::LANES, problem)),
                };
                let mut island = Self::new(problem, batches);
                island.unfolded = unfolded && (alone || !rounds(problem).is_empty());
                (Box::new(island), Vec::new())
            });
        island.lanes = lanes;
        (island, changed)
    }

    pub fn new(problem: &PatchProblem, batches: Batches) -> Self {
        let bodies = &*problem.bodies;
        let nobody = bodies.len() as u32;
        let moves = |body: u32| bodies[body as usize].inverse_mass > 0.0;
        let mut neighbours = vec![0u32; bodies.len()];
        for body in problem.patches.iter().flat_map(|patch| patch.bodies) {
            neighbours[body as usize] += 1;
        }
        // A body between two others is held by two springs, and counts as the rule.
        let shared = |patch: &PatchConstraint| {
            let most = patch.bodies.into_iter().filter(|&body| moves(body));
            let most = most.map(|body| neighbours[body as usize]).max();
            2.0 / most.unwrap_or(0).max(2) as f32
        };
        let first_seat = nobody + 1 + batches.blocks() as u32;
        let mut blocks = Vec::with_capacity(batches.blocks());
        let mut points = Vec::with_capacity(problem.points.len() / L::LANES * 5 / 4);
        // Block by block: one that is filled patch by patch leaves the cache in between.
        for lanes in batches.iter() {
            let patches =
                lanes.map(|(lane, number)| (lane, number, &problem.patches[number as usize]));
            let counts = patches.clone().map(|(.., patch)| patch.count);
            let count = counts.max().unwrap_or(0);
            let first = points.len();
            points.resize(first + count as usize, Points::default());
            let nowhere = nobody + 1 + blocks.len() as u32;
            blocks.push(Block::<L>::new(nobody, nowhere));
            let block = blocks.last_mut().expect("it was just added");
            block.place(first, count);
            for (lane, number, patch) in patches {
                let shared = shared(patch);
                block.load(&mut points[first..], lane, patch, problem, shared);
                for (side, seat) in batches.rounds().seats(number).into_iter().enumerate() {
                    let body = patch.bodies[side];
                    match seat {
                        Some(seat) => {
                            let seat = first_seat + seat.body * ROUND as u32 + seat.number;
                            block.write_to(lane, side, seat);
                        }
                        None if moves(body) => block.write_to(lane, side, body),
                        None => {}
                    }
                }
                // What lies inside many others would be thrown out by the sum of their corrections.
                let hurry = (CROWD * 0.5 * shared).min(1.0);
                block.hasten(lane, problem.max_correction_speed * hurry);
            }
        }
        Self {
            substeps: 1,
            deepest: f32::NEG_INFINITY,
            lanes: Lanes::Auto,
            fastest: problem.max_correction_speed,
            alone: stands_by_itself(problem),
            unfolded: false,
            inertias: bodies.iter().map(|body| body.inverse_inertia).collect(),
            turned: Vec::new(),
            changed: Vec::new(),
            round_ends: batches.round_ends(first_seat),
            batches,
            blocks,
            points,
            velocities: Vec::new(),
            before: Vec::new(),
            motions: Vec::new(),
            missing: Vec::new(),
            changes: Vec::new(),
            grips: Vec::new(),
            pipeline: None,
            laps: None,
            blows: Blows::default(),
            scratch: Scratch::default(),
        }
    }

    /// Takes over a problem of which so many patches are new, cut into so many substeps. To the bit what it would be if it were made anew:
    /// nobody must be able to tell by what others do to a world.
    pub fn begin(&mut self, problem: &PatchProblem, changed: &[u32], substeps: usize) {
        self.substeps = substeps;
        self.find_turned(problem.bodies);
        self.changed.clear();
        self.changed.resize(problem.patches.len(), false);
        for &patch in changed {
            self.changed[patch as usize] = true;
        }
        let state = |body: &Body| body.start.map(|velocity| velocity.extend(0.0));
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

    /// Bodies feel so much of this step's forces.
    pub fn push(&mut self, bodies: &[Body], share: f32) {
        for (state, body) in self.velocities.iter_mut().zip(bodies) {
            for (velocity, push) in state.iter_mut().zip(body.push()) {
                *velocity += (push * share).extend(0.0);
            }
        }
    }

    /// Brings all blocks up to date with the problem that it has begun; what the free motion misses in each is found.
    pub fn refresh(&mut self, problem: &PatchProblem, spring: &Spring, pass: &Pass, closed: f32) {
        self.missing.resize(self.blocks.len(), L::ZERO);
        let fresh = Fresh {
            problem,
            batches: &self.batches,
            changed: &self.changed,
            turned: self.turned.contains(&true).then_some(&*self.turned),
            substeps: self.substeps,
            velocities: &self.velocities,
            spring,
            pass,
            closed,
            deepest: self.deepest,
        };
        let all = Part {
            first: 0,
            blocks: &mut self.blocks,
            points: &mut self.points,
            found: &mut self.missing,
        };
        all.each(problem.threads, &|part| {
            L::run(Refresh {
                part,
                fresh: &fresh,
            });
        });
    }

    /// Ready for the first sweep: with effective masses, a substep's forces, and the impulses that contacts start with. The merit of the
    /// free motion, √J.
    pub fn start(
        &mut self,
        problem: &PatchProblem,
        changed: &[u32],
        substeps: usize,
        spring: &Spring,
        passes: &[Pass],
    ) -> f32 {
        self.begin(problem, changed, substeps);
        self.push(problem.bodies, 1.0 / substeps as f32);
        let h = problem.dt / substeps as f32;
        self.grips.clear();
        if !problem.grips.is_empty() {
            let walls = Walls::of_patches(problem);
            let held = |grip: &Grip| {
                let held = Held::new(grip, &problem.bodies[grip.body as usize], h);
                held.in_step(problem.dt, walls.among_patches(grip.body, problem))
            };
            self.grips.extend(problem.grips.iter().map(held));
        }
        self.refresh(problem, spring, &passes[0], f32::INFINITY);
        self.warm_start().sqrt()
    }

    /// Lets bodies feel the impulses that contacts and hands start with, in the order of the sweep. What the free motion misses in all, J.
    pub fn warm_start(&mut self) -> f32 {
        for held in &self.grips {
            held.start(&mut self.velocities);
        }
        let mut missing = 0.0;
        for lap in 0..self.batches.laps() {
            let lanes = self.lanes_of(|of| of == lap);
            let island = &mut *self;
            missing = L::run(Start { island, lanes });
        }
        missing
    }

    /// 1 in the lanes of such laps, else 0.
    pub fn lanes_of(&self, is: impl Fn(usize) -> bool) -> L {
        let mut lanes = L::ZERO;
        for lane in 0..self.batches.lanes_used() {
            if is(self.batches.lap_of(lane)) {
                lanes[lane] = 1.0;
            }
        }
        lanes
    }

    /// Whose inverse inertia is not that of the last step.
    pub fn find_turned(&mut self, bodies: &[Body]) {
        let both = self.inertias.iter_mut().zip(bodies);
        self.turned.clear();
        self.turned.extend(both.map(|(before, body)| {
            let turned = *before != body.inverse_inertia;
            *before = body.inverse_inertia;
            turned
        }));
    }

    /// All sweeps: over the blocks from the first to the last each, of the bodies that came into the world first, from the ground up.
    /// Back and forth shook stacks and pyramids. Tells Σ Wᵢᵢ Δλᵢ² of each, J.
    pub fn sweep(&mut self, problem: &PatchProblem, passes: &[Pass], mut tell: impl FnMut(f32)) {
        if self.batches.laps() > 1 {
            return self.sweep_in_laps(problem, passes, tell);
        }
        let pipeline = self.pipeline.take();
        // Sweeps that meet cannot chase one another.
        let chase = problem.threads > 1 && self.alone && !passes.iter().any(|pass| pass.down);
        let pipeline = match chase {
            true => pipeline.or_else(|| Some(self.find_pipeline(problem))),
            false => None,
        };
        if let Some(pipeline) = &pipeline
            && let Some(shares) = pipeline.share(problem.threads, passes.len(), self.bytes())
        {
            let changes = pipeline.run(passes, self.work(), shares);
            changes.iter().for_each(|change| tell(change.sum()));
        } else {
            passes.iter().for_each(|pass| tell(self.sweep_alone(pass)));
        }
        self.pipeline = pipeline;
    }

    /// One sweep, and what is done after it.
    pub fn sweep_alone(&mut self, pass: &Pass) -> f32 {
        let held_change = self.visit_grips();
        let change = match pass.soft {
            true => self.sweep_as(Soft { first: pass.first }, pass),
            false => self.sweep_rigidly(pass),
        };
        let bodies = self.inertias.len();
        let states = cells(&mut self.velocities).iter().take(bodies);
        let others = cells(&mut self.before).iter().zip(cells(&mut self.motions));
        for (velocity, (before, motion)) in states.zip(others) {
            pass.end(velocity, before, motion);
        }
        held_change + change
    }

    /// One visit to each block. Σ W Δλ², J.
    pub fn sweep_as(&mut self, kinds: impl Kinds<L>, pass: &Pass) -> f32 {
        L::run(Sweep {
            island: self,
            kinds,
            pass,
        })
    }

    /// One visit to each hand. Σ W Δλ², J.
    pub fn visit_grips(&mut self) -> f32 {
        let mut change = 0.0;
        for held in &mut self.grips {
            held.aim_among(&self.motions, self.fastest);
            change += held.visit(&mut self.velocities);
        }
        change
    }

    /// One rigid sweep, after which nothing else happens.
    pub fn sweep_rigidly(&mut self, pass: &Pass) -> f32 {
        self.sweep_as(Rigid, pass)
    }

    pub fn find_pipeline(&self, problem: &PatchProblem) -> Pipeline {
        let bodies = |(_, patch): (usize, u32)| problem.patches[patch as usize].bodies;
        let blocks = self.batches.iter();
        let blocks = blocks.map(|patches| patches.flat_map(bodies));
        let moves = |body: u32| problem.bodies[body as usize].inverse_mass > 0.0;
        let round_ends = self.round_ends.clone();
        Pipeline::new(blocks, problem.bodies.len(), moves, round_ends)
    }

    /// Of all blocks.
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
        }
    }

    pub fn store(&self, problem: &mut PatchProblem, rate: f32) {
        L::run(End {
            island: self,
            problem,
            rate,
        });
        for (grip, held) in problem.grips.iter_mut().zip(&self.grips) {
            *grip = held.found();
        }
        let states = self.velocities.iter().zip(&self.motions);
        for (body, (velocity, motion)) in problem.bodies.iter_mut().zip(states) {
            [body.linear, body.angular] = velocity.map(Vec4::truncate);
            body.motion = Some(motion.map(|m| m.truncate() / problem.dt));
        }
    }
}

/// Lets bodies feel the impulses that contacts in some lanes start with. What the free motion misses in all lanes, J.
struct Start<'a, L: F32xN> {
    island: &'a mut Island<L>,
    /// 1 in those.
    lanes: L,
}

impl<L: F32xN> Kernel for Start<'_, L> {
    type Output = f32;

    #[inline(always)]
    fn run(self) -> f32 {
        let Island {
            blocks,
            points,
            velocities,
            missing,
            round_ends,
            ..
        } = self.island;
        let velocities = cells(velocities);
        let mut all = L::ZERO;
        for (number, (block, missing)) in blocks.iter().zip(missing.iter()).enumerate() {
            block.warm_start(&points[block.range()], velocities, self.lanes);
            round_ends.after(number, velocities);
            all += *missing;
        }
        all.sum()
    }
}

/// One sweep, from the first block to the last or down again. Σ Wᵢᵢ Δλᵢ², J.
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
