//! The stage **warm start**: measures the merit of the free motion, then gives each contact its share of last step's impulses.

use crate::islands::{IslandProblem, Islands};
use crate::settings::{PhysicsThreads, SolverSettings};
use crate::solver::merit::free_merit;
use bevy_ecs::prelude::*;
use rayon::prelude::*;

/// See the module's text.
pub fn warm_start(
    mut islands: ResMut<Islands>,
    settings: Res<SolverSettings>,
    threads: Res<PhysicsThreads>,
) {
    let share = settings.warm_start;
    threads.run(|| {
        islands.problems.par_iter_mut().for_each(
            |IslandProblem {
                 bodies,
                 contacts,
                 free_merit: merit,
                 ..
             }| {
                *merit = free_merit(bodies, contacts);
                for contact in contacts {
                    contact.impulse *= share;
                    if share != 0.0 {
                        contact.push(bodies, contact.world(contact.impulse));
                    }
                }
            },
        );
    });
}
