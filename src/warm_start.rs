//! The stage **warm start**: measures the merit of the free motion, then gives each contact its share of the force that it ended the
//! last step with.

use crate::gather::{IslandProblem, Problems};
use crate::settings::{PhysicsThreads, SolverSettings};
use crate::solver::Rows;
use crate::solver::merit::free_merit;
use bevy_ecs::prelude::*;

/// See the module's text.
pub fn warm_start(
    mut problems: ResMut<Problems>,
    settings: Res<SolverSettings>,
    threads: Res<PhysicsThreads>,
) {
    if settings.solver.rows() == Rows::Patches {
        // It starts from them in its first substep.
        return;
    }
    let share = settings.warm_start;
    problems.each(&threads, |problem| {
        let IslandProblem {
            bodies,
            contacts,
            free_merit: merit,
            ..
        } = problem;
        *merit = free_merit(bodies, contacts);
        for contact in contacts {
            contact.impulse *= share;
            if share != 0.0 {
                contact.push(bodies, contact.world(contact.impulse));
            }
        }
    });
}
