//! The stage **warm start**: updates the problem of every awake island and sets the impulses that its contacts start from.
//!
//! The problem of an island consists of its bodies, its contacts, its joints and the grabs on its bodies. It is kept from step to step:
//! while no contact begins or ends, only bodies that moved and contacts that were detected anew are updated. In a large island, contacts
//! that begin or end are inserted and removed. Then each contact gets the impulse that it starts from. It follows from the forces at the
//! end of the last step, whatever the length of that step was. The stage [solve](crate::solve) computes the impulses and stores them.
//!
//! Between the two stages the problems are the resource [`IslandProblems`]. Systems of your own may run there:
//!
//! - A written [`Velocity`](crate::body::Velocity) takes effect in this step: *solve* reads velocities when it begins.
//! - Changes of a pair take effect in the next step, except those of `ContactImpulses`, which *solve* overwrites, because the problem has
//!   its own copy. If the number of patches or points of a pair is changed, the computed impulses do not fit any more. The pair then has
//!   none, and starts from zero in the next step.
//! - A [`Grab`] or a [joint](crate::joint) that is inserted, changed or removed takes effect in the next step.
//! - Bodies and pairs that are despawned are still part of the solve, but nothing is stored for them.

mod backing;
mod contact;
mod edits;
mod island;
mod joints;
mod midway;
mod order;
mod patches;
mod points;
mod problems;
mod rows;

use crate::body::{BodyIndex, BodyTable, Grab, GrabForce, Inactive, Simulated};
use crate::graph::{ConstraintGraph, Islands};
use crate::pair::{MovingSurfaces, PairsMut};
use crate::profile::{Profile, SolvePart};
use crate::settings::{
    Columns, Gravity, PhysicsThreads, SleepSettings, SolverSettings, SpeedLimits,
    StabilizationSettings, StepTime,
};
use crate::solver::sort;
use bevy_ecs::entity::Entities;
use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;
use bevy_platform::time::Instant;
pub(crate) use contact::SolverContact;
pub(crate) use island::{GatherContext, Island};
pub(crate) use joints::{JointOrder, Joints};
pub(crate) use order::{IslandOrder, Member, Order, Stored};
pub(crate) use patches::PatchRows;
pub(crate) use points::PointRows;
pub(crate) use problems::{GrabbedBody, ProblemSet};
pub use problems::{IslandProblem, IslandProblems};
pub(crate) use rows::Rows;

/// The settings and the time with which islands are gathered and solved.
#[derive(SystemParam, Debug)]
pub struct SolveContext<'w> {
    pub(crate) stabilization: Res<'w, StabilizationSettings>,
    pub(crate) solver: Res<'w, SolverSettings>,
    pub(crate) gravity: Res<'w, Gravity>,
    pub(crate) speeds: Res<'w, SpeedLimits>,
    pub(crate) sleeping: Res<'w, SleepSettings>,
    pub(crate) time: Res<'w, StepTime>,
    pub(crate) threads: Res<'w, PhysicsThreads>,
    pub(crate) profile: Res<'w, Profile>,
    pub(crate) surfaces: Res<'w, MovingSurfaces>,
}

impl SolveContext<'_> {
    /// A world with copies of the resources that this parameter reads, for reading them while their own world is written.
    pub(crate) fn copy_resources(from: &World) -> World {
        fn copy<T: Resource + Clone>(from: &World, to: &mut World) {
            to.insert_resource(from.resource::<T>().clone());
        }
        let mut to = World::new();
        copy::<StabilizationSettings>(from, &mut to);
        copy::<SolverSettings>(from, &mut to);
        copy::<Gravity>(from, &mut to);
        copy::<SpeedLimits>(from, &mut to);
        copy::<SleepSettings>(from, &mut to);
        copy::<StepTime>(from, &mut to);
        copy::<PhysicsThreads>(from, &mut to);
        copy::<Profile>(from, &mut to);
        copy::<MovingSurfaces>(from, &mut to);
        to
    }
}

/// An island is divided among threads if it has this many times as many points as other items need. A wall of 1 000 bricks (12 000 points)
/// took a twentieth longer on two threads, because its contacts are in the cache of the core that detected them.
pub(crate) const LARGE_ISLAND_FACTOR: usize = 8;

/// Number of islands whose bodies one thread gathers at a time, at least.
const ISLANDS_PER_TASK: usize = 8;

/// Number of parts into which islands are divided when several threads gather their contacts.
const GATHERING_PARTS: usize = 64;

/// The columns of pairs that are gathered and stored.
#[derive(SystemParam, Debug)]
pub struct Pairs<'w, 's> {
    columns: PairsMut<'w, 's>,
    places: &'w Entities,
}

/// The bodies that are held. *Solve* writes the forces.
pub(crate) type Grabs<'w, 's> = Query<
    'w,
    's,
    (
        Entity,
        &'static BodyIndex,
        &'static Grab,
        &'static mut GrabForce,
    ),
    (Simulated, Without<Inactive>),
>;

/// The system of the stage.
pub fn warm_start(
    (table, graph, islands, context): (
        Res<BodyTable>,
        Res<ConstraintGraph>,
        Res<Islands>,
        SolveContext,
    ),
    mut problems: ResMut<IslandProblems>,
    mut pairs: Pairs,
    (grabs, joints): (Grabs, Joints),
) {
    let stage = WarmStart {
        table: &table,
        graph: &graph,
        islands: &islands,
        context: &context,
    };
    stage.run(&mut problems.set, &mut pairs, (&grabs, &joints));
    problems.prepared = Some(context.solver.solver.clone());
}

/// The data that the stage reads.
struct WarmStart<'a> {
    table: &'a BodyTable,
    graph: &'a ConstraintGraph,
    islands: &'a Islands,
    context: &'a SolveContext<'a>,
}

impl WarmStart<'_> {
    fn run(
        &self,
        problems: &mut ProblemSet,
        pairs: &mut Pairs,
        (grabs, joints): (&Grabs, &Joints),
    ) {
        let start = Instant::now();
        problems.order.keep(self.table, self.graph, self.islands);
        let (contacts, complete) = problems.order.contacts(pairs, (self.table, self.graph));
        problems.arrange();
        self.gather_bodies(problems, complete);
        self.gather_grabs(problems, grabs);
        let context = (self.table, self.graph, self.islands);
        problems.gather_joints(context, joints);
        let ProblemSet { order, islands, .. } = problems;
        // A single island is not divided among threads.
        let points = match islands.len() > 1 {
            true => contacts.iter().map(|c| c.manifold.points.len()).sum(),
            false => 0,
        };
        let from = GatherContext {
            table: self.table,
            local: &order.local,
            context: self.context,
        };
        self.each(islands, &contacts, points, |island, contacts| {
            island.gather(contacts, &from);
        });
        let refreshed = Instant::now();
        self.each(islands, &contacts, points, |island, contacts| {
            island.warm_start(contacts, self.context);
        });
        order.take_back(contacts);
        let profile = &self.context.profile;
        profile.add_part(SolvePart::Refresh, refreshed - start);
        profile.add_part(SolvePart::WarmStart, refreshed.elapsed());
    }

    /// Gathers the dynamic bodies of each awake island.
    fn gather_bodies(&self, problems: &mut ProblemSet, complete: bool) {
        let ProblemSet { order, islands, .. } = problems;
        let method = self.context.solver.solver.method();
        let gather = |(number, island): (usize, &mut Island)| {
            let order_of_it = order.of(number);
            island.begin(order.numbered()[number], order_of_it, complete, method);
            for member in &order_of_it.bodies {
                let body = self.table.get(member.slot);
                let body = body.expect("a member is in the table");
                let level = self.islands.level(member.slot).unwrap_or(0);
                island.add(body, &body.velocity, level, self.context.time.dt);
                island.broke |= self.table.broke_off(body);
            }
        };
        let threads = &self.context.threads;
        let bodies = order.bodies();
        match islands.len() > 1 && threads.runs_in_parallel(bodies) {
            true => threads.run(bodies, || {
                (0..islands.len(), &mut **islands).share(ISLANDS_PER_TASK, &gather);
            }),
            false => islands.iter_mut().enumerate().for_each(gather),
        }
    }

    /// Gathers the grabs on awake bodies, in the order of the bodies.
    fn gather_grabs(&self, problems: &mut ProblemSet, grabs: &Grabs) {
        let ProblemSet {
            order,
            islands,
            held,
            ..
        } = problems;
        held.clear();
        let mut grabs: Vec<_> = grabs
            .iter()
            .filter_map(|(entity, index, grab, force)| {
                let body = self.table.get(index.0);
                let body = body.filter(|body| body.entity == entity)?;
                let local = order.local[index.0 as usize];
                let island = self.islands.of(index.0).filter(|_| local != u32::MAX)?;
                let held = GrabbedBody {
                    island,
                    local,
                    entity,
                };
                Some((held, grab.constraint(local, body, force)))
            })
            .collect();
        sort::by_key(&mut grabs, |(held, _)| (held.island, held.local));
        for (body, grab) in grabs {
            islands[body.island].grabs.push(grab);
            held.push(body);
        }
    }

    /// Calls a function with every island that has a problem, and its contacts; in parallel if there are enough points.
    fn each(
        &self,
        islands: &mut [Island],
        contacts: &[SolverContact],
        points: usize,
        work: impl Fn(&mut Island, &[SolverContact]) + Sync,
    ) {
        let many = islands.len() > 1;
        let mut rest = contacts;
        let parts = islands.iter_mut().filter_map(|island| {
            let (contacts, others) = rest.split_at(island.in_order);
            rest = others;
            // A body that touches nothing, has no joint and is not held needs no solver.
            let is_acted_on =
                !contacts.is_empty() || !island.grabs.is_empty() || !island.joints.is_empty();
            is_acted_on.then_some((island, contacts))
        });
        let threads = &self.context.threads;
        if many && threads.runs_in_parallel(points) {
            let mut parts: Vec<_> = parts.collect();
            let share = parts.len() / GATHERING_PARTS;
            threads.run(points, || {
                (&mut *parts,).share(share.max(1), &|((island, contacts),)| {
                    work(island, contacts)
                });
            });
        } else {
            parts.for_each(|(island, contacts)| work(island, contacts));
        }
    }
}
