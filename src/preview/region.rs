//! The region that a preview copies: structures, and the bodies near them.

use super::PreviewError;
use super::copy::{Contact, contact};
use crate::body::{BodyState, BodyTable, Pending, WORLD, is_body};
use crate::broadphase::Broadphase;
use crate::graph::{ConstraintGraph, EdgeKind};
use crate::joint_types::{self, JointEdge};
use crate::pair::ContactPair;
use crate::solver::sort;
use bevy_ecs::prelude::*;
use bevy_platform::collections::{HashMap, HashSet};
use parry3d::bounding_volume::{Aabb, BoundingVolume};

/// The bodies that are copied.
pub(super) struct Region<'w> {
    pub table: &'w BodyTable,
    graph: &'w ConstraintGraph,
    /// Slots of the bodies, in spawn order.
    pub slots: Vec<u32>,
    /// Slots of the bodies that belong to the structures.
    pub structure: HashSet<u32>,
    /// Bodies that lost a contact because a body was removed since the last step. They are awake.
    pub bereft: HashSet<u32>,
    /// Bodies that were spawned or moved since the last step, as the next step will find them.
    pub pending: Vec<&'w BodyState>,
    /// Joints that were added since the last step, and their bodies, in spawn order.
    pub added: Vec<(Entity, [Option<Entity>; 2])>,
}

impl<'w> Region<'w> {
    pub fn of(
        world: &'w World,
        bodies: &[Entity],
        there: Option<Aabb>,
    ) -> Result<Self, PreviewError> {
        let table = world.resource::<BodyTable>();
        let broadphase = world.resource::<Broadphase>();
        let mut region = Self {
            table,
            graph: world.resource::<ConstraintGraph>(),
            slots: Vec::new(),
            structure: HashSet::default(),
            bereft: HashSet::default(),
            pending: Vec::new(),
            added: joint_types::added(world),
        };
        let pending = world.resource::<Pending>();
        let pending = pending.is_of(table).then_some(pending);
        let mut places = Vec::from_iter(there);
        for &body in bodies {
            let slot = table.slot_of(world, body);
            let as_it_will_be = pending.and_then(|pending| pending.body(body));
            let as_it_will_be = as_it_will_be.filter(|body| is_body(world, body.entity));
            if slot.is_none() && as_it_will_be.is_none() {
                return Err(PreviewError::NotABody(body));
            }
            slot.into_iter().for_each(|slot| region.add(world, slot));
            places.extend(as_it_will_be.and_then(extent));
        }
        // A body that is put there may touch several structures, or come to rest on them.
        for there in &places {
            for slot in broadphase.tree().intersect_aabb(there) {
                if table.get(slot).is_some_and(BodyState::is_dynamic) {
                    region.add(world, slot);
                }
            }
        }
        let structure = region.structure.iter();
        let bounded = structure.filter_map(|&slot| extent(table.get(slot)?));
        let bounded = bounded.filter(|aabb| aabb.half_extents().is_finite());
        let bounded = bounded.chain(places);
        if let Some(aabb) = bounded.reduce(|a, b| a.merged(&b)) {
            // A falling body moves sideways by at most about its height.
            let near = aabb.loosened(aabb.extents().max_element());
            region.slots.extend(broadphase.tree().intersect_aabb(&near));
            let pending = pending.into_iter().flat_map(|pending| pending.near(&near));
            let pending = pending.filter(|body| is_body(world, body.entity));
            region.pending.extend(pending);
            sort::by_key(&mut region.pending, |body| {
                (body.spawn_order, body.entity.to_bits())
            });
        }
        region.slots.extend(&region.structure);
        region.slots.extend(broadphase.outside());
        // The table still contains bodies that were removed since the last step.
        let is_there = |&body: &Entity| table.slot_of(world, body).is_some();
        let there = |slot: &u32| {
            let body = table.get(*slot);
            body.is_some_and(|body| is_there(&body.entity))
        };
        region.slots.retain(there);
        let has_lost = |pair: Entity| {
            let joint = world.get::<JointEdge>(pair);
            let joined = joint.map_or(&[][..], |joint| &joint.definition.bodies);
            let pair = world.get::<ContactPair>(pair);
            pair.is_some_and(|pair| pair.touching && !pair.bodies.iter().all(is_there))
                || !joined.iter().flatten().all(is_there)
        };
        let slots = region.slots.iter().copied();
        let bereft = slots.filter(|&slot| region.graph.edges_of(slot).any(has_lost));
        region.bereft.extend(bereft);
        let spawn_order = |&slot: &u32| (table.get(slot).map(|body| body.spawn_order), slot);
        sort::by_key(&mut region.slots, spawn_order);
        region.slots.dedup();
        Ok(region)
    }

    /// Adds the structure that a body is in: the bodies that it touches or is joined to, those that they touch, and so on, up to static and
    /// kinematic bodies.
    fn add(&mut self, world: &World, first: u32) {
        let mut next = vec![first];
        while let Some(slot) = next.pop() {
            let Some(body) = self.table.get(slot) else {
                continue;
            };
            let goes_on = body.is_dynamic() || slot == first;
            if !self.structure.insert(slot) || !goes_on {
                continue;
            }
            for edge in self.graph.edges_of(slot) {
                let pair = world.get::<ContactPair>(edge);
                let touching = pair.filter(|pair| pair.touching).map(|pair| pair.slots);
                let joined = world.get::<JointEdge>(edge).map(|joint| joint.slots);
                if let Some(slots) = touching.or(joined) {
                    next.extend(
                        slots
                            .iter()
                            .filter(|&&other| other != slot && other != WORLD),
                    );
                }
            }
            for (_, bodies) in &self.added {
                if bodies.contains(&Some(body.entity)) {
                    let others = bodies.iter().flatten();
                    next.extend(others.filter_map(|&other| self.table.slot_of(world, other)));
                }
            }
        }
    }

    /// The joints of the bodies, and their bodies, in spawn order.
    pub fn joints(&self, world: &World) -> Vec<(Entity, [Option<Entity>; 2])> {
        let slots = self.slots.iter();
        let joints = slots.flat_map(|&slot| self.graph.edges_of_kind(slot, EdgeKind::Joint));
        let mut joints: Vec<_> = joints
            .filter_map(|joint| {
                let edge = world.get::<JointEdge>(joint)?;
                Some((edge.order, joint, edge.definition.bodies))
            })
            .collect();
        joints.sort_unstable();
        joints.dedup();
        let joints = joints.into_iter();
        joints.map(|(_, joint, bodies)| (joint, bodies)).collect()
    }

    /// The contacts between the bodies that are copied.
    pub fn contacts(
        &self,
        world: &World,
        copies: &HashMap<Entity, Entity>,
    ) -> HashMap<[Entity; 2], Contact> {
        let mut contacts =
            HashMap::with_capacity_and_hasher(4 * self.slots.len(), Default::default());
        for &slot in &self.slots {
            for pair in self.graph.edges_of(slot) {
                // The pair is also in the list of its other body.
                let is_first = |pair: &ContactPair| pair.slots[0] == slot;
                if world.get::<ContactPair>(pair).is_some_and(is_first) {
                    contacts.extend(contact(world, pair, copies));
                }
            }
        }
        contacts
    }
}

/// The bounding box of a body.
fn extent(body: &BodyState) -> Option<Aabb> {
    Some(body.shape()?.compute_aabb(&body.pose.to_parry()))
}
