//! The stage **solve**: every island by the chosen [`ContactSolver`](crate::solver::ContactSolver), side by side; then
//! velocities and impulses go back to their components.

use crate::body::{BodyIndex, Quarantined, RigidBody, Velocity};
use crate::contact::{ContactImpulses, Impulse};
use crate::diagnosis::{BodyProblem, Suspects};
use crate::islands::{IslandProblem, Islands, SolverSlot};
use crate::settings::{PhysicsThreads, SolverSettings};
use crate::sleeping::Sleeping;
use crate::solver::{Problem, SolveReport};
use bevy_ecs::prelude::*;

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
    settings: Res<SolverSettings>,
    threads: Res<PhysicsThreads>,
    mut reports: ResMut<SolveReports>,
    mut suspects: ResMut<Suspects>,
    mut pairs: Query<(&SolverSlot, &mut ContactImpulses)>,
    mut bodies: Query<
        (Entity, &RigidBody, &BodyIndex, &Sleeping, &mut Velocity),
        Without<Quarantined>,
    >,
) {
    islands.each_problem(&threads, |problem| problem.solve(&settings));

    reports.0.clear();
    reports.0.extend(
        islands
            .problems
            .iter()
            .filter(|p| !p.contacts.is_empty())
            .map(|p| IslandReport {
                bodies: p.bodies.len(),
                contacts: p.contacts.len(),
                report: p.report.clone(),
            }),
    );
    for (slot, mut impulses) in &mut pairs {
        if *slot == SolverSlot::NONE {
            continue;
        }
        let solved = &islands.problems[slot.island as usize].contacts[slot.first as usize..];
        for (impulse, contact) in impulses
            .bypass_change_detection()
            .points
            .iter_mut()
            .zip(solved)
        {
            *impulse = Impulse {
                normal: contact.impulse.x,
                tangential: contact.world(contact.impulse.with_x(0.0)),
            };
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

impl IslandProblem {
    fn solve(&mut self, settings: &SolverSettings) {
        if self.contacts.is_empty() {
            return;
        }
        let mut problem = Problem {
            bodies: &mut self.bodies,
            contacts: &mut self.contacts,
            cone: settings.cone,
            iterations: settings.iterations,
            tolerance: settings.tolerance,
            free_merit: self.free_merit,
            record_history: settings.record_history,
        };
        self.report = settings.solver.solve(&mut problem);
    }
}
