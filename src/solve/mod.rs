//! The stage **solve**: computes the impulses of every awake island with the chosen [`ContactSolver`](crate::settings::ContactSolver),
//! islands in parallel, and stores them.
//!
//! The stage [warm start](crate::warm_start) has prepared the problems, of points or of patches as the solver requires. Bodies have the
//! velocities of their components when this stage begins. Bodies and contacts are ordered by their level of support and their spawn order
//! ([`Islands`]), so the result does not depend on threads or on the memory layout of the ECS.
//!
//! The results are written back to the components (`store.rs`). A pair or a body is identified by its entity: if a user's system has
//! removed it since it was gathered, nothing is stored for it.
//!
//! Sleeping islands are not solved. Those that bodies were just added to get static loads (`arrivals.rs`).
//!
//! If a solve diverges although its input was validated, the island keeps the velocities and poses from before and loses its impulses.
//! Other islands are not affected.

mod arrivals;
mod patches;
mod points;
mod reports;
mod rows;
mod store;

pub(crate) use patches::settle;

use crate::body::{ActiveBodies, BodyState, BodyTable, Velocity, limits};
use crate::graph::{ConstraintGraph, Islands};
use crate::joint::BrokenJoints;
use crate::mortar::BrokenMortar;
use crate::profile::SolvePart;
use crate::settings::{Columns, Method};
use crate::solver::{Body, PatchSolver, join::join, sort};
use crate::warm_start::{
    Grabs, Island, IslandProblems, Joints, LARGE_ISLAND_FACTOR, Pairs, PatchRows, ProblemSet, Rows,
    SolveContext,
};
use bevy_ecs::prelude::*;
use bevy_platform::time::Instant;
use glam::Vec3;
pub use reports::{IslandReport, ReportWriter, SolveReports};

/// Maximum number of small islands that are solved together, so that their blocks stay in the cache.
const MAX_ISLANDS_TOGETHER: usize = 256;

/// The system of the stage.
pub fn solve(
    (table, graph, islands, context): (
        Res<BodyTable>,
        Res<ConstraintGraph>,
        Res<Islands>,
        SolveContext,
    ),
    (mut problems, mut reports): (ResMut<IslandProblems>, ReportWriter),
    mut pairs: Pairs,
    mut bodies: ActiveBodies,
    (mut grabs, mut joints): (Grabs, Joints),
    (mut broken, mut broken_mortar): (ResMut<BrokenJoints>, ResMut<BrokenMortar>),
) {
    let stage = Solve {
        table: &table,
        graph: &graph,
        islands: &islands,
        context: &context,
    };
    stage.load_arrivals(&mut pairs, &mut joints);
    let acting = &mut Acting {
        grabs: &mut grabs,
        joints: &mut joints,
        broken: &mut broken,
        broken_mortar: &mut broken_mortar,
    };
    let problems = &mut *problems;
    // The solver that they were prepared for, even if the settings have changed since.
    let Some(solver) = problems.prepared.take() else {
        return;
    };
    let problems = &mut problems.set;
    stage.run(solver.method(), problems, &mut pairs, &mut bodies, acting);
    reports.report(problems);
}

/// Where the forces of grabs and joints are stored.
struct Acting<'a, 'w, 's> {
    grabs: &'a mut Grabs<'w, 's>,
    joints: &'a mut Joints<'w, 's>,
    broken: &'a mut BrokenJoints,
    broken_mortar: &'a mut BrokenMortar,
}

/// The data that the stage reads.
struct Solve<'a> {
    table: &'a BodyTable,
    graph: &'a ConstraintGraph,
    islands: &'a Islands,
    context: &'a SolveContext<'a>,
}

impl Solve<'_> {
    fn run(
        &self,
        method: Method,
        problems: &mut ProblemSet,
        pairs: &mut Pairs,
        bodies: &mut ActiveBodies,
        acting: &mut Acting,
    ) {
        let start = Instant::now();
        self.take_velocities(matches!(method, Method::Patches(_)), problems, bodies);
        self.solve_each(method, &mut problems.islands);
        let solved = Instant::now();
        self.store(problems, pairs, bodies, acting);
        let profile = &self.context.profile;
        profile.add_part(SolvePart::Sweeps, solved - start);
        profile.add_part(SolvePart::Store, solved.elapsed());
    }

    /// Takes the current velocities of the bodies from their components.
    fn take_velocities(
        &self,
        has_substeps: bool,
        problems: &mut ProblemSet,
        bodies: &ActiveBodies,
    ) {
        let ProblemSet {
            order,
            islands,
            outside,
            ..
        } = problems;
        outside.clear();
        for body in bodies {
            let (index, velocity) = (body.index, body.velocity);
            if !self.table.holds(body.entity, *index) {
                continue;
            }
            // A static or kinematic body may have copies in several problems.
            let local = order.local.get(index.0 as usize);
            let body = self
                .islands
                .of(index.0)
                .zip(local)
                .and_then(|(island, local)| {
                    islands.get_mut(island)?.bodies.get_mut(*local as usize)
                });
            match body {
                Some(body) => {
                    body.linear = velocity.linear;
                    body.angular = velocity.angular;
                }
                None => outside.push((index.0, *velocity)),
            }
        }
        if outside.is_empty() {
            return;
        }
        // Few bodies are in no problem, so they are searched; a list by slot would be as long as the world is large.
        sort::by_key(outside, |(slot, _)| *slot);
        // Only solvers of patches take substeps.
        let gain = |slot: u32| {
            let body = self.table.get(slot).filter(|_| has_substeps);
            body.map(BodyState::gain).unwrap_or_default()
        };
        for (slot, copy) in islands.iter_mut().flat_map(Island::copies) {
            if let Ok(at) = outside.binary_search_by_key(&slot, |(slot, _)| *slot) {
                let Velocity { linear, angular } = outside[at].1;
                let gain = gain(slot);
                let half = [0.5 * gain.linear, 0.5 * gain.angular];
                (copy.linear, copy.angular) = (linear + half[0], angular + half[1]);
                copy.start = [linear - half[0], angular - half[1]];
            }
        }
    }

    /// Solves every island that has a problem, in parallel if there is enough work.
    fn solve_each(&self, method: Method, islands: &mut [Island]) {
        let context = self.context;
        let points = islands.iter().map(Island::points).sum();
        let many = islands.len() > 1;
        let work = islands.iter_mut().filter(|island| island.is_solved());
        let is_small = |island: &Island| {
            let only_touches = island.grabs.is_empty() && island.joints.is_empty();
            let is_usual = only_touches && island.effort == 1.0;
            is_usual && island.rows.is_small(island.contacts())
        };
        let solve = |island: &mut Island| {
            let (bodies, grabs) = (&mut island.bodies, &mut island.grabs);
            let joints = &mut island.joints;
            let with = (island.effort, island.broke, context);
            island.report = island.rows.solve(method, bodies, grabs, joints, with);
            take_back_if_wrong(island);
        };
        let threads = &context.threads;
        if many {
            let solve_small = |some: &mut [&mut Island]| match (some, method) {
                ([island], _) => solve(island),
                (some, Method::Patches(solver)) => solve_together(solver, some, context),
                (some, Method::Points(_)) => some.iter_mut().for_each(|island| solve(island)),
            };
            if threads.runs_in_parallel(points) {
                let (mut small, mut large): (Vec<_>, Vec<_>) =
                    work.partition(|island| is_small(island));
                let mut small: Vec<_> = small.chunks_mut(MAX_ISLANDS_TOGETHER).collect();
                threads.run(points, || {
                    join(
                        || (&mut *large,).share(1, &|(island,)| solve(island)),
                        || (&mut *small,).share(1, &|(some,)| solve_small(some)),
                    );
                });
            } else {
                let mut small = Vec::new();
                for island in work {
                    match is_small(island) {
                        true => small.push(island),
                        false => solve(island),
                    }
                }
                small.chunks_mut(MAX_ISLANDS_TOGETHER).for_each(solve_small);
            }
        } else if threads.runs_in_parallel(points / LARGE_ISLAND_FACTOR) {
            threads.run(points, || work.for_each(solve));
        } else {
            work.for_each(solve);
        }
    }
}

/// Solves several small islands of patches.
fn solve_together(solver: &dyn PatchSolver, islands: &mut [&mut Island], context: &SolveContext) {
    let rows = islands
        .iter_mut()
        .filter_map(|island| match &mut island.rows {
            Rows::Patches(rows) => Some((rows, &mut island.bodies[..])),
            Rows::Points(_) => None,
        });
    let reports = PatchRows::solve_each(solver, rows, context);
    for (island, report) in islands.iter_mut().zip(reports) {
        island.report = report;
        take_back_if_wrong(island);
    }
}

/// Restores an island whose solution is not finite or far too fast.
fn take_back_if_wrong(island: &mut Island) {
    island.diverged = !island.bodies.iter().all(is_sound);
    if island.diverged {
        for body in &mut island.bodies {
            [body.linear, body.angular] = body.start;
            body.motion = Some([Vec3::ZERO; 2]);
        }
        for grab in &mut island.grabs {
            (grab.force, grab.torque) = (Vec3::ZERO, Vec3::ZERO);
        }
        for joint in &mut island.joints {
            joint.forces = Default::default();
            (joint.mean, joint.filtered, joint.late) = Default::default();
        }
    }
}

/// Returns true if a body's velocity is plausible. The limit is well above the speed limits, because a body that lands hard may be fast for
/// a moment.
fn is_sound(body: &Body) -> bool {
    let [linear, angular] = body.motion.unwrap_or_default();
    [body.linear, linear]
        .into_iter()
        .all(|v| limits::within(v, limits::SPEED))
        && [body.angular, angular]
            .into_iter()
            .all(|v| limits::within(v, limits::SPIN))
}
