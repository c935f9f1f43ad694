//! A partition of bodies into islands: sets of bodies that are connected by links.
//!
//! There are two of them ([`Islands`](super::Islands)). One contains all dynamic bodies: its islands are the structures of the world. The
//! other contains the bodies that are solved: those that are awake, so that sleeping bodies separate its islands as the ground does.
//!
//! Invariants, after every update:
//! - Two linked members are in the same island. Other bodies are in no island, so they connect no islands.
//! - If islands are counted, they are numbered from 0 in the order of their first member (by slot).
//!
//! This is the result of a search through the whole graph (the oracle of the tests). The method follows Erin Catto, *Simulation Islands*
//! (box2d.org, 2023): a link that begins merges the smaller island into the larger at once; a link that ends makes its island a candidate
//! for a split. Candidates are split in the same update, because bitwise reproducible results need exact islands. Searches from all bodies
//! that have lost a link run in turns. They end when they have met, which takes only a few bodies for two neighbours in a wall, or when one
//! search has found all bodies it can reach; these are split off. So the cost of a split is proportional to its smaller part.

use super::edges::ConstraintGraph;
use super::parts::Parts;
use crate::body::cover;
use crate::revision::Revision;
use crate::solver::{Both, sort};
use crate::stored::clone_fields;
use std::collections::VecDeque;
use std::fmt;

/// The place of a body in the partition.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Place {
    island: u32,
    /// Index in the list of the island's members.
    place: u32,
}

const NONE: u32 = u32::MAX;

/// In place of an island: the body enters, and its place is that in the list of those.
const ENTERING: u32 = NONE - 1;

const NOWHERE: Place = Place {
    island: NONE,
    place: 0,
};

#[derive(Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Island {
    members: Vec<u32>,
    /// The first member; [`NONE`] if there is none, or if islands are not numbered.
    first: u32,
    number: u32,
    /// Changes with the members and links of the island.
    revision: Revision,
}

clone_fields!(Island {
    members,
    first,
    number,
    revision,
});

/// The islands.
#[derive(Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Partition {
    /// Whether its islands are numbered.
    has_numbers: bool,
    /// Indexed by slot.
    places: Vec<Place>,
    /// Slots of the bodies that were [inserted](Self::insert) and are in no island yet.
    #[cfg_attr(feature = "serde", serde(skip))]
    entering: Vec<u32>,
    islands: Vec<Island>,
    free: Vec<u32>,
    /// The islands, in the order of their numbers.
    numbered: Vec<u32>,
    /// Islands that were made since the last numbering.
    unnumbered: Vec<u32>,
    /// Islands whose first member has to be found.
    headless: Vec<u32>,
    /// Whether the islands have to be numbered anew.
    stale: bool,
    #[cfg_attr(feature = "serde", serde(skip))]
    search: Search,
}

clone_fields!(Partition {
    has_numbers,
    places,
    entering,
    islands,
    free,
    numbered,
    unnumbered,
    headless,
    stale,
    search,
});

impl Partition {
    /// A partition whose islands are numbered.
    pub fn with_numbers() -> Self {
        Self {
            has_numbers: true,
            ..Self::default()
        }
    }

    /// Number of islands, if they are numbered.
    pub fn count(&self) -> usize {
        self.numbered.len()
    }

    /// Upper bound of island identities: all identities in use are below it.
    pub fn ids(&self) -> usize {
        self.islands.len()
    }

    /// Identity of the island of a member. It is constant until the island is merged or split.
    #[inline]
    pub fn id(&self, slot: u32) -> Option<u32> {
        let island = self.places.get(slot as usize)?.island;
        (island < ENTERING).then_some(island)
    }

    /// The number of an island, or `None` if it has none.
    #[inline]
    pub fn number(&self, island: u32) -> Option<usize> {
        let number = self.islands[island as usize].number;
        (number != NONE).then_some(number as usize)
    }

    /// The islands, by number.
    pub fn numbered(&self) -> &[u32] {
        &self.numbered
    }

    /// All members of an island.
    pub fn members(&self, island: u32) -> &[u32] {
        let island = self.islands.get(island as usize);
        island.map_or(&[], |island| &island.members)
    }

    /// The revision of an island.
    pub fn revision(&self, island: u32) -> Revision {
        self.islands[island as usize].revision
    }

    /// Gives the island of a body a new revision.
    pub fn mark(&mut self, slot: u32, revision: Revision) {
        if let Some(island) = self.id(slot) {
            self.islands[island as usize].revision = revision;
        }
    }

    /// Gives all islands a new revision.
    pub fn mark_all(&mut self, revision: Revision) {
        for island in &mut self.islands {
            island.revision = revision;
        }
    }

    /// [Covers](cover) so many slots, also those of a search.
    pub fn cover(&mut self, slots: usize) {
        cover(&mut self.places, slots, NOWHERE);
        cover(&mut self.search.found_by, slots, 0);
    }

    /// Inserts a body. It is in no island before [`Self::take_in`].
    pub fn insert(&mut self, slot: u32) {
        if self.places.len() <= slot as usize {
            self.places.resize(slot as usize + 1, NOWHERE);
        }
        self.places[slot as usize] = Place {
            island: ENTERING,
            place: self.entering.len() as u32,
        };
        self.entering.push(slot);
    }

    /// Makes islands of the bodies that were inserted since. Those that these links connect are one island from the beginning: if each body
    /// were an island until it is merged, there would be as many identities as bodies, and lists by identity would be as long.
    pub fn take_in<'a>(&mut self, links: impl Iterator<Item = &'a [u32; 2]>) {
        let entering = std::mem::take(&mut self.entering);
        if entering.is_empty() {
            return;
        }
        let mut parts = Parts::new(entering.len());
        for &slots in links {
            let places = slots.both(|slot| self.places.get(slot as usize).copied());
            if let [Some(a), Some(b)] = places
                && (a.island, b.island) == (ENTERING, ENTERING)
            {
                parts.join(a.place, b.place);
            }
        }
        for part in parts.members() {
            let slots = part.into_iter().map(|place| entering[place as usize]);
            self.insert_all(slots.collect());
        }
    }

    /// Adds bodies that are connected, and with no others, as an island.
    pub fn insert_all(&mut self, members: Vec<u32>) {
        let Some(&last) = members.iter().max() else {
            return;
        };
        if self.places.len() <= last as usize {
            self.places.resize(last as usize + 1, NOWHERE);
        }
        let island = self.new_island();
        for (place, &slot) in (0..).zip(&members) {
            self.places[slot as usize] = Place { island, place };
        }
        for &slot in &members {
            self.lead(island, slot);
        }
        self.islands[island as usize].members = members;
    }

    /// Removes a body.
    pub fn remove(&mut self, slot: u32) {
        match self.places.get(slot as usize).copied() {
            None | Some(NOWHERE) => return,
            Some(Place {
                island: ENTERING,
                place,
            }) => {
                self.entering.swap_remove(place as usize);
                if let Some(&moved) = self.entering.get(place as usize) {
                    self.places[moved as usize].place = place;
                }
            }
            Some(_) => self.take(slot),
        }
        self.places[slot as usize] = NOWHERE;
    }

    /// Merges the islands of two linked bodies.
    pub fn link(&mut self, [a, b]: [u32; 2]) {
        let (Some(one), Some(other)) = (self.id(a), self.id(b)) else {
            return;
        };
        if one == other {
            return;
        }
        let size = |island: u32| self.islands[island as usize].members.len();
        let (large, small) = match size(one) >= size(other) {
            true => (one, other),
            false => (other, one),
        };
        let merged = std::mem::take(&mut self.islands[small as usize]);
        self.free(small);
        let into = &mut self.islands[large as usize];
        for slot in merged.members {
            self.places[slot as usize].island = large;
            self.places[slot as usize].place = into.members.len() as u32;
            into.members.push(slot);
        }
        // If the first member of the small island is not known, it is searched for in the large one.
        match self.headless.contains(&small) {
            true => self.headless.push(large),
            false => self.lead(large, merged.first),
        }
    }

    /// Splits islands in which links have ended. `ends` are the bodies of those links; each part that an island may have split into must
    /// contain at least one of them.
    pub fn split(&mut self, graph: &ConstraintGraph, ends: &[u32]) {
        let mut ends: Vec<(u32, u32)> = ends
            .iter()
            .filter_map(|&slot| Some((self.id(slot)?, slot)))
            .collect();
        sort::values(&mut ends);
        ends.dedup();
        let mut search = std::mem::take(&mut self.search);
        for ends in ends.chunk_by(|(a, _), (b, _)| a == b) {
            if ends.len() == 1 {
                continue;
            }
            search.begin(self.places.len(), ends.iter().map(|&(_, slot)| slot));
            let is_member = |slot: u32| self.id(slot).is_some();
            let parts = search.parts(graph, is_member);
            for part in parts {
                let island = self.new_island();
                for slot in part {
                    self.take(slot);
                    self.add(slot, island);
                }
            }
        }
        self.search = search;
    }

    /// Numbers the islands anew if necessary. Returns true if it did.
    pub fn renumber(&mut self) -> bool {
        for id in std::mem::take(&mut self.headless) {
            let island = &mut self.islands[id as usize];
            let first = island.members.iter().copied().min().unwrap_or(NONE);
            if island.first != first {
                // The identity may be that of an island that was made since.
                if island.first == NONE {
                    self.unnumbered.push(id);
                }
                island.first = first;
                self.stale = true;
            }
        }
        if !std::mem::take(&mut self.stale) {
            return false;
        }
        let islands = &mut self.islands;
        self.numbered.append(&mut self.unnumbered);
        self.numbered.retain(|&id| {
            let island = &mut islands[id as usize];
            island.number = NONE;
            island.first != NONE
        });
        sort::by_key(&mut self.numbered, |&id| islands[id as usize].first);
        self.numbered.dedup();
        for (number, &id) in self.numbered.iter().enumerate() {
            islands[id as usize].number = number as u32;
        }
        true
    }

    fn new_island(&mut self) -> u32 {
        let id = self.free.pop().unwrap_or_else(|| {
            self.islands.push(Island::default());
            self.islands.len() as u32 - 1
        });
        let island = &mut self.islands[id as usize];
        (island.first, island.number) = (NONE, NONE);
        id
    }

    fn free(&mut self, id: u32) {
        self.islands[id as usize] = Island {
            first: NONE,
            number: NONE,
            ..Default::default()
        };
        self.free.push(id);
        self.stale = true;
    }

    /// Adds a body to an island.
    fn add(&mut self, slot: u32, id: u32) {
        let island = &mut self.islands[id as usize];
        let place = &mut self.places[slot as usize];
        (place.island, place.place) = (id, island.members.len() as u32);
        island.members.push(slot);
        self.lead(id, slot);
    }

    /// Removes a body from its island.
    fn take(&mut self, slot: u32) {
        let Place { island: id, place } = self.places[slot as usize];
        let island = &mut self.islands[id as usize];
        island.members.swap_remove(place as usize);
        if let Some(&moved) = island.members.get(place as usize) {
            self.places[moved as usize].place = place;
        }
        self.leave_lead(id, slot);
        if self.islands[id as usize].members.is_empty() {
            self.free(id);
        }
    }

    /// Makes a body the first of its island if its slot is lower than that of the current first.
    fn lead(&mut self, id: u32, slot: u32) {
        if !self.has_numbers {
            return;
        }
        let island = &mut self.islands[id as usize];
        if slot < island.first {
            if island.first == NONE {
                self.unnumbered.push(id);
            }
            island.first = slot;
            self.stale = true;
        }
    }

    /// Marks the island for a search of its first member if this body was the first.
    fn leave_lead(&mut self, id: u32, slot: u32) {
        if self.islands[id as usize].first == slot {
            self.headless.push(id);
        }
    }
}

/// Several searches through the links of an island that run in turns. Scratch.
#[derive(Clone, Default)]
struct Search {
    /// By slot: 1 + the search that has found the body; 0 if none has.
    found_by: Vec<u32>,
    searches: Vec<Front>,
}

impl fmt::Debug for Search {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Search").finish_non_exhaustive()
    }
}

/// One search.
#[derive(Clone)]
struct Front {
    /// The search that this one was merged into after they met; itself if none.
    is: u32,
    found: Vec<u32>,
    next: VecDeque<u32>,
}

impl Search {
    /// Begins one search from each of these bodies.
    fn begin(&mut self, slots: usize, from: impl Iterator<Item = u32>) {
        cover(&mut self.found_by, slots, 0);
        self.searches.clear();
        for (search, slot) in (0..).zip(from) {
            self.found_by[slot as usize] = search + 1;
            self.searches.push(Front {
                is: search,
                found: vec![slot],
                next: VecDeque::from([slot]),
            });
        }
    }

    /// Finds the parts to split off. The last part stays in the island and is not searched completely.
    fn parts(&mut self, graph: &ConstraintGraph, is_member: impl Fn(u32) -> bool) -> Vec<Vec<u32>> {
        let mut parts = Vec::new();
        // Searches that are still to run, and the number of those that have neither met another nor finished.
        let mut turns: VecDeque<u32> = (0..self.searches.len() as u32).collect();
        let mut open = turns.len();
        while open > 1
            && let Some(search) = turns.pop_front()
        {
            let front = &mut self.searches[search as usize];
            if front.is != search {
                continue;
            }
            let Some(slot) = front.next.pop_front() else {
                parts.push(std::mem::take(&mut front.found));
                open -= 1;
                continue;
            };
            for other in graph.neighbours(slot).filter(|&other| is_member(other)) {
                match self.found_by[other as usize] {
                    0 => {
                        self.found_by[other as usize] = search + 1;
                        let front = &mut self.searches[search as usize];
                        front.found.push(other);
                        front.next.push_back(other);
                    }
                    by => open -= usize::from(self.meet(search, by - 1)),
                }
            }
            turns.push_back(search);
        }
        let left = self.searches.iter().flat_map(|front| &front.found);
        for &slot in left.chain(parts.iter().flatten()) {
            self.found_by[slot as usize] = 0;
        }
        parts
    }

    /// Merges two searches that have met; `search` continues for both. Returns false if they were merged already.
    fn meet(&mut self, search: u32, mut other: u32) -> bool {
        let searches = &mut self.searches;
        while searches[other as usize].is != other {
            let next = searches[other as usize].is;
            searches[other as usize].is = searches[next as usize].is;
            other = next;
        }
        if other == search {
            return false;
        }
        let met = &mut searches[other as usize];
        met.is = search;
        let (mut found, mut next) = (
            std::mem::take(&mut met.found),
            std::mem::take(&mut met.next),
        );
        let front = &mut searches[search as usize];
        if found.len() > front.found.len() {
            std::mem::swap(&mut found, &mut front.found);
            std::mem::swap(&mut next, &mut front.next);
        }
        front.found.append(&mut found);
        front.next.append(&mut next);
        true
    }
}
