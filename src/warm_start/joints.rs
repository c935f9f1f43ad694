//! The joints of awake islands, as part of their problems.
//!
//! Joints are the links of their kind in the constraint graph between bodies that are solved. Each is identified by its entity and the
//! number of its edge. They are solved in the order of their bodies, those between the same bodies in spawn order.

use super::{Order, ProblemSet};
use crate::body::BodyTable;
use crate::graph::{ConstraintGraph, EdgeKind, Islands};
use crate::joint_types::{BreakForce, JointEdge, JointForces};
use crate::revision::Revision;
use crate::solver::{Both, JointConstraint, sort};
use bevy_ecs::prelude::*;

pub(crate) type Joints<'w, 's> = Query<
    'w,
    's,
    (
        &'static JointEdge,
        &'static mut JointForces,
        Option<&'static BreakForce>,
    ),
>;

/// The joints that are solved, in order. It is computed anew when islands change.
#[derive(Default)]
pub(crate) struct JointOrder {
    /// [Revision](crate::revision) of all islands; `None` if the order is not valid.
    derived_from: Option<Revision>,
    slots: Vec<JointSlot>,
    /// Those that were gathered in this step.
    pub gathered: Vec<GatheredJoint>,
}

/// The slot of a joint in the order.
#[derive(Clone, Copy)]
struct JointSlot {
    island: u32,
    joint: Entity,
    edge: u32,
}

/// A joint that is part of a problem.
#[derive(Clone, Copy, Debug)]
pub(crate) struct GatheredJoint {
    pub island: u32,
    /// Its index in the island.
    pub index: u32,
    pub joint: Entity,
    pub edge: u32,
}

impl JointOrder {
    /// Computes the order, for the bodies of `order`.
    fn find(
        &mut self,
        order: &Order,
        (table, graph, islands): (&BodyTable, &ConstraintGraph, &Islands),
        joints: &Joints,
    ) {
        self.slots.clear();
        if !graph.has_joints() {
            return;
        }
        let local = |slot: u32| order.local.get(slot as usize).copied();
        let is_solved = |slot: u32| local(slot).is_some_and(|local| local != u32::MAX);
        // Bodies that are not solved come before the others, in spawn order; the world comes first.
        let rank = |slot: u32| match local(slot).filter(|&local| local != u32::MAX) {
            Some(local) => (1u32, u64::from(local)),
            None => (0, table.get(slot).map_or(0, |body| body.spawn_order.0)),
        };
        let mut slots: Vec<(_, JointSlot)> = Vec::new();
        for number in 0..order.numbered().len() {
            for body in &order.of(number).bodies {
                for link in graph.links_of(body.slot) {
                    // A link between two solved bodies is taken only once, from the list of A.
                    let [a, b] = link.slots;
                    if link.kind != EdgeKind::Joint || a != body.slot && is_solved(a) {
                        continue;
                    }
                    let solved = if is_solved(a) { a } else { b };
                    let (Ok((edge, ..)), Some(island)) =
                        (joints.get(link.pair), islands.of(solved))
                    else {
                        continue;
                    };
                    let island = island as u32;
                    let [a, b] = link.slots.both(rank);
                    let slot = JointSlot {
                        island,
                        joint: link.pair,
                        edge: link.edge,
                    };
                    slots.push(((island, a.max(b), a.min(b), edge.order), slot));
                }
            }
        }
        // The last sort decides, and the others between equals.
        sort::by_key(&mut slots, |&((.., order), slot)| (order, slot.edge));
        sort::by_key(&mut slots, |&((.., lower, _), _)| lower);
        sort::by_key(&mut slots, |&((island, higher, ..), _)| {
            (island, higher.0, higher.1)
        });
        self.slots.extend(slots.into_iter().map(|(_, slot)| slot));
    }
}

impl ProblemSet {
    /// Gathers the joints of awake islands.
    pub(crate) fn gather_joints(
        &mut self,
        context: (&BodyTable, &ConstraintGraph, &Islands),
        joints: &Joints,
    ) {
        let Self {
            order,
            islands,
            joints: known,
            ..
        } = self;
        let (table, _, all) = context;
        if known.derived_from != Some(all.revision()) || !table.removed.is_empty() {
            known.find(order, context, joints);
            known.derived_from = Some(all.revision());
        }
        known.gathered.clear();
        for slot in &known.slots {
            let Some(island) = islands.get_mut(slot.island as usize) else {
                continue;
            };
            let found = joints.get(slot.joint).ok();
            let found = found.filter(|(edge, ..)| edge.edge == slot.edge && edge.is_current(table));
            let Some((edge, forces, breaks)) = found else {
                // It was removed since the islands were updated, and is looked for again in the next step.
                known.derived_from = None;
                continue;
            };
            known.gathered.push(GatheredJoint {
                island: slot.island,
                index: island.joints.len() as u32,
                joint: slot.joint,
                edge: slot.edge,
            });
            island.joint_slots.push(edge.slots);
            island.joints.push(JointConstraint {
                forces: forces.start,
                rest: forces.rest,
                filtered: forces.filtered,
                late: forces.late,
                angles: forces.angles,
                filter: breaks.copied().unwrap_or_default().response,
                ..edge.constraint(table)
            });
        }
    }
}
