//! Edits of an order: contacts that begin or end in an island are inserted and removed where sorting would put them.
//!
//! An island with many bodies is ordered anew only if its bodies have changed, or have another order because their level of support has
//! changed. If only contacts have begun or ended, the bodies keep their order. The contacts of a body with the bodies below it stand
//! together, so just those of the bodies that have changed are sorted again. The result always equals that of a rebuild. Without edits a
//! heap of 300 hulls takes 4 to 7 % longer, and one of 3 000 cubes 2 to 6 %.

use super::order::{IslandOrder, NOWHERE, Order, OrderSlot, Source, number_edges};
use crate::body::BodyState;
use crate::revision::Revision;
use crate::solver::sort;
use smallvec::SmallVec;

/// An island with more changed bodies than this is ordered anew. An edit moves the contacts after it, so many edits cost more than a
/// rebuild.
const MAX_CHANGED: usize = 8;

/// An island with fewer bodies is ordered anew, which costs less than the list of edits.
const MIN_BODIES: usize = 64;

impl Order {
    /// Lists the changed bodies of the islands that may be edited, sorted by island, if all changes since the order was computed are known.
    pub(super) fn list_changed(&mut self, before: Option<Revision>, from: &Source) {
        self.changed.clear();
        let recent = from.islands.recent();
        if before.is_none() || recent.since != before || !from.table.removed.is_empty() {
            return;
        }
        // A thousand bricks that are spawned asleep are in no such island. Sorting all of their slots would take half a millisecond.
        let may_be_edited = |id: u32| {
            let island = self.islands.get(id as usize);
            island.is_some_and(IslandOrder::may_be_edited)
        };
        let slots = recent.slots.iter();
        let slots = slots.filter_map(|&slot| Some((from.islands.id(slot)?, slot)));
        self.changed
            .extend(slots.filter(|&(id, _)| may_be_edited(id)));
        sort::values(&mut self.changed);
        self.changed.dedup();
    }

    /// Returns true if only contacts of the island have changed.
    pub(super) fn can_edit(
        &self,
        id: u32,
        from: &Source,
        is_solved: &impl Fn(usize, &BodyState) -> bool,
    ) -> bool {
        let island = &self.islands[id as usize];
        let bodies = &island.bodies;
        let changed = self.changed_in(id);
        let (members, id) = (from.islands.members_of_id(id), Some(id));
        // The bodies that have changed must still stand between the bodies beside them.
        let keeps_place = |&(_, slot): &(u32, u32)| {
            let local = self.local[slot as usize] as usize;
            let around = local.saturating_sub(1)..(local.saturating_add(2)).min(bodies.len());
            let ranks = bodies.get(around).map(|bodies| {
                let ranks = bodies.iter().map(|member| {
                    let body = from.table.get(member.slot)?;
                    let number = from.islands.of(member.slot)?;
                    let keeps = body.entity == member.entity
                        && !from.table.is_inactive(member.slot)
                        && is_solved(number, body);
                    keeps.then(|| from.islands.rank(member.slot, body))
                });
                ranks.collect::<Option<SmallVec<[_; 3]>>>()
            });
            bodies.get(local).is_some_and(|member| member.slot == slot)
                && ranks.flatten().is_some_and(|ranks| ranks.is_sorted())
        };
        island.may_be_edited()
            && bodies.len() == members.len()
            && (1..=MAX_CHANGED).contains(&changed.len())
            && changed.iter().all(keeps_place)
            && bodies
                .iter()
                .all(|member| from.islands.id(member.slot) == id)
    }

    /// Sorts the contacts of the changed bodies of an island again.
    pub(super) fn edit(&mut self, id: u32, from: &Source) {
        let mut locals: SmallVec<[u32; MAX_CHANGED]> = SmallVec::new();
        let changed = self.changed_in(id).iter();
        locals.extend(changed.map(|&(_, slot)| self.local[slot as usize]));
        locals.sort_unstable();
        let mut first_changed = usize::MAX;
        let mut ended: SmallVec<[u32; 8]> = SmallVec::new();
        for local in locals {
            self.sort_contacts_of(id, local, from);
            let slots = &mut self.islands[id as usize].slots;
            let first = slots.partition_point(|slot| slot.higher < local);
            let end = first + slots[first..].partition_point(|slot| slot.higher == local);
            let (before, now) = (&slots[first..end], &self.lower);
            let same = |(a, (_, b)): &(&OrderSlot, &(u64, OrderSlot))| {
                (a.pair, a.edge) == (b.pair, b.edge)
            };
            let head = before.iter().zip(now).take_while(same).count();
            let tail = before[head..].iter().rev().zip(now[head..].iter().rev());
            let tail = tail.take_while(same).count();
            let at = first + head;
            let removed = at..end - tail;
            let added = &now[head..now.len() - tail];
            if removed.is_empty() && added.is_empty() {
                continue;
            }
            let removed = slots.splice(removed, added.iter().map(|&(_, slot)| slot));
            ended.extend(removed.map(|slot| slot.edge));
            first_changed = first_changed.min(at);
        }
        // The number of an edge that ended may be that of another edge by now.
        for edge in ended {
            self.by_edge[edge as usize] = NOWHERE;
        }
        let island = &mut self.islands[id as usize];
        if first_changed < usize::MAX {
            number_edges(&mut self.by_edge, id, first_changed, &island.slots);
            #[cfg(test)]
            (self.edits += 1);
        }
        island.derived_from = from.islands.revision_of_id(id);
        island.revision = Revision::next();
    }

    fn changed_in(&self, id: u32) -> &[(u32, u32)] {
        let first = self.changed.partition_point(|&(other, _)| other < id);
        let changed = &self.changed[first..];
        &changed[..changed.partition_point(|&(other, _)| other == id)]
    }
}

impl IslandOrder {
    /// Whether the island is in order and large enough for edits.
    fn may_be_edited(&self) -> bool {
        self.derived_from.is_some() && self.bodies.len() >= MIN_BODIES
    }
}
