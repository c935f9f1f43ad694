//! The stage **solve**: every island that is awake by the chosen [`ContactSolver`](crate::settings::ContactSolver), side by side.
//!
//! A dense problem is gathered for each, of points or of patches as its solver wants (`points.rs`, `patches.rs`); what is found goes back
//! to the components. Bodies and contacts stand in the order of their level of support and their age ([`Islands`]), so the result does
//! not depend on threads or on where the ECS keeps things.
//!
//! Islands that sleep are not solved. Those of which bodies have just come are loaded (`arrivals.rs`).
//!
//! Where a solve goes wrong all the same, with input that was checked, its island keeps the velocities and poses from before, and
//! forgets its impulses; nobody else notices.

mod arrivals;
mod island;
mod order;
mod patches;
mod points;
mod touch;

use crate::body::{BodyIndex, BodyTable, Motion, Quarantined, Resting, Velocity, limits};
use crate::contact::{ContactImpulses, ContactPair, ContactTargets, Manifold};
use crate::diagnosis::{BodyProblem, Suspects, Told};
use crate::grab::{Grab, HandForce};
use crate::graph::{ConstraintGraph, Islands};
use crate::profile::Profile;
use crate::settings::{
    Gravity, Method, PhysicsThreads, SolverSettings, SpeedLimits, StabilizationSettings, StepTime,
};
use crate::solver::{Grip, SolveReport};
use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;
use glam::Vec3;
use island::{From, Island, Rows, Work};
use order::{Member, Order};
use patches::PatchRows;
use points::PointRows;
use rayon::prelude::*;
use touch::Touch;

/// How the last step's solves went, one entry for each island that had contacts.
#[derive(Resource, Default, Clone, Debug)]
pub struct SolveReports(pub Vec<IslandReport>);

/// One island's solve.
#[derive(Clone, Debug, PartialEq)]
pub struct IslandReport {
    /// Its bodies, copies of static ones included.
    pub bodies: usize,
    /// Its contact points.
    pub contacts: usize,
    /// What the solver said.
    pub report: SolveReport,
}

/// The problems of the last step, of both kinds.
#[derive(Default)]
pub struct Scratch {
    by_points: Problems<PointRows>,
    by_patches: Problems<PatchRows>,
}

/// Kept from step to step: their memory, and what has not changed.
#[derive(Default)]
struct Problems<R> {
    order: Order,
    islands: Vec<Island<R>>,
    /// By slot.
    velocities: Vec<Velocity>,
}

/// What a problem is told besides its bodies and contacts.
#[derive(SystemParam)]
pub struct Given<'w> {
    stabilization: Res<'w, StabilizationSettings>,
    solver: Res<'w, SolverSettings>,
    gravity: Res<'w, Gravity>,
    speeds: Res<'w, SpeedLimits>,
    time: Res<'w, StepTime>,
    threads: Res<'w, PhysicsThreads>,
    profile: Res<'w, Profile>,
}

/// An island is worth several threads from so many times as many points on as items are otherwise. A wall of 1 000 bricks, 12 000 points,
/// took a twentieth longer on two: its contacts are in the cache of the core that found them.
const LARGE: usize = 8;

/// So many small islands are solved together, at most: their blocks stay in the cache.
const TOGETHER: usize = 64;

/// What is said of a step's solves.
#[derive(SystemParam)]
pub struct Said<'w> {
    reports: ResMut<'w, SolveReports>,
    suspects: ResMut<'w, Suspects>,
    told: ResMut<'w, Told>,
}

type Pairs<'w, 's> = Query<
    'w,
    's,
    (
        Entity,
        Ref<'static, ContactPair>,
        Ref<'static, Manifold>,
        &'static ContactTargets,
        &'static mut ContactImpulses,
    ),
    Without<Resting>,
>;

type Bodies<'w, 's> = Query<
    'w,
    's,
    (
        Entity,
        &'static BodyIndex,
        &'static mut Velocity,
        &'static mut Motion,
    ),
    (Without<Quarantined>, Without<Resting>),
>;

type Hands<'w, 's> = Query<
    'w,
    's,
    (
        Entity,
        &'static BodyIndex,
        &'static Grab,
        &'static mut HandForce,
    ),
    (Without<Quarantined>, Without<Resting>),
>;

/// See the module's text.
pub fn solve(
    (table, graph, islands, given): (Res<BodyTable>, Res<ConstraintGraph>, Res<Islands>, Given),
    (mut scratch, mut said): (Local<Scratch>, Said),
    mut pairs: Pairs,
    mut bodies: Bodies,
    mut hands: Hands,
) {
    let step = Step {
        table: &table,
        graph: &graph,
        islands: &islands,
        given: &given,
    };
    step.load_arrivals(&mut pairs);
    let Scratch {
        by_points,
        by_patches,
    } = &mut *scratch;
    match given.solver.solver.method() {
        Method::Points(solver) => {
            by_patches.order.forget();
            step.take(
                solver,
                by_points,
                &mut pairs,
                &mut bodies,
                &mut hands,
                &mut said,
            );
        }
        Method::Patches(solver) => {
            by_points.order.forget();
            step.take(
                solver,
                by_patches,
                &mut pairs,
                &mut bodies,
                &mut hands,
                &mut said,
            );
        }
    }
}

/// The stage at work.
struct Step<'a> {
    table: &'a BodyTable,
    graph: &'a ConstraintGraph,
    islands: &'a Islands,
    given: &'a Given<'a>,
}

impl Step<'_> {
    fn take<R: Rows>(
        &self,
        solver: &R::Solver,
        problems: &mut Problems<R>,
        pairs: &mut Pairs,
        bodies: &mut Bodies,
        hands: &mut Hands,
        said: &mut Said,
    ) {
        let kept = problems.order.keep(self.table, self.graph, self.islands);
        let (mut touches, complete) = problems.order.touches(pairs);
        self.gather_bodies(problems, bodies, kept && complete);
        let held = self.gather_grips(problems, hands);
        self.solve_each(solver, problems, &mut touches);
        problems.order.take_back(touches);
        self.store_bodies(problems, bodies);
        store_grips(problems, &held, hands);
        said.report(&problems.islands);
    }

    /// The dynamic bodies of each island that is awake.
    fn gather_bodies<R: Rows>(&self, problems: &mut Problems<R>, bodies: &Bodies, kept: bool) {
        let Problems {
            order,
            islands,
            velocities,
        } = problems;
        velocities.resize(self.table.slots(), Velocity::default());
        for (entity, index, velocity, _) in bodies {
            if self.table.holds(entity, *index) {
                velocities[index.0 as usize] = *velocity;
            }
        }
        islands.resize_with(self.islands.count(), Island::default);
        islands.iter_mut().for_each(|island| island.begin(kept));
        for &Member { island, slot } in &order.bodies {
            let body = self.table.get(slot).expect("a member is in the table");
            let level = self.islands.level(slot).unwrap_or(0);
            islands[island as usize].add(body, &velocities[slot as usize], level);
        }
    }

    /// The hands on bodies that are awake, in the order of those; who is held, and in which island.
    fn gather_grips<R: Rows>(
        &self,
        problems: &mut Problems<R>,
        hands: &Hands,
    ) -> Vec<(usize, u32, Entity)> {
        let mut held: Vec<_> = hands
            .iter()
            .filter_map(|(entity, index, grab, force)| {
                let body = self
                    .table
                    .get(index.0)
                    .filter(|body| body.entity == entity)?;
                let local = problems.order.local[index.0 as usize];
                let island = self.islands.of(index.0).filter(|_| local != u32::MAX)?;
                Some((island, local, entity, grab.grip(local, body, force)))
            })
            .collect();
        held.sort_unstable_by_key(|&(island, local, ..)| (island, local));
        for &(island, .., grip) in &held {
            problems.islands[island].grips.push(grip);
        }
        let held = held.into_iter();
        held.map(|(island, local, entity, _)| (island, local, entity))
            .collect()
    }

    /// Gathers, solves and stores every island that has contacts, side by side where there is enough to do.
    fn solve_each<R: Rows>(
        &self,
        solver: &R::Solver,
        problems: &mut Problems<R>,
        touches: &mut [Touch],
    ) {
        let Problems {
            order,
            islands,
            velocities,
        } = problems;
        let points = touches.iter().map(|touch| touch.manifold.points.len());
        let points = points.sum();
        let many = islands.len() > 1;
        let mut rest = touches;
        let work = islands.iter_mut().enumerate();
        let work = work.filter_map(|(i, island)| {
            let touches = std::mem::take(&mut rest);
            let count = touches.partition_point(|touch| touch.island as usize <= i);
            let (touches, others) = touches.split_at_mut(count);
            rest = others;
            // What touches nothing and is held by nobody flies on.
            (!touches.is_empty() || !island.grips.is_empty()).then_some((island, touches))
        });
        let from = From {
            table: self.table,
            velocities,
            local: &order.local,
            given: self.given,
        };
        let solve = |(island, touches): Work<R>| island.solve(solver, touches, &from);
        let threads = &self.given.threads;
        if many {
            let (mut small, large): (Vec<_>, Vec<_>) =
                work.partition(|(island, touches)| island.grips.is_empty() && R::is_small(touches));
            let solve_small = |some: &mut [Work<R>]| match some {
                [(island, touches)] => island.solve(solver, touches, &from),
                _ => Island::solve_each(solver, some, &from),
            };
            if threads.share(points) {
                threads.run(points, || {
                    rayon::join(
                        || large.into_par_iter().with_max_len(1).for_each(solve),
                        || small.par_chunks_mut(TOGETHER).for_each(solve_small),
                    );
                });
            } else {
                large.into_iter().for_each(solve);
                small.chunks_mut(TOGETHER).for_each(solve_small);
            }
        } else if threads.share(points / LARGE) {
            threads.run(points, || work.for_each(solve));
        } else {
            work.for_each(solve);
        }
    }

    /// Velocities and motions of what is awake.
    fn store_bodies<R: Rows>(&self, problems: &Problems<R>, bodies: &mut Bodies) {
        let fall = self.given.gravity.0.length() * self.given.time.dt;
        for (entity, index, mut velocity, mut motion) in bodies {
            let Some(body) = self.table.get(index.0).filter(|body| body.entity == entity) else {
                continue;
            };
            // Bodies that sleep are in no problem.
            let local = problems.order.local[index.0 as usize];
            let island = self.islands.of(index.0);
            let island = island.and_then(|island| problems.islands.get(island));
            let Some(solved) = island.and_then(|island| island.bodies.get(local as usize)) else {
                continue;
            };
            let mut end = clean([solved.linear, solved.angular]);
            self.given.speeds.cap(&mut end);
            *velocity.bypass_change_detection() = end;
            *motion.bypass_change_detection() = match solved.motion {
                Some(mean) => Motion::Mean {
                    mean: clean(mean),
                    end,
                },
                None if R::SUBSTEPS => {
                    let gained = end.linear - body.velocity.linear;
                    Motion::Flight {
                        gained: gained.clamp_length_max(fall),
                    }
                }
                None => Motion::Steady,
            };
        }
    }
}

/// What hands did.
fn store_grips<R: Rows>(problems: &Problems<R>, held: &[(usize, u32, Entity)], hands: &mut Hands) {
    for &(island, local, entity) in held {
        let mut grips = problems.islands[island].grips.iter();
        if let Some(grip) = grips.find(|grip| grip.body == local)
            && let Ok((.., mut force)) = hands.get_mut(entity)
        {
            let Grip {
                force: push,
                torque,
                ..
            } = *grip;
            force.set_if_neq(HandForce {
                force: push,
                torque,
            });
        }
    }
}

/// What a solver has found, but for what is next to nothing.
#[inline]
fn clean(velocity: [Vec3; 2]) -> Velocity {
    let [linear, angular] = velocity.map(|v| limits::dusted(v.extend(0.0)).truncate());
    Velocity { linear, angular }
}

impl Said<'_> {
    /// Of the first body of an island that goes wrong, when it begins to.
    fn report<R: Rows>(&mut self, islands: &[Island<R>]) {
        let touching = islands.iter().filter(|island| island.points() > 0);
        self.reports.0.clear();
        self.reports.0.extend(touching.map(Island::report));
        let wrong = islands.iter().filter(|island| island.diverged);
        let wrong: Vec<Entity> = wrong.filter_map(|island| island.first).collect();
        let new = wrong
            .iter()
            .filter(|entity| !self.told.diverged.contains(entity));
        self.suspects
            .0
            .extend(new.map(|&entity| (entity, BodyProblem::Diverged)));
        self.told.diverged = wrong;
    }
}
