//! What is solved with what, and in which order: found when islands change, and kept while they don't.
//!
//! What touches is what *islands* found to touch. A pair is known by its entity. Where the query has it is only where to look for it: if a
//! system between *islands* and *solve* has taken pairs into other tables, by a component of its own for instance, they are looked for.

use super::Pairs;
use super::touch::{Touch, place};
use crate::body::{BodyState, BodyTable};
use crate::contact::is_edited;
use crate::islands::Islands;
use bevy_ecs::change_detection::ContiguousMut;
use bevy_ecs::entity::{Entity, EntityHashMap};

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
    /// The same as the query has them: the row, and the place in the order.
    rows: Vec<(u32, u32)>,
    /// Scratch.
    places: Vec<u32>,
    spare: Vec<Touch<'static>>,
}

/// A touch that is solved.
#[derive(Clone, Copy)]
struct Place {
    island: u32,
    pair: Entity,
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
        self.order_touches(table, islands);
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

    fn order_touches(&mut self, table: &BodyTable, islands: &Islands) {
        let local = &self.local;
        let is_solved = |slot: &&u32| local[**slot as usize] != u32::MAX;
        let touching = islands.links().iter();
        let mut touches: Vec<(u128, Place, u32)> = touching
            .filter_map(|link| {
                let bodies = table.both(link.slots)?;
                let island = islands.of(*link.slots.iter().find(is_solved)?)? as u32;
                let ends = link.slots.map(|slot| local[slot as usize]);
                let at = Place {
                    island,
                    pair: link.pair,
                    revision: None,
                };
                Some((place(island, bodies, ends), at, link.row))
            })
            .collect();
        touches.sort_unstable_by_key(|&(place, ..)| place);
        self.touches.clear();
        self.touches
            .extend(touches.iter().map(|&(_, place, _)| place));
        self.rows.clear();
        let rows = touches.iter().map(|&(.., row)| row);
        self.rows.extend(rows.zip(0..));
        self.rows.sort_unstable();
    }

    /// Looks for the touches where they are not in the rows in which they were.
    fn find_rows(&mut self, pairs: &Pairs) {
        if self.are_in_their_rows(pairs) {
            return;
        }
        let places = self.touches.iter().map(|touch| touch.pair).zip(0..);
        let places: EntityHashMap<u32> = places.collect();
        let rows = pairs.iter().zip(0..);
        let rows = rows.filter_map(|((pair, ..), row)| Some((row, *places.get(&pair)?)));
        self.rows.clear();
        self.rows.extend(rows);
    }

    fn are_in_their_rows(&self, pairs: &Pairs) -> bool {
        let mut wanted = self.rows.iter().peekable();
        let mut first = 0;
        let tables = pairs.contiguous_iter();
        for (entities, ..) in tables.expect("pair components are stored in tables") {
            let end = first + entities.len() as u32;
            while let Some((row, at)) = wanted.next_if(|(row, _)| *row < end) {
                if entities[(row - first) as usize] != self.touches[*at as usize].pair {
                    return false;
                }
            }
            first = end;
        }
        wanted.next().is_none()
    }

    /// The touches, in order; and whether they are all there: some pairs may have gone since islands were found.
    pub fn touches<'a>(&mut self, pairs: &'a mut Pairs) -> (Vec<Touch<'a>>, bool) {
        self.find_rows(pairs);
        let mut touches = reuse(std::mem::take(&mut self.spare));
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
                let place = &mut self.touches[at as usize];
                let revision = place.revision.replace(pair.revision);
                let edited = edits.get(row).copied().unwrap_or(false);
                impulses.fit(manifold);
                self.places.push(at);
                touches.push(Touch {
                    island: place.island,
                    changed: edited || revision != Some(pair.revision),
                    pair,
                    manifold,
                    targets,
                    impulses,
                });
            }
            first += pairs.len() as u32;
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
