//! Static loads for bodies that are added asleep.
//!
//! Sleeping islands are not solved. Without further care, the contacts of a body that is added asleep would have no impulses until its island
//! wakes: queries of forces and supports would not include it, and the structure would take up its load only then. So in the step in which
//! bodies are added, the contacts of their island get the forces that keep it still, [by statics](crate::solver::patches::settle), whatever
//! the solver.

use super::patches::settle;
use super::{Solve, SolveRows};
use crate::warm_start::{GatherContext, Island, Order, Pairs, PatchRows, Stored};

impl Solve<'_> {
    /// Loads the sleeping islands that bodies were added to in this step.
    pub(super) fn load_arrivals(&self, pairs: &mut Pairs) {
        if !self.islands.any_arrives() {
            return;
        }
        let mut order = Order::default();
        order.find(self.table, self.graph, self.islands, |island, _| {
            self.islands.arrives(island)
        });
        let mut islands: Vec<Island<PatchRows>> = Vec::new();
        islands.resize_with(self.islands.count(), Island::default);
        let (gravity, dt) = (self.context.gravity.0, self.context.time.dt);
        for (number, member) in (0..).zip(&order.bodies) {
            let body = self.table.get(member.slot);
            let body = body.expect("a member is in the table");
            let level = self.islands.level(member.slot).unwrap_or(0);
            let mut pushed = body.velocity;
            let (scale, force) = (body.gravity_scale, &body.force);
            pushed.push(
                &body.mass,
                body.pose.rotation,
                gravity * scale,
                Some(force),
                dt,
            );
            islands[member.island as usize].add(number, body, &pushed, level);
        }
        let (contacts, _) = order.contacts(pairs, self.table);
        let from = GatherContext {
            table: self.table,
            local: &order.local,
            context: self.context,
        };
        let mut first = 0;
        for contacts in contacts.chunk_by(|a, b| a.island == b.island) {
            let island = &mut islands[contacts[0].island as usize];
            island.first_contact = first;
            first += contacts.len() as u32;
            island.gather(contacts, &from);
            island.warm_start(contacts, self.context);
            let Island { rows, bodies, .. } = island;
            island.diverged = !settle(rows, bodies, self.context);
        }
        drop(contacts);
        order.store_each(pairs, None, |stored: Stored| {
            let island = &islands[stored.island as usize];
            if !island.diverged {
                let contact = (stored.place - island.first_contact) as usize;
                island
                    .rows
                    .store(contact, stored.manifold, stored.impulses, dt);
            }
        });
    }
}
