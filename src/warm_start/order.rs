//! The order in which bodies and contacts are solved. It is computed when islands change, and kept otherwise.
//!
//! The contacts are the links of the constraint graph between bodies that are solved. A pair is identified by the number of its edge and by
//! its entity, not by its position in a query: a system between two stages may move pairs into other tables, for example by inserting a
//! component.

use super::Pairs;
use super::contact::{SolverContact, sort_key};
use crate::body::{BodyState, BodyTable};
use crate::contact::{ContactImpulses, ContactPair, Manifold, is_edited};
use crate::graph::{ConstraintGraph, Islands};
use crate::settings::PhysicsThreads;
use bevy_ecs::change_detection::ContiguousMut;
use bevy_ecs::entity::Entity;

/// The bodies and contacts that are solved, in order.
#[derive(Default)]
pub(crate) struct Order {
    /// Versions of the islands and of the bodies for which the order was computed.
    versions: Option<[u64; 2]>,
    /// Dynamic bodies that are solved, sorted by island and rank.
    pub bodies: Vec<Member>,
    /// By slot: the index of the body in the problem of its island; `u32::MAX` if it is in none.
    pub local: Vec<u32>,
    slots: Vec<OrderSlot>,
    /// By number of an edge: its index in `slots`; `u32::MAX` if it is not solved.
    by_edge: Vec<u32>,
    /// Scratch.
    places: Vec<u32>,
    spare: Vec<SolverContact<'static>>,
}

/// The slot of a contact in the order.
#[derive(Clone, Copy)]
struct OrderSlot {
    island: u32,
    pair: Entity,
    edge: u32,
    /// Revision of the pair when it was last gathered.
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
    /// Computes the order anew if it is out of date. Returns true if it was up to date.
    pub fn keep(&mut self, table: &BodyTable, graph: &ConstraintGraph, islands: &Islands) -> bool {
        let versions = Some([islands.version(), table.version()]);
        if self.versions == versions {
            return true;
        }
        self.versions = versions;
        self.find(table, graph, islands, |_, body| body.is_awake());
        false
    }

    /// Computes the order of the bodies that are to be solved. Of each island, either all bodies or none must be among them.
    pub fn find(
        &mut self,
        table: &BodyTable,
        graph: &ConstraintGraph,
        islands: &Islands,
        is_solved: impl Fn(usize, &BodyState) -> bool,
    ) {
        self.order_bodies(table, islands, is_solved);
        self.order_contacts(table, graph, islands);
    }

    /// Discards the order, because other code has solved the islands.
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

    fn order_contacts(&mut self, table: &BodyTable, graph: &ConstraintGraph, islands: &Islands) {
        let local = &self.local;
        let is_solved = |slot: u32| local[slot as usize] != u32::MAX;
        // A link between two solved bodies is taken only once, from the list of A.
        let links = self.bodies.iter().flat_map(|body| {
            let links = graph.links_of(body.slot);
            links.filter(move |link| link.slots[0] == body.slot || !is_solved(link.slots[0]))
        });
        let mut slots: Vec<(u128, OrderSlot)> = links
            .filter_map(|link| {
                let bodies = table.both(link.slots)?;
                let solved = link.slots.into_iter().find(|&slot| is_solved(slot))?;
                let island = islands.of(solved)? as u32;
                let ends = link.slots.map(|slot| local[slot as usize]);
                let at = OrderSlot {
                    island,
                    pair: link.pair,
                    edge: link.edge,
                    revision: None,
                };
                Some((sort_key(island, bodies, ends), at))
            })
            .collect();
        slots.sort_unstable_by_key(|&(key, _)| key);
        self.slots.clear();
        self.slots.extend(slots.into_iter().map(|(_, slot)| slot));
        self.by_edge.clear();
        self.by_edge.resize(graph.edge_numbers(), u32::MAX);
        self.number_edges();
    }

    fn number_edges(&mut self) {
        for (slot, at) in self.slots.iter().zip(0..) {
            self.by_edge[slot.edge as usize] = at;
        }
    }

    /// The pairs of `count` contacts from index `first` on.
    pub fn pairs(&self, first: u32, count: usize) -> impl Iterator<Item = Entity> {
        let slots = &self.slots[first as usize..][..count];
        slots.iter().map(|slot| slot.pair)
    }

    /// The contacts in order. The flag is false if some are missing, because their pairs were removed since the islands were updated.
    pub fn contacts<'a>(
        &mut self,
        pairs: &'a mut Pairs,
        table: &'a BodyTable,
    ) -> (Vec<SolverContact<'a>>, bool) {
        let mut contacts = reuse(std::mem::take(&mut self.spare));
        self.places.clear();
        for (entities, pairs, manifolds, targets, impulses) in pairs
            .contiguous_iter_mut()
            .expect("pair components are stored in tables")
        {
            // This finds only the user's edits: our own stages bypass change detection and count revisions.
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
                let Some(&at) = self.by_edge.get(pair.edge as usize) else {
                    continue;
                };
                let Some(slot) = self.slots.get_mut(at as usize) else {
                    continue;
                };
                if slot.pair != entities[row] {
                    continue;
                }
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
                    table,
                });
            }
        }
        let complete = contacts.len() == self.slots.len();
        if !complete {
            self.leave_out_missing();
        }
        put_in_place(&mut contacts, &mut self.places);
        (contacts, complete)
    }

    /// Removes missing pairs from the order, which is then valid for this step only.
    fn leave_out_missing(&mut self) {
        self.forget();
        let mut found = self.places.clone();
        found.sort_unstable();
        let place = |at: u32| found.partition_point(|other| *other < at) as u32;
        self.places.iter_mut().for_each(|at| *at = place(*at));
        self.slots = found.iter().map(|&at| self.slots[at as usize]).collect();
        self.by_edge.fill(u32::MAX);
        self.number_edges();
    }

    /// Takes back the memory of a list.
    pub fn take_back(&mut self, contacts: Vec<SolverContact>) {
        self.spare = reuse(contacts);
    }

    /// Calls `store` for each pair that was gathered and still exists, with its impulses; in parallel if `threads` are given.
    pub fn store_each(
        &mut self,
        pairs: &mut Pairs,
        threads: Option<&PhysicsThreads>,
        store: impl Fn(Stored) + Sync,
    ) {
        let mut found = 0;
        let tables = pairs.contiguous_iter_mut();
        for (entities, pairs, manifolds, _, impulses) in
            tables.expect("pair components are stored in tables")
        {
            let (impulses, _) = ContiguousMut::bypass_change_detection_split(impulses);
            let columns = Columns {
                by_edge: &self.by_edge,
                slots: &self.slots,
                entities,
                pairs: pairs.into_inner(),
                manifolds: manifolds.into_inner(),
                impulses,
            };
            found += match threads {
                Some(threads) => threads.run(usize::MAX, || columns.share(&store)),
                None => columns.each(&store),
            };
        }
        if found < self.slots.len() {
            self.forget();
        }
    }
}

/// A pair that was gathered, and the component to store its impulses in.
pub(crate) struct Stored<'a> {
    /// Its index in the order.
    pub place: u32,
    pub island: u32,
    /// Whether its contacts were detected again after it was gathered.
    pub renewed: bool,
    pub manifold: &'a Manifold,
    pub impulses: &'a mut ContactImpulses,
}

/// Columns of a table of pairs, or a range of their rows.
struct Columns<'a> {
    by_edge: &'a [u32],
    slots: &'a [OrderSlot],
    entities: &'a [Entity],
    pairs: &'a [ContactPair],
    manifolds: &'a [Manifold],
    impulses: &'a mut [ContactImpulses],
}

/// Number of pairs that one thread stores at a time.
const SHARE: usize = 512;

impl Columns<'_> {
    /// Stores the pairs that were gathered, and counts them.
    fn each(self, store: impl Fn(Stored)) -> usize {
        let mut found = 0;
        let rows = self.impulses.iter_mut().zip(self.pairs);
        let rows = rows.zip(self.manifolds).zip(self.entities);
        for (((impulses, pair), manifold), &entity) in rows {
            let Some(&place) = self.by_edge.get(pair.edge as usize) else {
                continue;
            };
            let Some(slot) = self.slots.get(place as usize) else {
                continue;
            };
            if slot.pair != entity {
                continue;
            }
            found += 1;
            store(Stored {
                place,
                island: slot.island,
                renewed: slot.revision != Some(pair.revision),
                manifold,
                impulses,
            });
        }
        found
    }

    /// As [`Self::each`], on several threads, by dividing the rows in halves.
    fn share(self, store: &(impl Fn(Stored) + Sync)) -> usize {
        if self.pairs.len() <= SHARE {
            return self.each(store);
        }
        let middle = self.pairs.len() / 2;
        let (entities, other_entities) = self.entities.split_at(middle);
        let (pairs, other_pairs) = self.pairs.split_at(middle);
        let (manifolds, other_manifolds) = self.manifolds.split_at(middle);
        let (impulses, other_impulses) = self.impulses.split_at_mut(middle);
        let one = Columns {
            entities,
            pairs,
            manifolds,
            impulses,
            ..self
        };
        let other = Columns {
            by_edge: self.by_edge,
            slots: self.slots,
            entities: other_entities,
            pairs: other_pairs,
            manifolds: other_manifolds,
            impulses: other_impulses,
        };
        let (one, other) = rayon::join(|| one.share(store), || other.share(store));
        one + other
    }
}

/// Empties a list and reuses its memory for items of the same layout that have another lifetime; collecting in place does that.
fn reuse<A, B>(mut list: Vec<A>) -> Vec<B> {
    list.clear();
    list.into_iter()
        .map(|_| unreachable!("it is empty"))
        .collect()
}

/// Moves each item to its place.
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
    fn items_move_to_their_places() {
        let mut places = [3, 0, 2, 4, 1];
        let mut items = places;
        put_in_place(&mut items, &mut places);
        assert_eq!(items, [0, 1, 2, 3, 4]);
    }
}
