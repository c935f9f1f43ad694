//! Edges, and the adjacency of bodies: which pairs exist, and which of them link their bodies.
//!
//! Invariants:
//! - An edge is identified by its number and its entity. There is at most one contact between two bodies ([`ConstraintGraph::unknown`]),
//!   and there may be several joints.
//! - One end of an edge may be the world ([`WORLD`]), which has no slot and no node.
//! - An edge appears once in the list of each of its two bodies. In each list the edges that *link* come first.
//! - Every change is recorded in [`Changes`] until [`Islands`](super::Islands) takes it over. So the cost of updating islands and levels is
//!   proportional to the number of changes.
//!
//! The cost of every operation depends only on the number of neighbours of the bodies involved, not on the size of the graph.

use super::active::ActiveRows;
use crate::body::{WORLD, make_room};
use crate::solver::{Both, sort};
use crate::stored::{clone_fields, copy, copy_into};
use bevy_ecs::entity::{EntityMapper, MapEntities};
use bevy_ecs::prelude::*;
use smallvec::SmallVec;
use std::fmt;

/// The kind of constraint of an edge. To add a kind, add a variant, document it, and insert and remove its edges where its components are
/// added and removed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) enum EdgeKind {
    /// Two bodies whose boxes overlap: a [`ContactPair`](crate::contact::ContactPair). It links them while its manifold has points.
    Contact,
    /// A [joint](crate::joint). It links its bodies as long as it exists.
    Joint,
}

impl EdgeKind {
    /// Whether the entity of an edge becomes inactive after its two bodies.
    fn may_rest(self) -> bool {
        match self {
            Self::Contact => true,
            // Stages find joints through the order of awake islands, so inactive ones cost nothing.
            Self::Joint => false,
        }
    }
}

/// An edge that links its two bodies: something to solve acts between them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Link {
    pub kind: EdgeKind,
    /// Slots of bodies A and B.
    pub slots: [u32; 2],
    /// The entity that holds the components of the edge.
    pub pair: Entity,
    /// The number of the edge. It is constant as long as the edge exists.
    pub edge: u32,
}

impl Link {
    /// The slot of the body at the other end.
    pub fn other(&self, slot: u32) -> u32 {
        let [a, b] = self.slots;
        if a == slot { b } else { a }
    }
}

#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Edge {
    kind: EdgeKind,
    exists: bool,
    links: bool,
    slots: [u32; 2],
    entity: Entity,
    /// Index of the edge in the list of each body.
    places: [u32; 2],
    /// Index in the list of active contacts; [`INACTIVE`] if it is not there.
    active: u32,
}

/// The edge is an inactive contact, or no contact.
const INACTIVE: u32 = u32::MAX;

impl Edge {
    /// The end (0 or 1) at which the body with this slot is.
    fn end(&self, slot: u32) -> usize {
        usize::from(self.slots[0] != slot)
    }
}

/// The edges of one body.
#[derive(Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Node {
    /// As many as a brick in a wall has are stored in the node itself.
    edges: SmallVec<[u32; 8]>,
    /// Number of linking edges; they come first.
    links: u32,
}

/// Copies the list as a block: there is one for each body.
impl Clone for Node {
    fn clone(&self) -> Self {
        Self {
            edges: copy(&self.edges),
            links: self.links,
        }
    }

    fn clone_from(&mut self, from: &Self) {
        copy_into(&mut self.edges, &from.edges);
        self.links = from.links;
    }
}

/// Changes of the graph since the last update of the islands.
#[derive(Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Changes {
    /// Slots of the two bodies, for each edge that began to link.
    pub linked: Vec<[u32; 2]>,
    /// Slots of the two bodies, for each edge that ceased to link or was removed.
    pub unlinked: Vec<[u32; 2]>,
    /// Slots of bodies that were removed from the table. They have no edges left.
    pub gone: Vec<u32>,
}

clone_fields!(Changes {
    linked,
    unlinked,
    gone,
});

impl Changes {
    pub fn is_empty(&self) -> bool {
        self.linked.is_empty() && self.unlinked.is_empty() && self.gone.is_empty()
    }
}

/// The constraint graph: bodies by slot, and the edges between them. See the [module](super).
#[derive(Resource, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[component(map_entities)]
pub struct ConstraintGraph {
    edges: Vec<Edge>,
    /// Number of edges that are contacts.
    contacts: usize,
    free: Vec<u32>,
    /// By slot.
    nodes: Vec<Node>,
    pub(super) changes: Changes,
    /// Slots of bodies of which a touching pair was removed, since the last update of the islands.
    pub(super) parted: Vec<u32>,
    /// Edges whose contact may have gained its first point or lost its last, and whether their bodies have parted.
    reported: Vec<(u32, bool)>,
    /// Edges whose bodies are both inactive, so that the edge may become inactive too.
    pub(super) settling: Vec<(u32, Entity)>,
    /// Numbers of the contacts that the stages visit.
    active: Vec<u32>,
    /// Derived from `active`, unless the flag says that it has changed.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub(super) active_rows: ActiveRows,
    pub(super) active_rows_changed: bool,
}

clone_fields!(ConstraintGraph {
    edges,
    contacts,
    free,
    nodes,
    changes,
    parted,
    reported,
    settling,
    active,
    active_rows,
    active_rows_changed,
});

/// Without the active rows, which are derived from the places of entities in a world.
impl fmt::Debug for ConstraintGraph {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("ConstraintGraph")
            .field("edges", &self.edges)
            .field("contacts", &self.contacts)
            .field("free", &self.free)
            .field("nodes", &self.nodes)
            .field("changes", &self.changes)
            .field("parted", &self.parted)
            .field("reported", &self.reported)
            .field("settling", &self.settling)
            .field("active", &self.active)
            .finish_non_exhaustive()
    }
}

impl MapEntities for ConstraintGraph {
    fn map_entities<M: EntityMapper>(&mut self, mapper: &mut M) {
        for edge in self.edges.iter_mut().filter(|edge| edge.exists) {
            edge.entity.map_entities(mapper);
        }
        for (_, entity) in &mut self.settling {
            entity.map_entities(mapper);
        }
        self.active_rows_changed = true;
    }
}

impl ConstraintGraph {
    /// The pairs that the stages visit: all but those of two [inactive](crate::body::Inactive) bodies. A pair becomes inactive in the step
    /// after its bodies.
    pub fn active_pairs(&self) -> impl ExactSizeIterator<Item = Entity> {
        let edges = self.active.iter();
        edges.map(|&edge| self.edges[edge as usize].entity)
    }

    /// Number of inactive pairs.
    pub(super) fn inactive_count(&self) -> usize {
        self.contacts - self.active.len()
    }

    /// Returns true if the stages visit the pair with this edge.
    pub(crate) fn is_active(&self, edge: u32) -> bool {
        let edge = self.edges.get(edge as usize);
        edge.is_some_and(|edge| edge.exists && edge.active != INACTIVE)
    }

    /// Makes the pair of an existing edge active or inactive.
    pub(super) fn set_active(&mut self, edge: u32, active: bool) {
        let at = self.edges[edge as usize].active;
        if (at != INACTIVE) == active {
            return;
        }
        self.active_rows_changed = true;
        if active {
            self.edges[edge as usize].active = self.active.len() as u32;
            self.active.push(edge);
        } else {
            self.edges[edge as usize].active = INACTIVE;
            self.active.swap_remove(at as usize);
            if let Some(&moved) = self.active.get(at as usize) {
                self.edges[moved as usize].active = at;
            }
        }
    }

    /// Makes the contacts of a body active.
    pub(super) fn activate_contacts_of(&mut self, slot: u32) {
        for at in 0..self
            .nodes
            .get(slot as usize)
            .map_or(0, |node| node.edges.len())
        {
            let edge = self.nodes[slot as usize].edges[at];
            if self.edges[edge as usize].kind == EdgeKind::Contact {
                self.set_active(edge, true);
            }
        }
    }

    /// Number of edges.
    pub fn edge_count(&self) -> usize {
        self.edges.len() - self.free.len()
    }

    /// Returns true if there are edges of kinds of which there may be several between two bodies: joints.
    pub(crate) fn has_joints(&self) -> bool {
        self.edge_count() > self.contacts
    }

    /// The entities of a body's edges.
    pub(crate) fn edges_of(&self, slot: u32) -> impl ExactSizeIterator<Item = Entity> {
        let node = self.nodes.get(slot as usize);
        let edges = node.map_or(&[][..], |node| &node.edges);
        edges.iter().map(|&edge| self.edges[edge as usize].entity)
    }

    /// The entities of a body's edges of one kind.
    pub(crate) fn edges_of_kind(&self, slot: u32, kind: EdgeKind) -> impl Iterator<Item = Entity> {
        let node = self.nodes.get(slot as usize);
        let edges = node.map_or(&[][..], |node| &node.edges);
        let edges = edges.iter().map(|&edge| &self.edges[edge as usize]);
        edges
            .filter(move |edge| edge.kind == kind)
            .map(|edge| edge.entity)
    }

    /// The edges that link a body to others.
    pub(crate) fn links_of(&self, slot: u32) -> Links<'_> {
        Links {
            graph: self,
            edges: self.linked_edges(slot).iter(),
        }
    }

    /// All edges of a body, with whether they link it.
    pub(crate) fn edges_at(&self, slot: u32) -> impl Iterator<Item = (Link, bool)> {
        let node = self.nodes.get(slot as usize);
        let edges = node.map_or(&[][..], |node| &node.edges);
        edges.iter().map(|&edge| {
            let Edge {
                kind,
                links,
                slots,
                entity,
                ..
            } = self.edges[edge as usize];
            let link = Link {
                kind,
                slots,
                pair: entity,
                edge,
            };
            (link, links)
        })
    }

    /// The slots of the bodies that a body is linked to, [`WORLD`] included.
    pub(super) fn neighbours(&self, slot: u32) -> Neighbours<'_> {
        Neighbours {
            slot,
            links: self.links_of(slot),
        }
    }

    fn linked_edges(&self, slot: u32) -> &[u32] {
        let node = self.nodes.get(slot as usize);
        node.map_or(&[], |node| &node.edges[..node.links as usize])
    }

    /// Upper bound of edge numbers: all numbers in use are below it.
    pub(crate) fn edge_numbers(&self) -> usize {
        self.edges.len()
    }

    /// Adds an edge that does not link yet and returns its number. [`Self::name`] sets its entity later. There must be no contact between
    /// the two bodies yet if the edge is one.
    pub(crate) fn insert(&mut self, kind: EdgeKind, slots: [u32; 2]) -> u32 {
        let number = match self.free.pop() {
            Some(free) => free,
            None => self.edges.len() as u32,
        };
        let bodies = slots.into_iter().filter(|&slot| slot != WORLD);
        let last = bodies.max().unwrap_or(0) as usize;
        if self.nodes.len() <= last {
            self.nodes.resize_with(last + 1, Node::default);
        }
        let places = slots.both(|slot| {
            if slot == WORLD {
                return 0;
            }
            let list = &mut self.nodes[slot as usize].edges;
            list.push(number);
            list.len() as u32 - 1
        });
        let edge = Edge {
            kind,
            exists: true,
            links: false,
            slots,
            entity: Entity::PLACEHOLDER,
            places,
            active: INACTIVE,
        };
        match self.edges.get_mut(number as usize) {
            Some(free) => *free = edge,
            None => self.edges.push(edge),
        }
        if kind == EdgeKind::Contact {
            self.contacts += 1;
            self.set_active(number, true);
        }
        number
    }

    /// Makes room for new edges between so many slots, so that inserting many at once moves the lists only once.
    pub(crate) fn reserve(&mut self, count: usize, slots: usize) {
        let edges = self.edges.len() + count.saturating_sub(self.free.len());
        make_room(&mut self.edges, edges);
        make_room(&mut self.nodes, slots);
    }

    /// Drops the list of links that began: the islands have taken them over.
    pub(crate) fn forget_linked(&mut self) {
        self.changes.linked = Vec::new();
    }

    /// Leaves out the overlaps between whose bodies there is a contact already. Overlaps of one body should follow each other.
    ///
    /// The contacts of the body with fewer edges are compared one by one. If both have many, those of one of them are marked first, and
    /// the marks are kept for the overlaps that follow: a thousand bricks in one place overlap in half a million pairs.
    pub(super) fn unknown(
        &self,
        overlaps: impl Iterator<Item = [u32; 2]>,
    ) -> impl Iterator<Item = [u32; 2]> {
        /// From this number of edges on they are marked.
        const MIN_MARKED_EDGES: usize = 32;
        let mut marked = None;
        // By slot: the body whose contact with this one was marked last.
        let mut marks: Vec<u32> = Vec::new();
        overlaps.filter(move |&[a, b]| {
            let counts = [a, b].both(|slot| self.edges_of(slot).len());
            if counts[0].min(counts[1]) < MIN_MARKED_EDGES {
                return !self.has_contact([a, b]);
            }
            let of = match marked {
                Some(slot) if slot == a || slot == b => slot,
                _ => {
                    marks.resize(self.nodes.len(), WORLD);
                    for edge in self.contacts_of(a) {
                        marks[edge.slots[1 - edge.end(a)] as usize] = a;
                    }
                    *marked.insert(a)
                }
            };
            let other = if of == a { b } else { a };
            marks[other as usize] != of
        })
    }

    /// The entities of a body's contacts, each with the slots of its bodies.
    pub(super) fn contact_ends(&self, slot: u32) -> impl Iterator<Item = (Entity, [u32; 2])> {
        self.contacts_of(slot).map(|edge| (edge.entity, edge.slots))
    }

    /// The contacts of a body.
    fn contacts_of(&self, slot: u32) -> impl Iterator<Item = &Edge> {
        let node = self.nodes.get(slot as usize);
        let edges = node.map_or(&[][..], |node| &node.edges);
        let edges = edges.iter().map(|&edge| &self.edges[edge as usize]);
        edges.filter(|edge| edge.kind == EdgeKind::Contact)
    }

    /// Adds the edge of an inactive pair, like [`Self::insert`].
    pub(crate) fn insert_inactive(&mut self, slots: [u32; 2]) -> u32 {
        let edge = self.insert(EdgeKind::Contact, slots);
        self.set_active(edge, false);
        edge
    }

    /// Returns true if there is a contact between the two bodies. It is found in the list of the body with fewer edges: the ground of a
    /// town has those of all its walls.
    pub(crate) fn has_contact(&self, slots: [u32; 2]) -> bool {
        let fewer = slots
            .into_iter()
            .min_by_key(|&slot| self.edges_of(slot).len());
        fewer.is_some_and(|slot| self.contacts_of(slot).any(|edge| edge.slots == slots))
    }

    /// Sets the entity of an edge.
    pub(crate) fn name(&mut self, edge: u32, entity: Entity) {
        self.edges[edge as usize].entity = entity;
    }

    /// The entity of an edge, or `None` if the edge does not exist.
    pub(super) fn entity(&self, edge: u32) -> Option<Entity> {
        let known = self.edges.get(edge as usize)?;
        known.exists.then_some(known.entity)
    }

    /// Removes the edge with this number if it still belongs to this entity.
    pub(crate) fn remove(&mut self, edge: u32, entity: Entity) {
        if self.entity(edge) != Some(entity) {
            return;
        }
        self.set_links(edge, false);
        self.set_active(edge, false);
        let Edge {
            kind,
            slots,
            places,
            ..
        } = self.edges[edge as usize];
        self.contacts -= usize::from(kind == EdgeKind::Contact);
        self.edges[edge as usize].exists = false;
        self.free.push(edge);
        for (slot, place) in slots.into_iter().zip(places) {
            if slot == WORLD {
                continue;
            }
            let list = &mut self.nodes[slot as usize].edges;
            list.swap_remove(place as usize);
            if let Some(&moved) = list.get(place as usize) {
                let moved = &mut self.edges[moved as usize];
                moved.places[moved.end(slot)] = place;
            }
        }
    }

    /// Sets whether an existing edge links its bodies.
    pub(crate) fn set_links(&mut self, edge: u32, links: bool) {
        let Edge {
            links: linked,
            slots,
            ..
        } = self.edges[edge as usize];
        if linked == links {
            return;
        }
        self.edges[edge as usize].links = links;
        for slot in slots.into_iter().filter(|&slot| slot != WORLD) {
            let node = &mut self.nodes[slot as usize];
            // Swap the edge with the first that does not link, or with the last that does.
            let to = if links { node.links } else { node.links - 1 };
            node.links = if links { to + 1 } else { to };
            let to = to as usize;
            let known = self.edges[edge as usize];
            let end = known.end(slot);
            let place = known.places[end] as usize;
            node.edges.swap(place, to);
            let other = node.edges[place];
            let other = &mut self.edges[other as usize];
            other.places[other.end(slot)] = place as u32;
            self.edges[edge as usize].places[end] = to as u32;
        }
        match links {
            true => self.changes.linked.push(slots),
            false => self.changes.unlinked.push(slots),
        }
    }

    /// Notes that a contact of a body has ended because another body was removed.
    pub(crate) fn part(&mut self, slot: u32) {
        self.parted.push(slot);
    }

    /// Reports edges whose contact gained its first point or lost its last. The flag is true if the bodies have parted: they touched in the
    /// last step and no longer do.
    pub(crate) fn report(&mut self, edges: impl IntoIterator<Item = (u32, bool)>) {
        self.reported.extend(edges);
    }

    /// Reports all edges of a body, so that their contacts are checked again.
    pub(super) fn report_all_of(&mut self, slot: u32) {
        if let Some(node) = self.nodes.get(slot as usize) {
            self.reported
                .extend(node.edges.iter().map(|&edge| (edge, false)));
        }
    }

    /// Takes the reported edges, sorted by number.
    pub(super) fn take_reported(&mut self) -> Vec<(u32, bool)> {
        let mut reported = std::mem::take(&mut self.reported);
        sort::values(&mut reported);
        reported.dedup();
        reported
    }

    /// Queues the edges of a body whose other end satisfies the predicate, so that they may become inactive.
    pub(super) fn settle(&mut self, slot: u32, settles: impl Fn(u32) -> bool) {
        let Some(node) = self.nodes.get(slot as usize) else {
            return;
        };
        for &number in &node.edges {
            let edge = &self.edges[number as usize];
            if edge.kind.may_rest() && settles(edge.slots[1 - edge.end(slot)]) {
                self.settling.push((number, edge.entity));
            }
        }
    }
}

/// The edges that link a body to others.
#[derive(Clone, Debug)]
pub(crate) struct Links<'a> {
    graph: &'a ConstraintGraph,
    edges: std::slice::Iter<'a, u32>,
}

impl Iterator for Links<'_> {
    type Item = Link;

    #[inline]
    fn next(&mut self) -> Option<Link> {
        let edge = *self.edges.next()?;
        let of = &self.graph.edges[edge as usize];
        Some(Link {
            kind: of.kind,
            slots: of.slots,
            pair: of.entity,
            edge,
        })
    }

    #[inline]
    fn size_hint(&self) -> (usize, Option<usize>) {
        self.edges.size_hint()
    }
}

/// The slots of the bodies that a body is linked to.
#[derive(Clone, Debug)]
pub(super) struct Neighbours<'a> {
    slot: u32,
    links: Links<'a>,
}

impl Iterator for Neighbours<'_> {
    type Item = u32;

    #[inline]
    fn next(&mut self) -> Option<u32> {
        Some(self.links.next()?.other(self.slot))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    #[test]
    fn lists_match_the_edges_and_links_come_first() {
        let mut rng = fastrand::Rng::with_seed(3);
        let mut graph = ConstraintGraph::default();
        let mut expected: BTreeMap<[u32; 2], (u32, Entity, bool)> = BTreeMap::new();
        for number in 0..5000 {
            let a = rng.u32(0..20);
            let slots = [a, a + rng.u32(1..6)];
            match rng.u8(0..4) {
                0 => {
                    let new: Vec<_> = graph.unknown([slots].into_iter()).collect();
                    assert_eq!(new.is_empty(), expected.contains_key(&slots));
                    for slots in new {
                        let edge = graph.insert(EdgeKind::Contact, slots);
                        let entity = Entity::from_raw_u32(number).unwrap();
                        graph.name(edge, entity);
                        expected.insert(slots, (edge, entity, false));
                    }
                }
                1 => {
                    if let Some((edge, entity, _)) = expected.remove(&slots) {
                        // An edge is removed only for the entity that it belongs to.
                        graph.remove(edge, Entity::PLACEHOLDER);
                        graph.remove(edge, entity);
                        assert_eq!(graph.entity(edge), None);
                    }
                }
                _ => {
                    if let Some((edge, _, links)) = expected.get_mut(&slots) {
                        *links = rng.bool();
                        graph.set_links(*edge, *links);
                    }
                }
            }
        }
        assert_eq!(graph.edge_count(), expected.len());
        assert!(!expected.is_empty());
        for slot in 0..26 {
            let of = |(slots, _): &(&[u32; 2], &(u32, Entity, bool))| slots.contains(&slot);
            let mut found: Vec<_> = graph.edges_of(slot).collect();
            let mut wanted: Vec<_> = expected
                .iter()
                .filter(of)
                .map(|(_, known)| known.1)
                .collect();
            found.sort_unstable();
            wanted.sort_unstable();
            assert_eq!(found, wanted);
            let mut found: Vec<_> = graph.links_of(slot).map(|link| link.pair).collect();
            let links = expected.iter().filter(of).filter(|(_, known)| known.2);
            let mut wanted: Vec<_> = links.map(|(_, known)| known.1).collect();
            found.sort_unstable();
            wanted.sort_unstable();
            assert_eq!(found, wanted);
        }
    }

    #[test]
    fn contacts_are_known_in_a_crowd() {
        let mut rng = fastrand::Rng::with_seed(5);
        let mut graph = ConstraintGraph::default();
        let all: Vec<[u32; 2]> = (0..80)
            .flat_map(|a| (a + 1..80).map(move |b| [a, b]))
            .collect();
        let mut known = Vec::new();
        for &slots in all.iter().filter(|_| rng.bool()) {
            graph.insert(EdgeKind::Contact, slots);
            graph.insert(EdgeKind::Joint, slots);
            known.push(slots);
        }
        let unknown: Vec<_> = graph.unknown(all.iter().copied()).collect();
        let wanted = all.iter().filter(|slots| !known.contains(slots));
        assert!(wanted.copied().eq(unknown));
        rng.shuffle(&mut known);
        assert_eq!(graph.unknown(known.into_iter()).count(), 0);
    }

    #[test]
    fn pairs_become_active_and_inactive() {
        let mut graph = ConstraintGraph::default();
        let mut edges: Vec<u32> = Vec::new();
        for number in 0..9 {
            let edge = graph.insert(EdgeKind::Contact, [number, number + 1]);
            graph.name(edge, Entity::from_raw_u32(number).unwrap());
            edges.push(edge);
        }
        for at in [0, 4, 8, 4] {
            graph.set_active(edges[at], false);
        }
        graph.remove(edges[4], Entity::from_raw_u32(4).unwrap());
        graph.remove(edges[5], Entity::from_raw_u32(5).unwrap());
        graph.set_active(edges[8], true);
        let mut active: Vec<u32> = graph.active_pairs().map(|pair| pair.index_u32()).collect();
        active.sort_unstable();
        assert_eq!(active, [1, 2, 3, 6, 7, 8]);
        assert_eq!(graph.inactive_count(), 1);
        graph.activate_contacts_of(0);
        assert_eq!(graph.inactive_count(), 0);
        assert!(graph.is_active(edges[0]) && !graph.is_active(edges[4]));
    }

    #[test]
    fn changes_are_recorded_once() {
        let mut graph = ConstraintGraph::default();
        let edge = graph.insert(EdgeKind::Contact, [0, 1]);
        let entity = Entity::from_raw_u32(7).unwrap();
        graph.name(edge, entity);
        graph.set_links(edge, true);
        graph.set_links(edge, true);
        assert_eq!(graph.changes.linked, [[0, 1]]);
        graph.remove(edge, entity);
        graph.remove(edge, entity);
        assert_eq!(graph.changes.unlinked, [[0, 1]]);
    }
}
