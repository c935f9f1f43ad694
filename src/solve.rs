//! The stage **solve**: every island by the chosen [`ContactSolver`](crate::solver::ContactSolver), side by side; then
//! velocities and impulses go back to their components.
//!
//! Where a solve goes wrong all the same, with input that was checked, its island keeps the velocities and poses from before, and
//! forgets its impulses; nobody else notices.

use crate::body::{BodyIndex, BodyTable, Quarantined, Velocity, limits};
use crate::contact::{ContactImpulses, Impulse, Manifold, PatchImpulse};
use crate::diagnosis::{BodyProblem, Suspects};
use crate::gather::{IslandProblem, Problems, SolverSlot};
use crate::islands::Islands;
use crate::settings::{
    Gravity, PhysicsThreads, SolverSettings, SpeedLimits, StabilizationSettings, StepTime,
};
use crate::solver::{Body, Problem, Rows, SolveReport};
use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;
use glam::Vec3;

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

/// See the module's text.
pub fn solve(
    mut problems: ResMut<Problems>,
    (islands, table, threads): (Res<Islands>, Res<BodyTable>, Res<PhysicsThreads>),
    given: Given,
    (mut reports, mut suspects): (ResMut<SolveReports>, ResMut<Suspects>),
    mut told: Local<Vec<Entity>>,
    mut pairs: Query<(&SolverSlot, &Manifold, &mut ContactImpulses)>,
    mut bodies: Query<(Entity, &BodyIndex, &mut Velocity), Without<Quarantined>>,
) {
    problems.each(&threads, |problem| problem.solve(&given));

    reports.0.clear();
    reports.0.extend(
        problems
            .islands
            .iter()
            .filter(|p| p.contact_count() > 0)
            .map(|p| IslandReport {
                bodies: p.bodies.len(),
                contacts: p.contact_count(),
                report: p.report.clone(),
            }),
    );
    let (rows, dt) = (given.solver.solver.rows(), given.time.dt);
    for (slot, manifold, mut impulses) in &mut pairs {
        let Some(problem) = problems.islands.get(slot.island as usize) else {
            continue;
        };
        let impulses = impulses.bypass_change_detection();
        match rows {
            _ if problem.diverged => impulses.forget(),
            Rows::Points => problem.store_contacts(slot.first, impulses, dt),
            Rows::Patches => problem.store_patches(slot.first, manifold, impulses, dt),
        }
    }
    for (entity, index, mut velocity) in &mut bodies {
        // Bodies that sleep are not gathered.
        if let Some(body) = problems.body(&islands, index.0)
            && table.holds(entity, *index)
        {
            let mut solved = Velocity {
                linear: body.linear,
                angular: body.angular,
            };
            given.speeds.cap(&mut solved);
            *velocity.bypass_change_detection() = solved;
        }
    }
    // Said of the first body of an island, when it begins to go wrong.
    let wrong = problems.islands.iter().filter(|problem| problem.diverged);
    let wrong: Vec<Entity> = wrong.filter_map(|problem| problem.first).collect();
    let new = wrong.iter().filter(|entity| !told.contains(entity));
    suspects
        .0
        .extend(new.map(|&entity| (entity, BodyProblem::Diverged)));
    *told = wrong;
}

/// What a problem is told besides its bodies and contacts.
#[derive(SystemParam)]
pub struct Given<'w> {
    solver: Res<'w, SolverSettings>,
    stabilization: Res<'w, StabilizationSettings>,
    gravity: Res<'w, Gravity>,
    speeds: Res<'w, SpeedLimits>,
    time: Res<'w, StepTime>,
}

/// What a solve may leave a body with. Well above the cap on speeds: what lands hard may be fast for a moment.
fn is_sound(body: &Body) -> bool {
    let [linear, angular] = body.motion.unwrap_or_default();
    [body.linear, linear]
        .into_iter()
        .all(|v| limits::within(v, limits::SPEED))
        && [body.angular, angular]
            .into_iter()
            .all(|v| limits::within(v, limits::SPIN))
}

impl ContactImpulses {
    /// As if nothing had ever pushed.
    fn forget(&mut self) {
        self.points.fill(Impulse::default());
        self.patches.fill(PatchImpulse::default());
    }
}

impl IslandProblem {
    fn solve(&mut self, given: &Given) {
        let settings = &*given.solver;
        self.diverged = false;
        if self.contact_count() == 0 {
            return;
        }
        let mut problem = Problem {
            bodies: &mut self.bodies,
            contacts: &mut self.contacts,
            patches: &mut self.patches,
            points: &mut self.points,
            dt: given.time.dt,
            longest: given.time.longest,
            gravity: given.gravity.0,
            max_correction_speed: given.stabilization.max_correction_speed,
            cone: settings.cone,
            iterations: settings.iterations,
            tolerance: settings.tolerance,
            free_merit: self.free_merit,
            record_history: settings.record_history,
        };
        self.report = settings.solver.solve(&mut problem);
        self.diverged = !self.bodies.iter().all(is_sound);
        if self.diverged {
            for body in &mut self.bodies {
                [body.linear, body.angular] = body.start;
                body.motion = Some([Vec3::ZERO; 2]);
            }
        }
    }

    fn store_contacts(&self, first: u32, impulses: &mut ContactImpulses, dt: f32) {
        let solved = &self.contacts[first as usize..];
        for (impulse, contact) in impulses.points.iter_mut().zip(solved) {
            let (normal, tangential) = (contact.impulse.x, contact.impulse.with_x(0.0));
            let tangential = contact.world(tangential);
            *impulse = Impulse {
                normal,
                tangential,
                warm_normal: normal / dt,
                warm_tangential: tangential / dt,
                load: 0.0,
            };
        }
    }

    /// Each point is told the share of its patch's friction that it has in the load.
    fn store_patches(
        &self,
        first: u32,
        manifold: &Manifold,
        impulses: &mut ContactImpulses,
        dt: f32,
    ) {
        let solved = &self.patches[first as usize..];
        for ((patch, found), kept) in manifold
            .patches
            .iter()
            .zip(solved)
            .zip(&mut impulses.patches)
        {
            *kept = PatchImpulse {
                warm_tangential: found.tangential / dt,
                warm_twist: found.twist / dt,
                warm_rolling: found.rolling / dt,
                load_tangential: found.load_tangential / dt,
                load_twist: found.load_twist / dt,
                dragged: found.dragged,
            };
            let points = &self.points[found.range()];
            let sum: f32 = points.iter().map(|point| point.given).sum();
            let share = if sum > 0.0 { 1.0 / sum } else { 0.0 };
            for (impulse, point) in impulses.points[patch.range()].iter_mut().zip(points) {
                *impulse = Impulse {
                    normal: point.given,
                    tangential: found.given * (point.given * share),
                    warm_normal: point.impulse / dt,
                    warm_tangential: Vec3::ZERO,
                    load: point.load / dt,
                };
            }
        }
    }
}
