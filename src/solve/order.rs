//! What is solved with what, and in which order: found when islands change, and kept while they don't.
//!
//! What touches is what *islands* found to touch. A pair is known by the number of its edge in the graph and by its entity, wherever the query
//! has it: a system between *islands* and *solve* may take pairs into other tables, by a component of its own for instance.

use super::Pairs;
use super::touch::{Touch, place};
use crate::body::{BodyState, BodyTable};
use crate::contact::is_edited;
use crate::graph::{ConstraintGraph, Islands};
use bevy_ecs::change_detection::ContiguousMut;
use bevy_ecs::entity::Entity;

/// See the module's text.
#[derive(Default)]
pub(super) struct Order {
    /// Of islands and of bodies, for which it holds.
    versions: Option<[u64; 2]>,
    /// Dynamic bodies that are solved, by island and rank.
    pub bodies: Vec<Member>,
    /// By slot: where the body stands in its island's problem; `u32::MAX` where it is in none.
    pub local: Vec<u32>,
    touches: Vec<Place>,
    /// By the number of an edge: its place in the order; `u32::MAX` where it is not solved.
    by_edge: Vec<u32>,
    /// Scratch.
    places: Vec<u32>,
    spare: Vec<Touch<'static>>,
}

/// A touch that is solved.
#[derive(Clone, Copy)]
struct Place {
    island: u32,
    pair: Entity,
    edge: u32,
    /// Of its contacts when it was solved last.
    revision: Option<u32>,
}

/// A body of an island.
#[derive(Clone, Copy)]
pub(super) struct Member {
    pub island: u32,
    pub slot: u32,
}

impl Order {
    /// Finds it anew where it does not hold any more; true where it does.
    pub fn keep(&mut self, table: &BodyTable, graph: &ConstraintGraph, islands: &Islands) -> bool {
        let versions = Some([islands.version(), table.version()]);
        if self.versions == versions {
            return true;
        }
        self.versions = versions;
        self.find(table, graph, islands, |_, body| body.is_awake());
        false
    }

    /// Finds the order of bodies that are to be solved, of which there must be all or none of an island.
    pub fn find(
        &mut self,
        table: &BodyTable,
        graph: &ConstraintGraph,
        islands: &Islands,
        is_solved: impl Fn(usize, &BodyState) -> bool,
    ) {
        self.order_bodies(table, islands, is_solved);
        self.order_touches(table, graph, islands);
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
            is_solved(island, body).then(|| (island, islands.rank(slot, body), slot))
        });
        let mut solved: Vec<_> = solved.collect();
        solved.sort_unstable_by_key(|&(island, rank, _)| (island, rank));
        self.local.clear();
        self.local.resize(table.slots(), u32::MAX);
        self.bodies.clear();
        let mut last = None;
        let mut local = 0;
        for (island, _, slot) in solved {
            local = if last == Some(island) { local + 1 } else { 0 };
            last = Some(island);
            self.local[slot as usize] = local;
            self.bodies.push(Member {
                island: island as u32,
                slot,
            });
        }
    }

    fn order_touches(&mut self, table: &BodyTable, graph: &ConstraintGraph, islands: &Islands) {
        let local = &self.local;
        let is_solved = |slot: u32| local[slot as usize] != u32::MAX;
        // A link between two that are solved is found at A.
        let links = self.bodies.iter().flat_map(|body| {
            let links = graph.links_of(body.slot);
            links.filter(move |link| link.slots[0] == body.slot || !is_solved(link.slots[0]))
        });
        let mut touches: Vec<(u128, Place)> = links
            .filter_map(|link| {
                let bodies = table.both(link.slots)?;
                let solved = link.slots.into_iter().find(|&slot| is_solved(slot))?;
                let island = islands.of(solved)? as u32;
                let ends = link.slots.map(|slot| local[slot as usize]);
                let at = Place {
                    island,
                    pair: link.pair,
                    edge: link.edge,
                    revision: None,
                };
                Some((place(island, bodies, ends), at))
            })
            .collect();
        touches.sort_unstable_by_key(|&(place, _)| place);
        self.touches.clear();
        self.touches
            .extend(touches.into_iter().map(|(_, place)| place));
        self.by_edge.clear();
        self.by_edge.resize(graph.edge_numbers(), u32::MAX);
        for (place, at) in self.touches.iter().zip(0..) {
            self.by_edge[place.edge as usize] = at;
        }
    }

    /// The touches, in order; and whether they are all there: some pairs may have gone since islands were found.
    pub fn touches<'a>(&mut self, pairs: &'a mut Pairs) -> (Vec<Touch<'a>>, bool) {
        let mut touches = reuse(std::mem::take(&mut self.spare));
        self.places.clear();
        for (entities, pairs, manifolds, targets, impulses) in pairs
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
                let at = self.by_edge.get(pair.edge as usize);
                let Some(place) = at.and_then(|&at| self.touches.get_mut(at as usize)) else {
                    continue;
                };
                if place.pair != entities[row] {
                    continue;
                }
                let revision = place.revision.replace(pair.revision);
                let edited = edits.get(row).copied().unwrap_or(false);
                impulses.fit(manifold);
                self.places.push(self.by_edge[pair.edge as usize]);
                touches.push(Touch {
                    island: place.island,
                    changed: edited || revision != Some(pair.revision),
                    pair,
                    manifold,
                    targets,
                    impulses,
                });
            }
        }
        let complete = touches.len() == self.touches.len();
        if !complete {
            self.forget();
            let mut there = self.places.clone();
            there.sort_unstable();
            for place in &mut self.places {
                *place = there.partition_point(|other| *other < *place) as u32;
            }
        }
        put_in_place(&mut touches, &mut self.places);
        (touches, complete)
    }

    /// Takes the memory of a list back.
    pub fn take_back(&mut self, touches: Vec<Touch>) {
        self.spare = reuse(touches);
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
}
