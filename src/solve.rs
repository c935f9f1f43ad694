//! The stage **solve**: every island by the chosen [`ContactSolver`](crate::solver::ContactSolver), side by side; then
//! velocities and impulses go back to their components.

use crate::body::{BodyIndex, Quarantined, RigidBody, Velocity};
use crate::contact::{ContactImpulses, Impulse, Manifold, PatchImpulse};
use crate::diagnosis::{BodyProblem, Suspects};
use crate::islands::{IslandProblem, Islands, SolverSlot};
use crate::settings::{Gravity, PhysicsThreads, SolverSettings, StabilizationSettings, StepTime};
use crate::sleeping::Sleeping;
use crate::solver::{Problem, Rows, SolveReport};
use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;

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
    mut islands: ResMut<Islands>,
    given: Given,
    threads: Res<PhysicsThreads>,
    mut reports: ResMut<SolveReports>,
    mut suspects: ResMut<Suspects>,
    mut pairs: Query<(&SolverSlot, &Manifold, &mut ContactImpulses)>,
    mut bodies: Query<
        (Entity, &RigidBody, &BodyIndex, &Sleeping, &mut Velocity),
        Without<Quarantined>,
    >,
) {
    islands.each_problem(&threads, |problem| problem.solve(&given));

    reports.0.clear();
    reports.0.extend(
        islands
            .problems
            .iter()
            .filter(|p| p.contact_count() > 0)
            .map(|p| IslandReport {
                bodies: p.bodies.len(),
                contacts: p.contact_count(),
                report: p.report.clone(),
            }),
    );
    let rows = given.solver.solver.rows();
    for (slot, manifold, mut impulses) in &mut pairs {
        if *slot == SolverSlot::NONE {
            continue;
        }
        let problem = &islands.problems[slot.island as usize];
        let impulses = impulses.bypass_change_detection();
        match rows {
            Rows::Points => problem.store_contacts(slot.first, impulses),
            Rows::Patches => problem.store_patches(slot.first, manifold, impulses),
        }
    }
    for (entity, kind, index, sleeping, mut velocity) in &mut bodies {
        let Some(island) = islands.of(index.0) else {
            continue;
        };
        let local = islands.local[index.0 as usize];
        // Not gathered: asleep, or woken since.
        if *kind != RigidBody::Dynamic || sleeping.asleep || local == u32::MAX {
            continue;
        }
        let body = &islands.problems[island].bodies[local as usize];
        let solved = Velocity {
            linear: body.linear,
            angular: body.angular,
        };
        if solved.is_finite() {
            *velocity.bypass_change_detection() = solved;
        } else {
            suspects.0.push((entity, BodyProblem::Diverged));
        }
    }
}

/// What a problem is told besides its bodies and contacts.
#[derive(SystemParam)]
pub struct Given<'w> {
    solver: Res<'w, SolverSettings>,
    stabilization: Res<'w, StabilizationSettings>,
    gravity: Res<'w, Gravity>,
    time: Res<'w, StepTime>,
}

impl IslandProblem {
    fn solve(&mut self, given: &Given) {
        let settings = &*given.solver;
        if self.contact_count() == 0 {
            return;
        }
        let mut problem = Problem {
            bodies: &mut self.bodies,
            contacts: &mut self.contacts,
            patches: &mut self.patches,
            points: &mut self.points,
            dt: given.time.dt,
            gravity: given.gravity.0,
            max_correction_speed: given.stabilization.max_correction_speed,
            cone: settings.cone,
            iterations: settings.iterations,
            tolerance: settings.tolerance,
            free_merit: self.free_merit,
            record_history: settings.record_history,
        };
        self.report = settings.solver.solve(&mut problem);
    }

    fn store_contacts(&self, first: u32, impulses: &mut ContactImpulses) {
        let solved = &self.contacts[first as usize..];
        for (impulse, contact) in impulses.points.iter_mut().zip(solved) {
            *impulse = Impulse {
                normal: contact.impulse.x,
                tangential: contact.world(contact.impulse.with_x(0.0)),
                last: contact.impulse.x,
                load: 0.0,
            };
        }
    }

    /// Each point is told the share of its patch's friction that it has in the load.
    fn store_patches(&self, first: u32, manifold: &Manifold, impulses: &mut ContactImpulses) {
        let solved = &self.patches[first as usize..];
        for ((patch, found), kept) in manifold
            .patches
            .iter()
            .zip(solved)
            .zip(&mut impulses.patches)
        {
            *kept = PatchImpulse {
                tangential: found.tangential,
                twist: found.twist,
                rolling: found.rolling,
            };
            let points = &self.points[found.range()];
            let sum: f32 = points.iter().map(|point| point.given).sum();
            let share = if sum > 0.0 { 1.0 / sum } else { 0.0 };
            for (impulse, point) in impulses.points[patch.range()].iter_mut().zip(points) {
                *impulse = Impulse {
                    normal: point.given,
                    tangential: found.given * (point.given * share),
                    last: point.impulse,
                    load: point.load,
                };
            }
        }
    }
}
