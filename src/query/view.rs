//! Who is where: the bodies of the table and, preferred to those, the ones that were spawned, moved or changed since the last step.

use crate::body::{BodyState, BodyTable, Pending};
use crate::broadphase::Broadphase;
use bevy_ecs::prelude::*;
use parry3d::bounding_volume::Aabb;
use parry3d::partitioning::{Bvh, BvhNode};

/// All bodies as one list, by number: those of the table by their slots, and after the last slot the [pending](Pending) ones.
#[derive(Clone, Copy)]
pub(super) struct View<'w> {
    table: &'w BodyTable,
    broadphase: &'w Broadphase,
    /// None where the table is up to date.
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

    /// A body by its number; none where another number has it as it is now.
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

    /// Whether a number is that of a pending body: its pose is the one that is told with it.
    #[inline]
    pub fn is_pending(&self, number: u32) -> bool {
        number >= self.first()
    }

    /// The pending one of this entity.
    pub fn pending(&self, body: Entity) -> Option<u32> {
        Some(self.first() + self.pending?.place_of(body)?)
    }

    /// The trees of boxes, and by how much the number of a body is higher than that of its leaf.
    pub fn trees(&self) -> impl Iterator<Item = (&'w Bvh, u32)> + use<'w> {
        let pending = self.pending.map(|pending| (pending.tree(), self.first()));
        [(self.broadphase.tree(), 0)].into_iter().chain(pending)
    }

    /// Those that are not in their box in a tree, or have none.
    pub fn outside(&self) -> impl Iterator<Item = u32> + use<'w> {
        let first = self.first();
        let pending = self.pending.into_iter().flat_map(Pending::unbounded);
        (self.broadphase.outside()).chain(pending.map(move |place| first + place))
    }

    /// Those whose boxes meet another.
    pub fn near(&self, aabb: &Aabb) -> Vec<u32> {
        let leaves = |(tree, first): (&'w Bvh, u32)| {
            let leaves = tree.intersect_aabb(aabb);
            leaves.map(move |leaf| first + leaf)
        };
        self.trees().flat_map(leaves).collect()
    }

    /// Those in trees whose nodes may be entered.
    pub fn along(&self, enters: impl Fn(&BvhNode) -> bool) -> Vec<u32> {
        let leaves = |(tree, first): (&'w Bvh, u32)| {
            let leaves = tree.leaves(&enters);
            leaves.map(move |leaf| first + leaf)
        };
        self.trees().flat_map(leaves).collect()
    }
}
