//! Soft Step: many short substeps, one sweep each, over contacts that are springs; drystone's default.
//!
//! - **Substeps** instead of iterations (Macklin et al. 2019, "Small Steps in Physics Simulation"; Box2D v3's Soft Step). Contacts
//!   are detected once; normals and arms stay frozen, separations and slips follow the bodies.
//! - **Soft rows** for normals and for anchored friction ([`block`]): a sweep that has not converged then leaves an error
//!   of position that the next substeps take back, not one of velocity that shakes the structure. How stiff they may be is set
//!   by how often sweeps come, [`SoftStep::sweeps_per_period`], and is shared among the patches of a body, since a
//!   brick with six neighbours is held by six springs.
//! - **Sweeps by need** ([`effort`]): they come at a rate, so that a structure is as stiff at any step, and what is tall, carries much, or
//!   has not settled yet gets more.
//! - **Impulses carry over whole** from substep to substep. With arms frozen they do again what they did, so that forces and
//!   warm start are an extrapolation of the velocities and cost no pass over the contacts.
//! - **Every third substep is followed by a rigid sweep** that only stops motion. Without any, disturbances grow from course to
//!   course in walls and pyramids of 40 courses; those get one after every second, with which, at equal sweeps, arches tremble and
//!   small pyramids drift twice as far.
//! - **Preload**: a spring gives way under its load, and a tower of springs sinks and leans. So the rows carry their load at rest by
//!   themselves, and springs rest where surfaces meet and where friction took hold: integral action. The mean of a patch is followed
//!   slowly, because a fast one shakes; by how much a point carries more or less than it, as it does where something leans, far
//!   more slowly, or bodies would rock. Where load is taken off, a row holds on to most of it, which makes it the stiffer on that
//!   side; towers stand by that.
//! - **The longest of recent steps** sets the stiffness ([`PatchProblem::longest`]): springs that became stiffer with every short step
//!   would throw what a long one has let sink.
//! - **Cold start** ([`cold_start`]): what was just built is given impulses and loads that keep it still, and what bore something that
//!   is gone is relieved of it.
//! - **Patches side by side** ([`lanes`](crate::solver::lanes)): as many as one register holds numbers, four or eight, in blocks whose
//!   patches share no body ([`batches`](crate::solver::batches)); where patches stand in a row, those of several sweeps ([`laps`]).
//! - Points of a patch share one friction force and one twist, held by one anchor.
//!
//! What each part is worth is measured by `examples/study`, and stands in `docs/stability.md`.

mod block;
mod carry;
mod cold_start;
mod effort;
mod halves;
mod kinds;
mod laps;
#[cfg(test)]
mod masonry;
mod pipeline;
mod survey;
mod visit;

use super::{PatchConstraint, PatchProblem, PatchSolver, restitution};
use crate::solver::batches::Batches;
#[cfg(target_arch = "x86_64")]
use crate::solver::lanes::F32x8;
use crate::solver::lanes::{F32x4, F32xN, Kernel, State, cells};
use crate::solver::width::Width;
use crate::solver::{Body, Lanes, SolveReport};
use block::{Block, Pass, Points, Spring};
use effort::{Course, Effort};
use glam::{Mat3, Vec3, Vec4};
use halves::Part;
use kinds::{Kinds, Rigid, Soft};
use laps::Laps;
use pipeline::{Pipeline, Work};
use std::f32::consts::TAU;
use survey::{Footing, Survey};

/// A body that touches more than so many others is not corrected as fast as settings allow by each of them.
const CROWD: f32 = 6.0;

/// Most sweeps that a step may be asked for.
const SWEEPS: usize = 1_000_000;

/// See the module's text.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SoftStep {
    /// Damping ratio ζ of soft rows. 5 to 20 work.
    pub damping_ratio: f32,
    /// Sweeps in one period of the spring that a soft row is. Fewer make it stiffer: at 9.5 an arch shakes at Δt 0.1, below 9 tall
    /// stacks do; above 11 they lean.
    pub sweeps_per_period: f32,
    /// Share by which soft rows hold on to a load that is being taken off, 0..1.
    pub preload: f32,
    /// Sweeps in which the mean comes most of the way (1 − 1/e) to a new load. 800 make towers drift.
    pub preload_sweeps: f32,
    /// Longest substep, s. A step takes as many as it needs to stay below; structures that are tall or carry much take more.
    pub longest_substep: f32,
    /// Sweeps of a short step, at least; soft and rigid ones together.
    pub least_sweeps: usize,
    /// Sweeps of a step, at most. Springs are as stiff as sweeps come often, so where this is fewer than the step's length and the
    /// structure call for, they are softer.
    pub most_sweeps: usize,
    /// How many patches are relaxed side by side.
    pub lanes: Lanes,
}

impl Default for SoftStep {
    fn default() -> Self {
        Self {
            damping_ratio: 10.0,
            sweeps_per_period: 10.0,
            preload: 0.8,
            preload_sweeps: 1600.0,
            longest_substep: 1.0 / 720.0,
            least_sweeps: 4,
            most_sweeps: 192,
            lanes: Lanes::Auto,
        }
    }
}

impl PatchSolver for SoftStep {
    fn name(&self) -> &str {
        "soft-step"
    }

    fn problem(&self) -> Option<String> {
        let (least, most) = (self.least_sweeps, self.most_sweeps);
        if least > SWEEPS || !(1..=SWEEPS).contains(&most) {
            return Some(format!(
                "least_sweeps and most_sweeps of Soft Step are {least} and {most}, and may be {SWEEPS}, the second at least 1"
            ));
        }
        let bounds = [
            ("damping_ratio", self.damping_ratio, 0.0, 1e3),
            ("sweeps_per_period", self.sweeps_per_period, 1.0, 1e6),
            ("preload", self.preload, 0.0, 1.0),
            ("preload_sweeps", self.preload_sweeps, 1.0, 1e9),
            ("longest_substep", self.longest_substep, 1e-6, 1e3),
        ];
        bounds
            .into_iter()
            .find(|(_, x, least, most)| !(least..=most).contains(&x))
            .map(|(name, x, least, most)| {
                format!("{name} of Soft Step is {x}, and must be between {least} and {most}")
            })
            .or_else(|| self.lanes.problem())
    }

    fn solve(&self, problem: &mut PatchProblem) -> SolveReport {
        let mut found = None;
        match self.width(problem, &mut found) {
            #[cfg(target_arch = "x86_64")]
            Width::Eight => self.solve_in::<F32x8>(problem, found),
            Width::Four => self.solve_in::<F32x4>(problem, None),
        }
    }
}

impl SoftStep {
    /// The width for a problem: what it was in the last step, where the patches are the same. If that is eight for the first time, the
    /// blocks are `found` on the way.
    #[cfg(target_arch = "x86_64")]
    fn width(&self, problem: &PatchProblem, found: &mut Option<Batches>) -> Width {
        self.lanes.width(|| {
            was_auto::<F32x8>(problem) || !was_auto::<F32x4>(problem) && fills_eight(problem, found)
        })
    }

    /// The width for a problem.
    #[cfg(not(target_arch = "x86_64"))]
    fn width(&self, _: &PatchProblem, _: &mut Option<Batches>) -> Width {
        Width::Four
    }

    fn solve_in<L: F32xN>(
        &self,
        problem: &mut PatchProblem,
        batches: Option<Batches>,
    ) -> SolveReport {
        let mut kept = problem.memory.take::<Island<L>>();
        let mut scratch = match &mut kept {
            Some((island, _)) => std::mem::take(&mut island.scratch),
            None => Scratch::default(),
        };
        let span = tracing::info_span!("refresh").entered();
        let mut survey = Survey::of(problem, &mut scratch.footing);
        let bounces = survey.bounces.then(|| restitution::find(problem));
        if cold_start::cold_start::<L>(problem, &scratch.footing) {
            survey = Survey::of(problem, &mut scratch.footing);
        }
        let effort = Effort::new(
            self,
            problem,
            (&survey, &scratch.footing),
            &mut scratch.courses,
        );
        let (mut island, changed) = Island::<L>::of(kept, problem, self.lanes, batches);
        let h = problem.dt / effort.substeps as f32;
        let spring = Spring {
            omega: TAU * effort.rate / self.sweeps_per_period,
            damping_ratio: self.damping_ratio,
            h,
        };
        self.plan(effort, h, &mut scratch.passes);
        let free_merit = island.start(problem, &changed, effort.substeps, &spring, &scratch.passes);
        drop(span);
        let span = tracing::info_span!("sweeps").entered();
        let mut report = SolveReport::new(free_merit, problem.record_history);
        island.sweep(problem, &scratch.passes, |change| {
            report.record(change.max(0.0).sqrt());
        });
        drop(span);
        let _span = tracing::info_span!("store").entered();
        island.store(
            problem,
            (report.sweeps as f32 / self.preload_sweeps).min(1.0),
        );
        island.scratch = scratch;
        problem.memory.keep(island);
        if let Some(bounces) = bounces {
            restitution::bounce(problem, bounces, effort.substeps);
        }
        report
    }

    /// The sweeps of a step in substeps of so many s, and what is done after each.
    fn plan(&self, effort: Effort, h: f32, passes: &mut Vec<Pass>) {
        passes.clear();
        for substep in 1..=effort.substeps {
            let last = substep == effort.substeps;
            let soft = Pass {
                soft: true,
                first: substep == 1,
                rate: 1.0 / h,
                preload: self.preload,
                drift: Some(h),
                extrapolates: false,
            };
            passes.push(soft);
            if substep % effort.substeps_per_rigid_sweep == 0 || last {
                passes.push(Pass {
                    soft: false,
                    drift: None,
                    ..soft
                });
            }
            if let Some(pass) = passes.last_mut().filter(|_| !last) {
                pass.extrapolates = true;
            }
        }
    }
}

/// Lists that live as long as a call, and whose memory is kept.
#[derive(Default)]
struct Scratch {
    footing: Vec<Footing>,
    courses: Vec<Course>,
    passes: Vec<Pass>,
}

/// It was so in the last step, by itself, and for what is still so.
#[cfg(target_arch = "x86_64")]
fn was_auto<L: F32xN>(problem: &PatchProblem) -> bool {
    let kept = problem.memory.peek::<Island<L>>();
    kept.is_some_and(|island| {
        island.lanes == Lanes::Auto && island.alone == stands_by_itself(problem)
    })
}

/// A visit to a block of eight costs 1.1 times one of four.
#[cfg(target_arch = "x86_64")]
fn fills_eight(problem: &PatchProblem, found: &mut Option<Batches>) -> bool {
    if problem.patches.len() < HALF_FULL {
        return false;
    }
    found.insert(laps(F32x8::LANES, problem)).holds(HALF_FULL)
}

/// Patches in the mean block of eight from which on they are the faster.
#[cfg(target_arch = "x86_64")]
const HALF_FULL: usize = 4;

fn batches(lanes: usize, problem: &PatchProblem) -> Batches {
    let patches = problem.patches.iter().map(|patch| patch.bodies);
    Batches::of(lanes, patches, problem.bodies)
}

/// Folded where it may be.
fn laps(lanes: usize, problem: &PatchProblem) -> Batches {
    let patches = problem.patches.iter().map(|patch| patch.bodies);
    match stands_by_itself(problem) {
        true => Batches::folded(lanes, patches, problem.bodies),
        false => Batches::of(lanes, patches, problem.bodies),
    }
}

/// What contacts cannot change does not move either, so that sweeps may be at it all at once.
fn stands_by_itself(problem: &PatchProblem) -> bool {
    problem.bodies.iter().all(|body| {
        body.inverse_mass > 0.0 || body.start == [Vec3::ZERO; 2] && body.push() == [Vec3::ZERO; 2]
    })
}

/// One island on its way through a step.
struct Island<L: F32xN> {
    substeps: usize,
    /// What was asked for.
    lanes: Lanes,
    /// Fastest correction, m/s.
    fastest: f32,
    /// See [`stands_by_itself`].
    alone: bool,
    /// By body, 1/(kg·m²): with which blocks were prepared.
    inertias: Vec<Mat3>,
    /// By body: its inverse inertia is not that of the last step.
    turned: Vec<bool>,
    /// By patch: it was found anew.
    changed: Vec<bool>,
    batches: Batches,
    blocks: Vec<Block<L>>,
    points: Vec<Points<L>>,
    /// By body; behind them one that nothing moves, for lanes without a patch, and for each block one that nothing reads.
    velocities: Vec<State>,
    /// The same when the substep began.
    before: Vec<State>,
    /// How far bodies have come since detection, m and rad.
    motions: Vec<State>,
    /// By block: what the free motion misses, J.
    missing: Vec<L>,
    /// Made when there are threads for it.
    pipeline: Option<Pipeline>,
    /// Made where blocks are folded.
    laps: Option<Laps>,
    scratch: Scratch,
}

impl<L: F32xN> Island<L> {
    /// That of the last step, if it may be, and which of its patches were found anew since.
    fn of(
        kept: Option<(Box<Self>, Vec<u32>)>,
        problem: &PatchProblem,
        lanes: Lanes,
        batches: Option<Batches>,
    ) -> (Box<Self>, Vec<u32>) {
        let alone = stands_by_itself(problem);
        let (mut island, changed) = kept
            .filter(|(island, _)| {
                island.fastest == problem.max_correction_speed && island.alone == alone
            })
            .unwrap_or_else(|| {
                let batches = batches.unwrap_or_else(|| laps(L::LANES, problem));
                (Box::new(Self::new(problem, batches)), Vec::new())
            });
        island.lanes = lanes;
        (island, changed)
    }

    fn new(problem: &PatchProblem, batches: Batches) -> Self {
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
        let mut blocks = Vec::with_capacity(batches.blocks());
        let mut points = Vec::with_capacity(problem.points.len() / L::LANES * 5 / 4);
        // Block by block: one that is filled patch by patch leaves the cache in between.
        for lanes in batches.iter() {
            let patches = lanes.map(|(lane, patch)| (lane, &problem.patches[patch as usize]));
            let counts = patches.clone().map(|(_, patch)| patch.count);
            let count = counts.max().unwrap_or(0);
            let first = points.len();
            points.resize(first + count as usize, Points::default());
            let nowhere = nobody + 1 + blocks.len() as u32;
            blocks.push(Block::<L>::new(nobody, nowhere));
            let block = blocks.last_mut().expect("it was just added");
            block.place(first, count);
            for (lane, patch) in patches {
                let shared = shared(patch);
                block.load(&mut points[first..], lane, patch, problem, shared);
                // What lies inside many others would be thrown out by the sum of their corrections.
                let hurry = (CROWD * 0.5 * shared).min(1.0);
                block.hasten(lane, problem.max_correction_speed * hurry);
            }
        }
        Self {
            substeps: 1,
            lanes: Lanes::Auto,
            fastest: problem.max_correction_speed,
            alone: stands_by_itself(problem),
            inertias: bodies.iter().map(|body| body.inverse_inertia).collect(),
            turned: Vec::new(),
            changed: Vec::new(),
            batches,
            blocks,
            points,
            velocities: Vec::new(),
            before: Vec::new(),
            motions: Vec::new(),
            missing: Vec::new(),
            pipeline: None,
            laps: None,
            scratch: Scratch::default(),
        }
    }

    /// Takes over a problem of which so many patches are new, cut into so many substeps. To the bit what it would be if it were made anew:
    /// nobody must be able to tell by what others do to a world.
    fn begin(&mut self, problem: &PatchProblem, changed: &[u32], substeps: usize) {
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
        let further = self.velocities.len() + 1 + self.blocks.len();
        self.velocities.resize(further, State::default());
        self.before.clone_from(&self.velocities);
        self.motions.clear();
        self.motions.resize(self.velocities.len(), State::default());
    }

    /// Bodies feel so much of this step's forces.
    fn push(&mut self, bodies: &[Body], share: f32) {
        for (state, body) in self.velocities.iter_mut().zip(bodies) {
            for (velocity, push) in state.iter_mut().zip(body.push()) {
                *velocity += (push * share).extend(0.0);
            }
        }
    }

    /// Brings all blocks up to date with the problem that it has begun; what the free motion misses in each is found.
    fn refresh(&mut self, problem: &PatchProblem, spring: &Spring, pass: &Pass, closed: f32) {
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
    fn start(
        &mut self,
        problem: &PatchProblem,
        changed: &[u32],
        substeps: usize,
        spring: &Spring,
        passes: &[Pass],
    ) -> f32 {
        self.begin(problem, changed, substeps);
        self.push(problem.bodies, 1.0 / substeps as f32);
        self.refresh(problem, spring, &passes[0], f32::INFINITY);
        self.warm_start().sqrt()
    }

    /// Lets bodies feel the impulses that contacts start with, in the order of the sweep. What the free motion misses in all, J.
    fn warm_start(&mut self) -> f32 {
        let mut missing = 0.0;
        for lap in 0..self.batches.laps() {
            let mut lanes = L::ZERO;
            for lane in 0..L::LANES {
                if self.batches.lap_of(lane) == lap {
                    lanes[lane] = 1.0;
                }
            }
            let island = &mut *self;
            missing = L::run(Start { island, lanes });
        }
        missing
    }

    /// Whose inverse inertia is not that of the last step.
    fn find_turned(&mut self, bodies: &[Body]) {
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
    fn sweep(&mut self, problem: &PatchProblem, passes: &[Pass], mut tell: impl FnMut(f32)) {
        if self.batches.laps() > 1 {
            return self.sweep_in_laps(problem, passes, tell);
        }
        let pipeline = self.pipeline.take();
        let pipeline = match problem.threads > 1 && self.alone {
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
    fn sweep_alone(&mut self, pass: &Pass) -> f32 {
        let change = match pass.soft {
            true => L::run(Sweep {
                island: self,
                kinds: Soft { first: pass.first },
                pass,
            }),
            false => self.sweep_rigidly(pass),
        };
        let bodies = self.inertias.len();
        let states = cells(&mut self.velocities).iter().take(bodies);
        let others = cells(&mut self.before).iter().zip(cells(&mut self.motions));
        for (velocity, (before, motion)) in states.zip(others) {
            pass.end(velocity, before, motion);
        }
        change
    }

    /// One rigid sweep, after which nothing else happens.
    fn sweep_rigidly(&mut self, pass: &Pass) -> f32 {
        L::run(Sweep {
            island: self,
            kinds: Rigid,
            pass,
        })
    }

    fn find_pipeline(&self, problem: &PatchProblem) -> Pipeline {
        let bodies = |(_, patch): (usize, u32)| problem.patches[patch as usize].bodies;
        let blocks = self.batches.iter();
        let blocks = blocks.map(|patches| patches.flat_map(bodies));
        let moves = |body: u32| problem.bodies[body as usize].inverse_mass > 0.0;
        Pipeline::new(blocks, problem.bodies.len(), moves)
    }

    /// Of all blocks.
    fn bytes(&self) -> usize {
        size_of_val(&*self.blocks) + size_of_val(&*self.points)
    }

    fn work(&mut self) -> Work<'_, L> {
        Work {
            blocks: &mut self.blocks,
            points: &mut self.points,
            velocities: &mut self.velocities,
            before: &mut self.before,
            motions: &mut self.motions,
        }
    }

    fn store(&self, problem: &mut PatchProblem, rate: f32) {
        L::run(End {
            island: self,
            problem,
            rate,
        });
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
            ..
        } = self.island;
        let velocities = cells(velocities);
        let mut all = L::ZERO;
        for (block, missing) in blocks.iter().zip(missing.iter()) {
            block.warm_start(&points[block.range()], velocities, self.lanes);
            all += *missing;
        }
        all.sum()
    }
}

/// What blocks are brought up to date by.
struct Fresh<'a, 'p> {
    problem: &'a PatchProblem<'p>,
    batches: &'a Batches,
    /// By patch: it was found anew.
    changed: &'a [bool],
    /// By body, where any has turned.
    turned: Option<&'a [bool]>,
    substeps: usize,
    /// Of the free motion.
    velocities: &'a [State],
    spring: &'a Spring,
    pass: &'a Pass,
    /// Points farther apart than this have no part, m.
    closed: f32,
}

/// Brings some blocks up to date, and finds what the free motion misses there, J. In one go, while a block is at hand.
struct Refresh<'a, 'p, L: F32xN> {
    part: Part<'a, L, L>,
    fresh: &'a Fresh<'a, 'p>,
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
            for (lane, number) in patches.clone() {
                let patch = &problem.patches[number as usize];
                if fresh.changed[number as usize] {
                    let stiffness = block.stiffness[lane];
                    block.load(points, lane, patch, problem, stiffness);
                } else if let Some(turned) = fresh.turned {
                    for (side, body) in patch.bodies.into_iter().enumerate() {
                        if turned[body as usize] {
                            let body = &problem.bodies[body as usize];
                            block.turn(lane, side, &body.inverse_inertia);
                        }
                    }
                }
            }
            block.begin(points, patches, problem, fresh.substeps);
            if fresh.closed < f32::INFINITY {
                block.rest(points, fresh.closed);
            }
            block.prepare(points);
            block.soften(fresh.spring);
            part.found[i] = block.missing(points, fresh.velocities, fresh.pass);
            i += 1;
        }
    }
}

/// Gives impulses back to the problem.
struct End<'a, 'p, L: F32xN> {
    island: &'a Island<L>,
    problem: &'a mut PatchProblem<'p>,
    rate: f32,
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
            block.end(points, patches, problem, island.substeps, rate);
        }
    }
}

/// One sweep from the first block to the last. Σ Wᵢᵢ Δλᵢ², J.
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
            ..
        } = self.island;
        let (velocities, motions) = (cells(velocities), cells(motions));
        let mut change = L::ZERO;
        for block in blocks.iter_mut() {
            let points = &mut points[block.range()];
            change += block.relax(self.kinds, points, velocities, motions, self.pass);
        }
        change.sum()
    }
}
