//! The bodies as queries see them: the body table, with the bodies that were spawned, moved or changed since the last step in place of
//! their old state.

use crate::body::{BodyState, BodyTable, Pending};
use crate::broadphase::Broadphase;
use bevy_ecs::prelude::*;
use parry3d::bounding_volume::Aabb;
use parry3d::partitioning::{Bvh, BvhNode};

/// All bodies as one list of numbers: those of the table by their slots, and after the last slot the [pending](Pending) ones.
#[derive(Clone, Copy)]
pub(super) struct View<'w> {
    table: &'w BodyTable,
    broadphase: &'w Broadphase,
    /// `None` if the table is up to date.
    pending: Option<&'w Pending>,
}

impl<'w> View<'w> {
    pub fn new(table: &'w BodyTable, broadphase: &'w Broadphase, pending: &'w Pending) -> Self {
        Self {
            table,
            broadphase,
            pending: pending.is_of(table).then_some(pending),
        }
    }

    /// The number of the first pending body.
    fn first(&self) -> u32 {
        self.table.slots() as u32
    }

    /// The body with a number. `None` if there is none, or if a pending body replaces it.
    #[inline]
    pub fn get(&self, number: u32) -> Option<&'w BodyState> {
        let Some(pending) = self.pending else {
            return self.table.get(number);
        };
        match number.checked_sub(self.first()) {
            Some(place) => pending.get(place),
            None => (self.table.get(number)).filter(|body| pending.place_of(body.entity).is_none()),
        }
    }

    /// Whether the number is that of a pending body, whose pose is in its state.
    #[inline]
    pub fn is_pending(&self, number: u32) -> bool {
        number >= self.first()
    }

    /// The number of this entity among the pending bodies.
    pub fn pending(&self, body: Entity) -> Option<u32> {
        Some(self.first() + self.pending?.place_of(body)?)
    }

    /// The trees of boxes, each with the number of its first leaf's body.
    pub fn trees(&self) -> impl Iterator<Item = (&'w Bvh, u32)> + use<'w> {
        let pending = self.pending.map(|pending| (pending.tree(), self.first()));
        [(self.broadphase.tree(), 0)].into_iter().chain(pending)
    }

    /// Calls a function with the bodies that are in no tree, or outside of their box in it.
    pub fn each_outside(&self, found: &mut dyn FnMut(u32)) {
        for slot in self.broadphase.outside() {
            found(slot);
        }
        if let Some(pending) = self.pending {
            for place in pending.unbounded() {
                found(self.first() + place);
            }
        }
    }

    /// The bodies in trees whose boxes intersect this one.
    pub fn near(&self, aabb: &Aabb) -> Vec<u32> {
        let mut found = Vec::new();
        for (tree, first) in self.trees() {
            for leaf in tree.intersect_aabb(aabb) {
                found.push(first + leaf);
            }
        }
        found
    }

    /// The bodies in trees below nodes for which `enters` is true.
    pub fn along(&self, enters: &dyn Fn(&BvhNode) -> bool) -> Vec<u32> {
        let mut found = Vec::new();
        for (tree, first) in self.trees() {
            for leaf in tree.leaves(enters) {
                found.push(first + leaf);
            }
        }
        found
    }
}
