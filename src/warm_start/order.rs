//! The order in which bodies and contacts are solved. Each island has an order of its own, which is computed when the island changes and
//! kept otherwise: a contact that begins costs other islands nothing. In a large island it is inserted into the order
//! ([`edits`](super::edits)). The islands follow each other by their numbers.
//!
//! The contacts are the links of the constraint graph between bodies that are solved. A pair is identified by the number of its edge and by
//! its entity, not by its position in a query: a system between two stages may move pairs into other tables, for example by inserting a
//! component.

use super::Pairs;
use super::contact::SolverContact;
use crate::body::{BodyState, BodyTable, SpawnOrder, cover};
use crate::graph::{ConstraintGraph, EdgeKind, Islands};
use crate::pair::{ContactImpulses, ContactPair, Manifold, Part, revise_edited};
use crate::revision::Revision;
use crate::settings::PhysicsThreads;
use crate::solver::{join::join, sort};
use bevy_ecs::change_detection::ContiguousMut;
use bevy_ecs::entity::Entity;
use smallvec::SmallVec;
use std::ops::Range;

/// The bodies and contacts that are solved, in order.
#[derive(Default)]
pub(crate) struct Order {
    /// [Revision](crate::revision) of all islands; `None` if nothing of the order is valid.
    derived_from: Option<Revision>,
    /// By identity of an island.
    pub(super) islands: Vec<IslandOrder>,
    /// Number of edits so far.
    #[cfg(test)]
    pub(super) edits: usize,
    /// Identities of islands, by number.
    numbered: Vec<u32>,
    /// By slot: the index of the body in the problem of its island; `u32::MAX` if it is in none.
    pub local: Vec<u32>,
    /// By number of an edge: its place in the order.
    pub(super) by_edge: Vec<Place>,
    /// Scratch: changed bodies, as the identities of their islands and their slots, sorted.
    pub(super) changed: Vec<(u32, u32)>,
    /// Scratch: the contacts of a body with lower bodies, each with its rank.
    pub(super) lower: Vec<(u64, OrderSlot)>,
    /// Scratch.
    ranked: Vec<((u32, SpawnOrder), Member)>,
    /// Scratch: by contact, in order, the row of its pair.
    rows: Vec<PairRow>,
    /// Memory for the contacts of the next step.
    spare: Vec<SolverContact<'static>>,
}

/// The bodies and contacts of one island, in order.
#[derive(Default)]
pub(crate) struct IslandOrder {
    /// [Revision](crate::revision) of the island.
    pub(super) derived_from: Option<Revision>,
    /// Revision of this order.
    pub revision: Revision,
    /// The number of the island; `u32::MAX` if it has none.
    number: u32,
    /// Index of its first contact among those of all islands.
    first: u32,
    /// Dynamic bodies, sorted by rank.
    pub bodies: Vec<Member>,
    /// Contacts, sorted by their higher body, then by their lower body, so that all supports of a brick are visited together. Static and
    /// kinematic bodies are lower than all others; they are sorted by spawn order.
    pub(super) slots: Vec<OrderSlot>,
}

/// The place of a contact in the order: the identity of its island, and its index in that.
#[derive(Clone, Copy)]
pub(super) struct Place {
    island: u32,
    index: u32,
}

/// Lists whose memory is kept from step to step are shortened when they need less than this share of it.
const MAX_UNUSED_FACTOR: usize = 8;

/// The edge is not solved.
pub(super) const NOWHERE: Place = Place {
    island: u32::MAX,
    index: 0,
};

/// The slot of a contact in the order.
#[derive(Clone, Copy)]
pub(super) struct OrderSlot {
    pub pair: Entity,
    pub edge: u32,
    /// The index of the higher of its two bodies.
    pub higher: u32,
    /// Revision of the pair when it was last gathered.
    revision: Option<Revision>,
}

/// The row of a pair, and the number of its table among those that the query yields in this step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct PairRow {
    table: u32,
    row: u32,
}

impl PairRow {
    /// The pair is missing.
    const NONE: Self = Self {
        table: u32::MAX,
        row: 0,
    };
}

/// A body of an island.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Member {
    pub slot: u32,
    pub entity: Entity,
}

/// The data from which an order is computed.
pub(super) struct Source<'a> {
    pub table: &'a BodyTable,
    pub graph: &'a ConstraintGraph,
    pub islands: &'a Islands,
}

impl Order {
    /// Brings the order of the awake islands up to date.
    pub fn keep(&mut self, table: &BodyTable, graph: &ConstraintGraph, islands: &Islands) {
        if self.derived_from != Some(islands.revision()) || !table.removed.is_empty() {
            self.find(table, graph, islands, |_, body| body.is_awake());
        }
    }

    /// Computes the order of the bodies that are to be solved: of each island, either all bodies or none. Only islands whose revision has
    /// changed are ordered anew.
    pub fn find(
        &mut self,
        table: &BodyTable,
        graph: &ConstraintGraph,
        islands: &Islands,
        is_solved: impl Fn(usize, &BodyState) -> bool,
    ) {
        if self.derived_from.is_none() {
            self.islands.clear();
            self.numbered.clear();
            self.local.clear();
            self.by_edge.clear();
        }
        let before = self.derived_from.replace(islands.revision());
        cover(&mut self.local, table.slots(), u32::MAX);
        cover(&mut self.by_edge, graph.edge_numbers(), NOWHERE);
        let source = Source {
            table,
            graph,
            islands,
        };
        self.list_changed(before, &source);
        self.take_out_changed(&source, &is_solved);
        self.numbered.clear();
        self.numbered.extend_from_slice(islands.numbered());
        let mut first = 0;
        for number in 0..self.numbered.len() {
            let id = self.numbered[number];
            if self.islands[id as usize].derived_from.is_none() {
                self.order_bodies(id, &source, |body| is_solved(number, body));
                self.order_contacts(id, &source);
            }
            let island = &mut self.islands[id as usize];
            (island.number, island.first) = (number as u32, first);
            first += island.slots.len() as u32;
        }
    }

    /// Discards the order, because other code has solved the islands.
    fn forget(&mut self) {
        self.derived_from = None;
    }

    /// Edits islands of which only contacts have changed. Takes the bodies and contacts of other islands that have changed, or are gone,
    /// out of the order.
    fn take_out_changed(&mut self, from: &Source, is_solved: &impl Fn(usize, &BodyState) -> bool) {
        let islands = from.islands;
        let count = islands.ids().max(self.islands.len());
        self.islands.resize_with(count, IslandOrder::none);
        let mut edited: SmallVec<[u32; 4]> = SmallVec::new();
        // Only islands that had a number have an order. There may be many more, asleep.
        for at in 0..self.numbered.len() {
            let id = self.numbered[at];
            let island = &mut self.islands[id as usize];
            island.number = u32::MAX;
            let revision = islands.revision_of_id(id);
            if revision.is_none() {
                // It fell asleep or is gone: its lists would be kept for as long as there are identities.
                self.take_out(id);
                self.islands[id as usize] = IslandOrder::none();
                continue;
            }
            if island.derived_from == revision {
                continue;
            }
            match self.can_edit(id, from, &is_solved) {
                true => edited.push(id),
                false => self.take_out(id),
            }
        }
        // Bodies of islands that were taken out may be static by now.
        for id in edited {
            self.edit(id, from);
        }
        // Bodies that were removed from the table since the islands were updated, because their input is invalid.
        for &slot in &from.table.removed {
            let neighbours = from.graph.links_of(slot).flat_map(|link| link.slots);
            for id in neighbours.chain([slot]).filter_map(|slot| islands.id(slot)) {
                self.take_out(id);
            }
        }
    }

    fn take_out(&mut self, id: u32) {
        let island = &mut self.islands[id as usize];
        if island.derived_from.take().is_some() {
            for member in &island.bodies {
                self.local[member.slot as usize] = u32::MAX;
            }
            for slot in island.slots.drain(..) {
                self.by_edge[slot.edge as usize] = NOWHERE;
            }
        }
    }

    fn order_bodies(&mut self, id: u32, from: &Source, is_solved: impl Fn(&BodyState) -> bool) {
        let Source { table, islands, .. } = *from;
        let island = &mut self.islands[id as usize];
        island.derived_from = islands.revision_of_id(id);
        island.revision = Revision::next();
        let rank = |slot: u32| {
            let body = table.get(slot).filter(|body| is_solved(body));
            let body = body.filter(|_| !table.is_inactive(slot))?;
            let entity = body.entity;
            Some((islands.rank(slot, body), Member { slot, entity }))
        };
        let members = islands.members_of_id(id);
        let is_member = |member: &Member| islands.id(member.slot) == Some(id);
        self.ranked.clear();
        // If the island has the bodies that it had before, they are nearly sorted, and sorting them again costs little.
        match island.bodies.len() == members.len() && island.bodies.iter().all(is_member) {
            true => {
                let before = island.bodies.iter();
                self.ranked
                    .extend(before.filter_map(|member| rank(member.slot)));
            }
            false => {
                let members = members.iter();
                self.ranked.extend(members.filter_map(|&slot| rank(slot)));
            }
        }
        sort::by_key(&mut self.ranked, |&(rank, _)| rank);
        island.bodies.clear();
        for (local, &(_, member)) in (0..).zip(&self.ranked) {
            self.local[member.slot as usize] = local;
            island.bodies.push(member);
        }
    }

    fn order_contacts(&mut self, id: u32, from: &Source) {
        for local in 0..self.islands[id as usize].bodies.len() as u32 {
            self.sort_contacts_of(id, local, from);
            let lower = self.lower.iter().map(|&(_, slot)| slot);
            self.islands[id as usize].slots.extend(lower);
        }
        number_edges(&mut self.by_edge, id, 0, &self.islands[id as usize].slots);
    }

    /// Finds the contacts of a body with lower bodies, in order, as [`Self::lower`].
    pub(super) fn sort_contacts_of(&mut self, id: u32, higher: u32, from: &Source) {
        const MOVES: u64 = 1 << 63;
        let body = self.islands[id as usize].bodies[higher as usize];
        // A contact is taken once, from the list of its higher body.
        let links = from.graph.links_of(body.slot);
        let links = links.filter(|link| link.kind == EdgeKind::Contact);
        self.lower.clear();
        self.lower.extend(links.filter_map(|link| {
            let other = link.other(body.slot);
            let rank = match self.local[other as usize] {
                u32::MAX => from.table.get(other)?.spawn_order.0 & !MOVES,
                other => MOVES | other as u64,
            };
            let slot = OrderSlot {
                pair: link.pair,
                edge: link.edge,
                higher,
                revision: None,
            };
            (rank < (MOVES | u64::from(higher))).then_some((rank, slot))
        }));
        sort::by_key(&mut self.lower, |&(rank, _)| rank);
    }

    /// The identities of islands, by number.
    pub fn numbered(&self) -> &[u32] {
        &self.numbered
    }

    /// The number of an island, or `None` if it has none any more.
    pub fn number(&self, id: u32) -> Option<u32> {
        let island = self.islands.get(id as usize)?;
        (island.number != u32::MAX).then_some(island.number)
    }

    /// The order of an island, by its number.
    pub fn of(&self, number: usize) -> &IslandOrder {
        &self.islands[self.numbered[number] as usize]
    }

    /// The contacts in order. The flag is false if some are missing, because their pairs were removed since the islands were updated.
    pub fn contacts<'a>(
        &mut self,
        pairs: &'a mut Pairs,
        (table, graph): (&'a BodyTable, &ConstraintGraph),
    ) -> (Vec<SolverContact<'a>>, bool) {
        let count = self.contact_count();
        self.rows.clear();
        self.rows.resize(count, PairRow::NONE);
        let mut found = 0;
        let mut gathered: SmallVec<[_; 2]> = SmallVec::new();
        let tables = pairs.columns.contiguous_iter_mut();
        for (entities, mut columns) in tables.expect("pair components are stored in tables") {
            let runs = graph.active_rows(entities, pairs.places);
            for rows in &*runs {
                let (mut pairs, _, manifolds, impulses, ..) = columns.part(rows);
                revise_edited!(pairs, pairs, manifolds, impulses);
            }
            let (pairs, _, manifolds, impulses, _, targets) = columns;
            let pairs = values(pairs);
            for row in runs.iter().cloned().flatten() {
                let here = row as usize;
                let pair = &pairs[here];
                let Some(&at) = self.by_edge.get(pair.edge as usize) else {
                    continue;
                };
                let Some(island) = self.islands.get_mut(at.island as usize) else {
                    continue;
                };
                let slot = &mut island.slots[at.index as usize];
                if slot.pair != entities[here] {
                    continue;
                }
                slot.revision = Some(pair.revision);
                let table = gathered.len() as u32;
                self.rows[(island.first + at.index) as usize] = PairRow { table, row };
                found += 1;
            }
            gathered.push((pairs, values(manifolds), values(targets), values(impulses)));
        }
        let complete = found == count;
        if !complete {
            self.leave_out_missing();
        }
        let mut contacts = reuse(std::mem::take(&mut self.spare));
        contacts.extend(self.rows.iter().map(|at| {
            let (pairs, manifolds, targets, impulses) = gathered[at.table as usize];
            let row = at.row as usize;
            SolverContact {
                pair: &pairs[row],
                manifold: &manifolds[row],
                targets: &targets[row],
                impulses: &impulses[row],
                table,
            }
        }));
        (contacts, complete)
    }

    /// Number of bodies of all islands.
    pub fn bodies(&self) -> usize {
        let islands = self.numbered.iter();
        islands
            .map(|&id| self.islands[id as usize].bodies.len())
            .sum()
    }

    /// Number of contacts of all islands.
    fn contact_count(&self) -> usize {
        let last = self.numbered.last();
        let last = last.map(|&id| &self.islands[id as usize]);
        last.map_or(0, |last| last.first as usize + last.slots.len())
    }

    /// Removes missing pairs from the order, which is then valid for this step only.
    fn leave_out_missing(&mut self) {
        self.forget();
        self.by_edge.fill(NOWHERE);
        let mut first = 0;
        for &id in &self.numbered {
            let island = &mut self.islands[id as usize];
            let mut rows = self.rows[island.first as usize..].iter();
            island
                .slots
                .retain(|_| rows.next().is_some_and(|row| *row != PairRow::NONE));
            island.first = first;
            first += island.slots.len() as u32;
            number_edges(&mut self.by_edge, id, 0, &island.slots);
        }
        self.rows.retain(|row| *row != PairRow::NONE);
    }

    /// Takes back the memory of a list.
    pub fn take_back(&mut self, contacts: Vec<SolverContact>) {
        let count = contacts.len();
        self.spare = reuse(contacts);
        // The memory of a large structure is given back after it has fallen asleep.
        if count < self.spare.capacity() / MAX_UNUSED_FACTOR {
            self.spare.shrink_to(count);
            self.rows.shrink_to(count);
            self.ranked = Vec::new();
        }
    }

    /// Calls `store` for each pair that was gathered and still exists, with its impulses; in parallel if `threads` are given.
    pub fn store_each(
        &mut self,
        pairs: &mut Pairs,
        graph: &ConstraintGraph,
        threads: Option<&PhysicsThreads>,
        store: impl Fn(Stored) + Sync,
    ) {
        let mut found = 0;
        let tables = pairs.columns.contiguous_iter_mut();
        for (entities, columns) in tables.expect("pair components are stored in tables") {
            let (pairs_in_it, _, manifolds, impulses, ..) = columns;
            let (pairs_in_it, manifolds) = (values(pairs_in_it), values(manifolds));
            let (mut impulses, _) = ContiguousMut::bypass_change_detection_split(impulses);
            let mut taken = 0;
            for rows in &*graph.active_rows(entities, pairs.places) {
                let range = rows.start as usize..rows.end as usize;
                let columns = Columns {
                    by_edge: &self.by_edge,
                    islands: &self.islands,
                    entities: &entities[range.clone()],
                    pairs: &pairs_in_it[range.clone()],
                    manifolds: &manifolds[range],
                    impulses: take_rows(&mut impulses, &mut taken, rows),
                };
                found += match threads {
                    Some(threads) => threads.run(usize::MAX, || columns.share(&store)),
                    None => columns.each(&store),
                };
            }
        }
        if found < self.contact_count() {
            self.forget();
        }
    }
}

/// The values of a column, for reading.
fn values<T>(column: ContiguousMut<'_, T>) -> &[T] {
    let (values, _) = ContiguousMut::bypass_change_detection_split(column);
    values
}

impl IslandOrder {
    /// The order of an island without a number.
    fn none() -> Self {
        Self {
            number: u32::MAX,
            ..Default::default()
        }
    }

    /// Number of contacts.
    pub fn contacts(&self) -> usize {
        self.slots.len()
    }

    /// The pairs of the contacts.
    pub fn pairs(&self) -> impl Iterator<Item = Entity> {
        self.slots.iter().map(|slot| slot.pair)
    }
}

/// Stores the places of the contacts of an island from index `first` on.
pub(super) fn number_edges(by_edge: &mut [Place], island: u32, first: usize, slots: &[OrderSlot]) {
    for (index, slot) in (first as u32..).zip(&slots[first..]) {
        by_edge[slot.edge as usize] = Place { island, index };
    }
}

/// A pair that was gathered, and the component to store its impulses in.
pub(crate) struct Stored<'a> {
    /// The number of its island.
    pub island: u32,
    /// Its index in the island.
    pub contact: u32,
    /// Whether its contacts were detected again after it was gathered.
    pub renewed: bool,
    pub manifold: &'a Manifold,
    pub impulses: &'a mut ContactImpulses,
}

/// Columns of a table of pairs, or a range of their rows.
struct Columns<'a> {
    by_edge: &'a [Place],
    islands: &'a [IslandOrder],
    entities: &'a [Entity],
    pairs: &'a [ContactPair],
    manifolds: &'a [Manifold],
    impulses: &'a mut [ContactImpulses],
}

/// Number of pairs that one thread stores at a time.
const PAIRS_PER_TASK: usize = 512;

impl Columns<'_> {
    /// Stores the pairs that were gathered, and counts them.
    fn each(self, store: impl Fn(Stored)) -> usize {
        let mut found = 0;
        let rows = self.impulses.iter_mut().zip(self.pairs);
        let rows = rows.zip(self.manifolds).zip(self.entities);
        for (((impulses, pair), manifold), &entity) in rows {
            let Some(&at) = self.by_edge.get(pair.edge as usize) else {
                continue;
            };
            let Some(island) = self.islands.get(at.island as usize) else {
                continue;
            };
            let slot = &island.slots[at.index as usize];
            if slot.pair != entity {
                continue;
            }
            found += 1;
            store(Stored {
                island: island.number,
                contact: at.index,
                renewed: slot.revision != Some(pair.revision),
                manifold,
                impulses,
            });
        }
        found
    }

    /// As [`Self::each`], on several threads, by dividing the rows in halves.
    fn share(self, store: &(impl Fn(Stored) + Sync)) -> usize {
        if self.pairs.len() <= PAIRS_PER_TASK {
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
            islands: self.islands,
            entities: other_entities,
            pairs: other_pairs,
            manifolds: other_manifolds,
            impulses: other_impulses,
        };
        let (mut found, mut others) = (0, 0);
        join(|| found = one.share(store), || others = other.share(store));
        found + others
    }
}

/// Takes a range of rows out of a column, of which the first `taken` rows were taken before. Ranges follow each other.
fn take_rows<'a, T>(column: &mut &'a mut [T], taken: &mut usize, rows: &Range<u32>) -> &'a mut [T] {
    let rest = std::mem::take(column);
    let (_, rest) = rest.split_at_mut(rows.start as usize - *taken);
    let (these, rest) = rest.split_at_mut(rows.len());
    *column = rest;
    *taken = rows.end as usize;
    these
}

/// Empties a list and reuses its memory for items of the same layout that have another lifetime; collecting in place does that.
fn reuse<A, B>(mut list: Vec<A>) -> Vec<B> {
    list.clear();
    list.into_iter()
        .map(|_| unreachable!("it is empty"))
        .collect()
}

#[cfg(test)]
mod tests;
