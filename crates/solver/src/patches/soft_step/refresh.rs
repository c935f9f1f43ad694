//! The begin and the end of a step for blocks: they load the state of a problem, and store the results.

use super::contact::pass::Pass;
use super::contact::spring::Spring;
use super::island::Island;
use super::joints::Contacts;
use super::sweeps::following::Following;
use super::sweeps::halves::Part;
use super::sweeps::{Changes, Mode};
use crate::Both;
use crate::batches::Batches;
use crate::lanes::{F32xN, Kernel, State, cells};
use crate::{Body, PatchProblem};
use glam::Vec4;
use std::ops::Range;

/// The data from which blocks are refreshed.
pub struct Fresh<'a, 'p> {
    pub problem: &'a PatchProblem<'p>,
    pub batches: &'a Batches,
    /// Whether effective masses were computed before.
    pub prepared: bool,
    /// By patch: its contact has another revision.
    pub changed: &'a [bool],
    /// By body: its inertia has changed; none if none has.
    pub turned: Option<&'a [bool]>,
    pub substeps: usize,
    /// Velocities of the free motion.
    pub free: &'a [State],
    pub spring: &'a Spring,
    /// See [`Island::frequencies`].
    pub frequencies: &'a [f32],
    pub pass: &'a Pass,
    /// Points farther apart than this are open and get no impulse, m.
    pub closed: f32,
    /// Springs see no depth beyond this separation, m.
    pub deepest: f32,
}

/// Refreshes some blocks and computes the merit of their free motion, J; both at once, while a block is in the cache.
pub struct Refresh<'a, 'p, L: F32xN> {
    pub part: Part<'a, L, L>,
    pub fresh: &'a Fresh<'a, 'p>,
}

impl<L: F32xN> Kernel for Refresh<'_, '_, L> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { part, fresh } = self;
        let problem = fresh.problem;
        let mut i = 0;
        while i < part.blocks.len() {
            let points = part.points_of(i);
            let (block, points) = (&mut part.blocks[i], &mut part.points[points]);
            let patches = fresh.batches.block(part.first + i);
            let mut stale = !fresh.prepared;
            for (lane, number) in patches.clone() {
                let patch = &problem.patches[number as usize];
                if fresh.changed[number as usize] {
                    let stiffness = block.stiffness[lane];
                    block.load(points, lane, patch, problem, stiffness);
                    stale = true;
                } else if let Some(turned) = fresh.turned {
                    for (side, body) in patch.bodies.into_iter().enumerate() {
                        if turned[body as usize] {
                            let body = &problem.bodies[body as usize];
                            block.turn(lane, side, &body.inverse_inertia);
                            stale = true;
                        }
                    }
                }
            }
            block.begin(
                points,
                patches.clone(),
                problem,
                fresh.substeps,
                fresh.deepest,
            );
            if fresh.closed < f32::INFINITY {
                block.rest(points, fresh.closed);
            }
            if stale {
                block.prepare(points);
            }
            let mut omega = L::splat(fresh.spring.omega);
            if !fresh.frequencies.is_empty() {
                for (lane, number) in patches {
                    omega[lane] = fresh.frequencies[number as usize];
                }
            }
            block.soften(fresh.spring, omega);
            part.found[i] = block.missing(points, fresh.free, fresh.pass);
            i += 1;
        }
    }
}

/// Stores the impulses in the problem.
pub struct End<'a, 'p, L: F32xN> {
    pub island: &'a Island<L>,
    pub problem: &'a mut PatchProblem<'p>,
    pub rate: f32,
}

impl<L: F32xN> Kernel for End<'_, '_, L> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self {
            island,
            problem,
            rate,
        } = self;
        for (block, patches) in island.blocks.iter().zip(island.batches.iter()) {
            let points = &island.points[block.range()];
            block.end(
                points,
                patches,
                problem,
                (island.substeps, island.skipped),
                rate,
            );
        }
    }
}

/// Number of blocks that one thread refreshes before it applies their warm-start impulses. They stay in its cache for both.
const BLOCKS_AT_A_TIME: usize = 64;

impl<L: F32xN> Island<L> {
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
        for segment in 0..self.batches.segments() {
            L::run(Start {
                lanes: self.lanes_of(|of| of == segment),
                island: &mut *self,
                blocks: blocks.clone(),
            });
        }
    }

    /// 1 in the lanes whose segments satisfy `is`, else 0.
    pub fn lanes_of(&self, is: impl Fn(usize) -> bool) -> L {
        let mut lanes = L::ZERO;
        for lane in 0..self.batches.lanes_used() {
            if is(self.batches.segment_of(lane)) {
                lanes[lane] = 1.0;
            }
        }
        lanes
    }

    /// Refreshes all blocks from the problem, and applies the warm-start impulses of contacts and grabs in the order of the sweep. Returns
    /// the merit of the free motion, J.
    pub fn refresh(
        &mut self,
        problem: &PatchProblem,
        spring: &Spring,
        pass: &Pass,
        closed: f32,
    ) -> f32 {
        self.refresh_before(problem, spring, pass, closed, &mut |_, _| ())
    }

    /// Like [`refresh`](Self::refresh). Calls `then` after every few blocks, with the number of blocks that are done.
    fn refresh_before(
        &mut self,
        problem: &PatchProblem,
        spring: &Spring,
        pass: &Pass,
        closed: f32,
        then: &mut dyn FnMut(&mut Self, usize),
    ) -> f32 {
        self.free.clone_from(&self.velocities);
        for held in &self.grabs {
            held.start(cells(&mut self.velocities));
        }
        self.missing.resize(self.blocks.len(), L::ZERO);
        let count = self.blocks.len();
        let size = match problem.threads == 1 && self.batches.segments() == 1 {
            true => BLOCKS_AT_A_TIME,
            false => count.max(1),
        };
        for first in (0..count).step_by(size) {
            let blocks = first..(first + size).min(count);
            self.refresh_blocks(blocks.clone(), problem, spring, pass, closed);
            self.warm_start(blocks.clone());
            then(self, blocks.end);
        }
        self.prepared = true;
        let missing = self.missing.iter();
        missing.fold(L::ZERO, |sum, &missing| sum + missing).sum()
    }

    /// Refreshes some blocks, and computes the merit of the free motion in each.
    fn refresh_blocks(
        &mut self,
        blocks: Range<usize>,
        problem: &PatchProblem,
        spring: &Spring,
        pass: &Pass,
        closed: f32,
    ) {
        let fresh = Fresh {
            problem,
            batches: &self.batches,
            prepared: self.prepared,
            changed: &self.changed,
            turned: self.any_turned.then_some(&*self.turned),
            substeps: self.substeps,
            free: &self.free,
            spring,
            frequencies: &self.frequencies,
            pass,
            closed,
            deepest: self.deepest,
        };
        let points =
            self.blocks[blocks.start].range().start..self.blocks[blocks.end - 1].range().end;
        let part = Part {
            first: blocks.start,
            points: &mut self.points[points],
            found: &mut self.missing[blocks.clone()],
            blocks: &mut self.blocks[blocks],
        };
        part.each(problem.threads, &|part| {
            L::run(Refresh {
                part,
                fresh: &fresh,
            });
        });
    }

    /// Prepares the first sweep: effective masses, the forces of a substep, and the warm start. Returns the merit of the free motion, √J.
    pub fn start(
        &mut self,
        problem: &PatchProblem,
        substeps: usize,
        spring: &Spring,
        passes: &[Pass],
    ) -> f32 {
        self.start_before(problem, substeps, spring, passes, &mut |_, _| ())
    }

    /// Like [`start`](Self::start). Calls `then` after every few blocks, with the number of blocks that are prepared.
    pub fn start_before(
        &mut self,
        problem: &PatchProblem,
        substeps: usize,
        spring: &Spring,
        passes: &[Pass],
        then: &mut dyn FnMut(&mut Self, usize),
    ) -> f32 {
        self.begin(problem, substeps);
        self.begin_spinners(problem, substeps);
        self.push(problem.bodies, 1.0 / substeps as f32);
        let h = problem.dt / substeps as f32;
        self.grab_places.begin(problem, h, &mut self.grabs);
        let missing = self.refresh_before(problem, spring, &passes[0], f32::INFINITY, then);
        let contacts = Contacts {
            blocks: &mut self.blocks,
            points: &mut self.points,
            velocities: cells(&mut self.velocities),
            motions: cells(&mut self.motions),
        };
        self.joints.choose(problem, self.sweeps_joints);
        self.joints
            .begin(problem, spring, substeps, self.lanes, contacts);
        let states = [&mut *self.velocities, &mut *self.motions];
        self.swept
            .begin(&self.joints, problem, spring, substeps, states);
        missing.sqrt()
    }

    /// Like [`start`](Self::start). If the blocks are larger than caches, sweeps follow through the blocks as these are prepared, so that
    /// blocks are read from memory once: at most the first of the passes; none if blows are expected. Returns the merit of the free motion,
    /// √J, and Σ Wᵢᵢ Δλᵢ² of each sweep that is done, J.
    pub fn start_and_sweep(
        &mut self,
        problem: &PatchProblem,
        substeps: usize,
        spring: &Spring,
        passes: &[Pass],
        mode: Mode,
    ) -> (f32, Changes) {
        let may_follow = problem.threads == 1 && self.batches.segments() == 1;
        let pipeline = may_follow.then(|| self.take_pipeline(problem)).flatten();
        let upwards = passes.iter().take_while(|pass| !pass.down);
        let upwards = match mode {
            Mode::Blows => &[],
            Mode::Overlapping | Mode::OneByOne => &passes[..upwards.count()],
        };
        let bytes = self.bytes();
        let mut following = pipeline
            .as_ref()
            .and_then(|pipeline| Following::new(pipeline, upwards, bytes));
        let mut follow = |island: &mut Self, past: usize| {
            if let Some(following) = &mut following {
                following.follow(island.work(), past);
            }
        };
        let merit = self.start_before(problem, substeps, spring, passes, &mut follow);
        let changes = following.map_or_else(Changes::new, |following| following.changes());
        if may_follow {
            self.pipeline = pipeline;
        }
        (merit, changes)
    }

    /// Stores the results in the problem. Loads at rest follow them by the share `rate`.
    pub fn store(&self, problem: &mut PatchProblem, rate: f32) {
        L::run(End {
            island: self,
            problem,
            rate,
        });
        for (grab, held) in problem.grabs.iter_mut().zip(&self.grabs) {
            *grab = held.found();
        }
        let states = self.velocities.iter().zip(&self.motions);
        for (body, (velocity, motion)) in problem.bodies.iter_mut().zip(states) {
            [body.linear, body.angular] = velocity.both(Vec4::truncate);
            body.motion = Some(motion.both(|m| m.truncate() / problem.dt));
        }
        self.joints.store(problem, &self.motions, rate);
        self.swept.store(problem, &self.motions);
        self.spinners.store(problem, &self.motions);
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
