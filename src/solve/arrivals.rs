//! Bodies that come into the world asleep are given what they bear, and stay where they are.
//!
//! An island that is asleep is not solved. One of which some bodies have just come would carry nothing until it wakes: neither forces nor
//! supports would be told of it, and it would take up its load as it wakes. So in the step in which bodies come, the contacts of their island
//! get the forces that keep it still, [by statics](crate::solver::patches::settle), whatever the solver.

use super::island::{From, Island};
use super::order::{Member, Order};
use super::patches::PatchRows;
use super::{Pairs, Step};
use crate::body::Velocity;

impl Step<'_> {
    /// Loads the islands that sleep and have got bodies in this step.
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
        let (gravity, dt) = (self.given.gravity.0, self.given.time.dt);
        for &Member { island, slot } in &order.bodies {
            let body = self.table.get(slot).expect("a member is in the table");
            let level = self.islands.level(slot).unwrap_or(0);
            let mut pushed = body.velocity;
            let (scale, force) = (body.gravity_scale, &body.force);
            pushed.push(
                &body.mass,
                body.pose.rotation,
                gravity * scale,
                Some(force),
                dt,
            );
            islands[island as usize].add(body, &pushed, level);
        }
        let (mut touches, _) = order.touches(pairs);
        let from = From {
            table: self.table,
            // What such an island touches stands still.
            velocities: &vec![Velocity::default(); self.table.slots()],
            local: &order.local,
            given: self.given,
        };
        let of_island = touches.chunk_by_mut(|a, b| a.island == b.island);
        of_island.for_each(|touches| islands[touches[0].island as usize].load(touches, &from));
    }
}
