//! The order in which bodies and contacts are solved. It is found when islands change, and kept while they don't.
//!
//! What touches is what *islands* found to touch. A pair is known by its entity. The row in which a query has it only says where to look
//! first: if a system between two stages has moved pairs into other tables, by a component of its own for instance, they are
//! looked for.

use super::Pairs;
use super::contact::{SolverContact, sort_key};
use crate::body::{BodyState, BodyTable};
use crate::contact::{ContactImpulses, ContactPair, Manifold, is_edited};
use crate::islands::Islands;
use crate::settings::PhysicsThreads;
use bevy_ecs::change_detection::ContiguousMut;
use bevy_ecs::entity::{Entity, EntityHashMap};

/// The bodies and contacts that are solved, in their order.
#[derive(Default)]
pub(crate) struct Order {
    /// Of islands and of bodies, for which it holds.
    versions: Option<[u64; 2]>,
    /// Dynamic bodies that are solved, by island and rank.
    pub bodies: Vec<Member>,
    /// By slot: where the body stands in its island's problem; `u32::MAX` where it is in none.
    pub local: Vec<u32>,
    slots: Vec<OrderSlot>,
    /// The same as the query has them: the row, and the place in `slots`.
    rows: Vec<(u32, u32)>,
    /// Scratch.
    places: Vec<u32>,
    spare: Vec<SolverContact<'static>>,
}

/// The place of a contact in the order.
#[derive(Clone, Copy)]
struct OrderSlot {
    island: u32,
    pair: Entity,
    /// Of its contacts when it was gathered last.
    revision: Option<u32>,
}

/// A body of an island.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Member {
    pub island: u32,
    pub slot: u32,
    pub entity: Entity,
}

impl Order {
    /// Finds it anew where it does not hold any more; true where it does.
    pub fn keep(&mut self, table: &BodyTable, islands: &Islands) -> bool {
        let versions = Some([islands.version(), table.version()]);
        if self.versions == versions {
            return true;
        }
        self.versions = versions;
        self.find(table, islands, |_, body| body.is_awake());
        false
    }

    /// Finds the order of bodies that are to be solved, of which there must be all or none of an island.
    pub fn find(
        &mut self,
        table: &BodyTable,
        islands: &Islands,
        is_solved: impl Fn(usize, &BodyState) -> bool,
    ) {
        self.order_bodies(table, islands, is_solved);
        self.order_contacts(table, islands);
    }

    /// Something else has solved.
    pub fn forget(&mut self) {
        self.versions = None;
    }

    fn order_bodies(
        &mut self,
        table: &BodyTable,
        islands: &Islands,
        is_solved: impl Fn(usize, &BodyState) -> bool,
    ) {
        let solved = table.active().filter_map(|(slot, body)| {
            let island = islands.of(slot)?;
            is_solved(island, body).then(|| (island, islands.rank(slot, body), slot, body.entity))
        });
        let mut solved: Vec<_> = solved.collect();
        solved.sort_unstable_by_key(|&(island, rank, ..)| (island, rank));
        self.local.clear();
        self.local.resize(table.slots(), u32::MAX);
        self.bodies.clear();
        let mut last = None;
        let mut local = 0;
        for (island, _, slot, entity) in solved {
            local = if last == Some(island) { local + 1 } else { 0 };
            last = Some(island);
            self.local[slot as usize] = local;
            self.bodies.push(Member {
                island: island as u32,
                slot,
                entity,
            });
        }
    }

    fn order_contacts(&mut self, table: &BodyTable, islands: &Islands) {
        let local = &self.local;
        let is_solved = |slot: &&u32| local[**slot as usize] != u32::MAX;
        let touching = islands.links().iter();
        let mut slots: Vec<(u128, OrderSlot, u32)> = touching
            .filter_map(|link| {
                let bodies = table.both(link.slots)?;
                let island = islands.of(*link.slots.iter().find(is_solved)?)? as u32;
                let ends = link.slots.map(|slot| local[slot as usize]);
                let at = OrderSlot {
                    island,
                    pair: link.pair,
                    revision: None,
                };
                Some((sort_key(island, bodies, ends), at, link.row))
            })
            .collect();
        slots.sort_unstable_by_key(|&(key, ..)| key);
        self.slots.clear();
        self.slots.extend(slots.iter().map(|&(_, slot, _)| slot));
        self.rows.clear();
        let rows = slots.iter().map(|&(.., row)| row);
        self.rows.extend(rows.zip(0..));
        self.rows.sort_unstable();
    }

    /// So many pairs from a place on.
    pub fn pairs(&self, first: u32, count: usize) -> impl Iterator<Item = Entity> {
        let slots = &self.slots[first as usize..][..count];
        slots.iter().map(|slot| slot.pair)
    }

    /// Looks for the pairs where they are not in the rows in which they were.
    fn find_rows(&mut self, pairs: &Pairs) {
        if self.are_in_their_rows(pairs) {
            return;
        }
        let places = self.slots.iter().map(|slot| slot.pair).zip(0..);
        let places: EntityHashMap<u32> = places.collect();
        let rows = pairs.iter().zip(0..);
        let rows = rows.filter_map(|((pair, ..), row)| Some((row, *places.get(&pair)?)));
        self.rows.clear();
        self.rows.extend(rows);
    }

    fn are_in_their_rows(&self, pairs: &Pairs) -> bool {
        if self.rows.len() < self.slots.len() {
            return false;
        }
        let mut wanted = self.rows.iter().peekable();
        let mut first = 0;
        let tables = pairs.contiguous_iter();
        for (entities, ..) in tables.expect("pair components are stored in tables") {
            let end = first + entities.len() as u32;
            while let Some((row, at)) = wanted.next_if(|(row, _)| *row < end) {
                if entities[(row - first) as usize] != self.slots[*at as usize].pair {
                    return false;
                }
            }
            first = end;
        }
        wanted.next().is_none()
    }

    /// The contacts, in order; and whether they are all there: some pairs may have gone since islands were found.
    pub fn contacts<'a>(&mut self, pairs: &'a mut Pairs) -> (Vec<SolverContact<'a>>, bool) {
        self.find_rows(pairs);
        let mut contacts = reuse(std::mem::take(&mut self.spare));
        self.places.clear();
        let mut wanted = self.rows.iter().copied();
        let mut next = wanted.next();
        let mut first = 0;
        for (_, pairs, manifolds, targets, impulses) in pairs
            .contiguous_iter_mut()
            .expect("pair components are stored in tables")
        {
            // By a user, that is: our own stages bypass change detection, and count revisions.
            let edited = is_edited!(pairs) || is_edited!(manifolds) || is_edited!(impulses);
            let edits: Vec<bool> = match edited {
                true => (0..pairs.len())
                    .map(|row| {
                        is_edited!(pairs, row)
                            || is_edited!(manifolds, row)
                            || is_edited!(impulses, row)
                    })
                    .collect(),
                false => Vec::new(),
            };
            let (pairs, manifolds) = (pairs.into_inner(), manifolds.into_inner());
            let (impulses, _) = ContiguousMut::bypass_change_detection_split(impulses);
            let rows = impulses.iter_mut().zip(pairs).zip(manifolds).zip(targets);
            for (row, (((impulses, pair), manifold), targets)) in rows.enumerate() {
                let Some((number, at)) = next else {
                    break;
                };
                if first + row as u32 != number {
                    continue;
                }
                next = wanted.next();
                let slot = &mut self.slots[at as usize];
                let revision = slot.revision.replace(pair.revision);
                let edited = edits.get(row).copied().unwrap_or(false);
                impulses.fit(manifold);
                self.places.push(at);
                contacts.push(SolverContact {
                    island: slot.island,
                    changed: edited || revision != Some(pair.revision),
                    pair,
                    manifold,
                    targets,
                    impulses,
                });
            }
            first += pairs.len() as u32;
        }
        let complete = contacts.len() == self.slots.len();
        if !complete {
            self.leave_out_missing();
        }
        put_in_place(&mut contacts, &mut self.places);
        (contacts, complete)
    }

    /// Takes pairs that have gone out of the order, which holds for this step alone.
    fn leave_out_missing(&mut self) {
        self.forget();
        let mut found = self.places.clone();
        found.sort_unstable();
        let place = |at: u32| found.partition_point(|other| *other < at) as u32;
        self.places.iter_mut().for_each(|at| *at = place(*at));
        self.rows.iter_mut().for_each(|(_, at)| *at = place(*at));
        self.slots = found.iter().map(|&at| self.slots[at as usize]).collect();
    }

    /// Takes the memory of a list back.
    pub fn take_back(&mut self, contacts: Vec<SolverContact>) {
        self.spare = reuse(contacts);
    }

    /// Hands each pair that was gathered, and is still there, to `store`, with where its impulses go: on several `threads`, if they are given.
    pub fn store_each(
        &mut self,
        pairs: &mut Pairs,
        threads: Option<&PhysicsThreads>,
        store: impl Fn(Stored) + Sync,
    ) {
        self.find_rows(pairs);
        if self.rows.len() < self.slots.len() {
            self.forget();
        }
        let tables = pairs.contiguous_iter_mut();
        let mut rest = &*self.rows;
        let mut first = 0;
        for (_, pairs, manifolds, _, impulses) in
            tables.expect("pair components are stored in tables")
        {
            let (impulses, _) = ContiguousMut::bypass_change_detection_split(impulses);
            let end = first + pairs.len() as u32;
            let (rows, others) = rest.split_at(rest.partition_point(|&(row, _)| row < end));
            rest = others;
            let columns = Columns {
                first,
                rows,
                slots: &self.slots,
                pairs: pairs.into_inner(),
                manifolds: manifolds.into_inner(),
                impulses,
            };
            match threads {
                Some(threads) => threads.run(usize::MAX, || columns.share(&store)),
                None => columns.each(&store),
            }
            first = end;
        }
    }
}

/// A pair that was gathered, and where its impulses go.
pub(crate) struct Stored<'a> {
    /// Its place in the order.
    pub place: u32,
    pub island: u32,
    /// It is not the contact that was gathered.
    pub renewed: bool,
    pub manifold: &'a Manifold,
    pub impulses: &'a mut ContactImpulses,
}

/// Rows of a table, or some of them, from `first` on.
struct Columns<'a> {
    first: u32,
    /// Those that were gathered: the row and the place in `slots`.
    rows: &'a [(u32, u32)],
    slots: &'a [OrderSlot],
    pairs: &'a [ContactPair],
    manifolds: &'a [Manifold],
    impulses: &'a mut [ContactImpulses],
}

/// Pairs that one thread stores at a time.
const SHARE: usize = 256;

impl Columns<'_> {
    fn each(self, store: impl Fn(Stored)) {
        for &(row, place) in self.rows {
            let row = (row - self.first) as usize;
            let slot = &self.slots[place as usize];
            store(Stored {
                place,
                island: slot.island,
                renewed: slot.revision != Some(self.pairs[row].revision),
                manifold: &self.manifolds[row],
                impulses: &mut self.impulses[row],
            });
        }
    }

    /// The same by halves, on several threads.
    fn share(self, store: &(impl Fn(Stored) + Sync)) {
        if self.rows.len() <= SHARE {
            return self.each(store);
        }
        let (rows, other_rows) = self.rows.split_at(self.rows.len() / 2);
        let middle = other_rows[0].0;
        let row = (middle - self.first) as usize;
        let (pairs, other_pairs) = self.pairs.split_at(row);
        let (manifolds, other_manifolds) = self.manifolds.split_at(row);
        let (impulses, other_impulses) = self.impulses.split_at_mut(row);
        let one = Columns {
            rows,
            pairs,
            manifolds,
            impulses,
            ..self
        };
        let other = Columns {
            first: middle,
            rows: other_rows,
            slots: self.slots,
            pairs: other_pairs,
            manifolds: other_manifolds,
            impulses: other_impulses,
        };
        rayon::join(|| one.share(store), || other.share(store));
    }
}

/// Empties a list, for others of the same kind that live longer or shorter: collected in place, they have its memory.
fn reuse<A, B>(mut list: Vec<A>) -> Vec<B> {
    list.clear();
    list.into_iter()
        .map(|_| unreachable!("it is empty"))
        .collect()
}

/// Puts each item where it is to stand.
fn put_in_place<T>(items: &mut [T], places: &mut [u32]) {
    for i in 0..items.len() {
        while places[i] as usize != i {
            let place = places[i] as usize;
            items.swap(i, place);
            places.swap(i, place);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn items_come_to_their_places() {
        let mut places = [3, 0, 2, 4, 1];
        let mut items = places;
        put_in_place(&mut items, &mut places);
        assert_eq!(items, [0, 1, 2, 3, 4]);
    }

    #[test]
    fn an_emptied_list_keeps_its_memory() {
        let text = String::from("a");
        let mut list: Vec<&str> = Vec::with_capacity(100);
        list.push(&text);
        let other: Vec<&'static str> = reuse(list);
        assert!(other.is_empty() && other.capacity() >= 100);
    }
}
