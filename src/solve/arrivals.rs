//! Static loads for bodies that are added asleep.
//!
//! Sleeping islands are not solved. Without further care, the contacts of a body that is added asleep would have no impulses until its
//! island wakes: queries of forces and supports would not include it, and the structure would take up its load only then. So in the step in
//! which bodies are added, the contacts of their island get the forces that keep it still, [by statics](crate::solver::patches::settle),
//! whatever the solver. Statics knows no joints: islands with joints [are solved](super::patches::settle_joined) without being moved, and
//! their joints get their forces too. Islands of a [saved scene](crate::saving) get none, because they have the forces that they had.

use super::Solve;
use super::patches::settle;
use crate::joint_types::JointForces;
use crate::settings::Method;
use crate::solver::{JointConstraint, SoftStep};
use crate::warm_start::{GatherContext, Island, Joints, Pairs, ProblemSet, Stored};

impl Solve<'_> {
    /// Loads the sleeping islands that bodies were added to in this step.
    pub(super) fn load_arrivals(&self, pairs: &mut Pairs, joints: &mut Joints) {
        if !self.islands.any_arrives() {
            return;
        }
        let mut problems = ProblemSet::default();
        let order = &mut problems.order;
        order.find(self.table, self.graph, self.islands, |island, _| {
            self.islands.arrives(island)
        });
        // Statics takes patches, whatever the solver.
        let patches = SoftStep::default();
        let (gravity, dt) = (self.context.gravity.0, self.context.time.dt);
        let (contacts, _) = order.contacts(pairs, (self.table, self.graph));
        for (number, &id) in order.numbered().iter().enumerate() {
            let mut island = Island::default();
            island.begin(id, order.of(number), false, Method::Patches(&patches));
            for member in &order.of(number).bodies {
                let body = self.table.get(member.slot);
                let body = body.expect("a member is in the table");
                let level = self.islands.level(member.slot).unwrap_or(0);
                let pushed = body.pushed(gravity, dt);
                island.add(body, &pushed, level, dt);
            }
            problems.islands.push(island);
        }
        problems.gather_joints((self.table, self.graph, self.islands), joints);
        let ProblemSet {
            order,
            islands,
            joints: gathered,
            ..
        } = &mut problems;
        let from = GatherContext {
            table: self.table,
            local: &order.local,
            context: self.context,
        };
        let mut rest = &*contacts;
        for island in &mut *islands {
            let (contacts, others) = rest.split_at(island.in_order);
            rest = others;
            // Those of a saved scene have their loads.
            let has_loads = match contacts {
                [] => island.joints.iter().any(JointConstraint::has_forces),
                _ => contacts.iter().all(|contact| contact.pair.restored()),
            };
            if has_loads {
                island.diverged = true;
                continue;
            }
            island.gather(contacts, &from);
            island.warm_start(contacts, self.context);
            island.diverged = !settle(island, self.context);
        }
        drop(contacts);
        order.store_each(pairs, self.graph, None, |stored: Stored| {
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
        for found in &gathered.gathered {
            let island = &islands[found.island as usize];
            if let Ok((_, mut forces, _)) = joints.get_mut(found.joint)
                && !island.diverged
            {
                *forces = JointForces::of(&island.joints[found.index as usize]);
            }
        }
    }
}
