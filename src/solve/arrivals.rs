//! Static loads for bodies that are added asleep.
//!
//! Sleeping islands are not solved. Without further care, the contacts of a body that is added asleep would have no impulses until its island
//! wakes: queries of forces and supports would not include it, and the structure would take up its load only then. So in the step in which
//! bodies are added, the contacts of their island get the forces that keep it still, [by statics](crate::solver::patches::settle), whatever
//! the solver. Islands with joints get none: their contacts and joints are loaded when they wake. Nor do islands of a [saved scene](crate::saving), whose contacts
//! have the forces that they had.

use super::patches::settle;
use super::{Solve, SolveRows};
use crate::graph::EdgeKind;
use crate::warm_start::{GatherContext, Island, IslandOrder, Order, Pairs, PatchRows, Stored};

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
        let (gravity, dt) = (self.context.gravity.0, self.context.time.dt);
        let is_jointed = |order: &IslandOrder| {
            order.bodies.iter().any(|member| {
                let mut joints = self.graph.edges_of_kind(member.slot, EdgeKind::Joint);
                joints.next().is_some()
            })
        };
        let (contacts, _) = order.contacts(pairs, self.table);
        for (number, &id) in order.numbered().iter().enumerate() {
            let mut island = Island::default();
            island.begin(id, order.of(number), false);
            for member in &order.of(number).bodies {
                let body = self.table.get(member.slot);
                let body = body.expect("a member is in the table");
                let level = self.islands.level(member.slot).unwrap_or(0);
                let mut pushed = body.velocity;
                let (scale, force) = (body.gravity_scale, &body.force);
                let locks = body.properties.locked_axes;
                pushed.push(
                    &body.mass,
                    (body.pose.rotation, locks),
                    gravity * scale,
                    Some(force),
                    dt,
                );
                locks.stop(&mut pushed);
                island.add(body, &pushed, level);
            }
            islands.push(island);
        }
        let from = GatherContext {
            table: self.table,
            local: &order.local,
            context: self.context,
        };
        let mut rest = &*contacts;
        for (number, island) in islands.iter_mut().enumerate() {
            let (contacts, others) = rest.split_at(island.in_order);
            rest = others;
            // Statics knows no joints.
            if is_jointed(order.of(number)) {
                island.diverged = true;
                continue;
            }
            // Those of a saved scene have their loads.
            if contacts.iter().all(|contact| contact.pair.restored()) {
                island.diverged = true;
                continue;
            }
            island.gather(contacts, &from);
            island.warm_start(contacts, self.context);
            let Island { rows, bodies, .. } = island;
            island.diverged = !settle(rows, bodies, self.context);
        }
        drop(contacts);
        order.store_each(pairs, None, |stored: Stored| {
            let island = &islands[stored.island as usize];
            if !island.diverged {
                island.rows.store(
                    stored.contact as usize,
                    stored.manifold,
                    stored.impulses,
                    dt,
                );
            }
        });
    }
}
