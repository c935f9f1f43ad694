//! The loads of structures that arrive.

use super::contacts::{Found, Structure};
use crate::body::BodyTable;
use crate::solve::settle;
use crate::warm_start::{GatherContext, Island, SolveContext, SolverContact};

/// Gives the contacts of all structures of a group the forces that keep these still. `local` is the index of each body in its structure, by
/// slot.
pub(super) fn load(group: &mut Found, table: &BodyTable, local: &[u32], context: &SolveContext) {
    let Found {
        contacts, islands, ..
    } = group;
    let from = GatherContext {
        table,
        local,
        context,
    };
    for structure in islands.iter().filter(|of| !of.contacts.is_empty()) {
        let mut island = gather(structure, table, context);
        let gathered: Vec<SolverContact> = { structure.contacts.iter() }
            .map(|&contact| {
                let contact = &contacts[contact as usize];
                let (manifold, targets, impulses, ..) = &contact.parts;
                SolverContact {
                    pair: &contact.pair,
                    manifold,
                    targets,
                    impulses,
                    table,
                }
            })
            .collect();
        island.gather(&gathered, &from);
        island.warm_start(&gathered, context);
        drop(gathered);
        if settle(&mut island, context) {
            for (number, &contact) in structure.contacts.iter().enumerate() {
                let contact = &mut contacts[contact as usize];
                let (manifold, _, impulses, ..) = &mut contact.parts;
                island
                    .rows
                    .store(number, manifold, impulses, context.time.dt);
                let touches = contact.pair.touching || impulses.normal() > 0.0;
                contact.pair.rest(touches);
            }
        }
    }
}

/// The bodies of a structure, with the velocities that forces give them in the step.
fn gather(structure: &Structure, table: &BodyTable, context: &SolveContext) -> Island {
    let (gravity, dt) = (context.gravity.0, context.time.dt);
    let mut island = Island::default();
    for &(slot, level) in &structure.members {
        let body = table.get(slot).expect("it was just added");
        let pushed = body.pushed(gravity, dt);
        island.add(body, &pushed, level, dt);
    }
    island
}
