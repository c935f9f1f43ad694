//! The contacts of a group, its structures, and the order in which they are loaded.

use super::super::region::Contact;
use super::groups::Group;
use crate::body::{BodyState, BodyTable};
use crate::diagnosis::BodyProblem;
use crate::graph::warn;
use crate::narrowphase::Detector;
use crate::pair::{ContactPair, PairParts};
use bevy_ecs::prelude::*;

/// A structure.
pub(super) struct Structure {
    /// Slots of its bodies, with their levels of support, in the order of a solve.
    pub members: Vec<(u32, u32)>,
    /// Indices of its contacts, in the order of a solve.
    pub contacts: Vec<u32>,
}

/// The contacts and structures of a group.
pub(super) struct Found {
    pub contacts: Vec<Contact>,
    pub islands: Vec<Structure>,
    pub warnings: Vec<(Entity, BodyProblem)>,
}

impl Found {
    /// Writes the index of each body in its structure, by slot.
    pub fn number(&self, local: &mut [u32]) {
        for island in &self.islands {
            for (index, &(slot, _)) in (0..).zip(&island.members) {
                local[slot as usize] = index;
            }
        }
    }
}

/// Finds contacts.
pub(super) struct Contacts<'a> {
    pub table: &'a BodyTable,
    detector: Detector,
}

const NONE: u32 = u32::MAX;

impl<'a> Contacts<'a> {
    pub fn new(world: &World, table: &'a BodyTable) -> Self {
        Self {
            table,
            detector: Detector::new(world),
        }
    }

    /// Finds the contacts and the structures of a group.
    pub fn find(&self, group: &Group) -> Found {
        let mut warnings = Vec::new();
        let mut contacts: Vec<Contact> = Vec::with_capacity(group.pairs.len());
        for &slots in group.pairs {
            let Some(bodies) = self.table.both(slots) else {
                continue;
            };
            warn(bodies, &mut warnings);
            // A contact has 600 bytes, so it is filled where it stays.
            let contact = contacts.push_mut(Contact {
                pair: ContactPair::new(0, slots, bodies, self.detector.revision),
                parts: PairParts::default(),
                links: false,
            });
            self.detect(bodies, contact);
        }
        let islands = self.structures(group, &contacts);
        Found {
            contacts,
            islands,
            warnings,
        }
    }

    fn detect(&self, bodies: [&BodyState; 2], contact: &mut Contact) {
        let Contact { pair, parts, links } = contact;
        let (manifold, targets, impulses, anchors, cache) = parts;
        let kept = (&mut *manifold, &mut *impulses, anchors, targets);
        self.detector.detect(bodies, pair, cache, kept);
        impulses.fit(manifold);
        *links = !manifold.points.is_empty();
        pair.rest(pair.touching);
    }

    /// Divides a group into structures, and sorts them as the order of a solve is sorted.
    fn structures(&self, group: &Group, contacts: &[Contact]) -> Vec<Structure> {
        let mut sorted: Vec<u32> = group.bodies.to_vec();
        sorted.sort_unstable();
        let place = |slot: u32| sorted.binary_search(&slot).ok();
        let links = Links::new(sorted.len(), contacts, place);
        let links_of = |body: usize| links.of(body);
        let other = |contact: u32, body: usize| links.other(contact, body);
        let levels = levels(sorted.len(), links_of, other);
        let mut structures = Vec::new();
        let mut is_found = vec![false; sorted.len()];
        let mut ranks = vec![NONE; sorted.len()];
        for first in 0..sorted.len() {
            if std::mem::replace(&mut is_found[first], true) {
                continue;
            }
            let mut members = vec![first];
            let mut at = 0;
            while let Some(&body) = members.get(at) {
                at += 1;
                for &contact in links_of(body) {
                    if let Some(beside) = other(contact, body)
                        && !std::mem::replace(&mut is_found[beside], true)
                    {
                        members.push(beside);
                    }
                }
            }
            let spawned = |body: usize| self.table.get(sorted[body]).map(|body| body.spawn_order);
            members.sort_unstable_by_key(|&body| (levels[body], spawned(body)));
            for (rank, &body) in (0..).zip(&members) {
                ranks[body] = rank;
            }
            let mut of_it = Vec::new();
            let mut lower: Vec<((bool, u64), u32)> = Vec::new();
            for (rank, &body) in (0..).zip(&members) {
                lower.clear();
                lower.extend(links_of(body).iter().filter_map(|&contact| {
                    let key = match other(contact, body) {
                        Some(other) => (true, u64::from(ranks[other])),
                        None => {
                            let [a, b] = contacts[contact as usize].pair.slots;
                            let fixed = if a == sorted[body] { b } else { a };
                            (false, self.table.get(fixed).map(of_order)?)
                        }
                    };
                    (key < (true, rank)).then_some((key, contact))
                }));
                lower.sort_unstable();
                of_it.extend(lower.iter().map(|&(_, contact)| contact));
            }
            structures.push(Structure {
                members: { members.into_iter() }
                    .map(|body| (sorted[body], levels[body]))
                    .collect(),
                contacts: of_it,
            });
        }
        structures
    }
}

/// The linking contacts of each body of a group.
struct Links {
    /// The bodies of each contact, as far as they are of the group.
    ends: Vec<[Option<usize>; 2]>,
    /// Where the contacts of each body begin in the list.
    firsts: Vec<u32>,
    list: Vec<u32>,
}

impl Links {
    fn new(bodies: usize, contacts: &[Contact], place: impl Fn(u32) -> Option<usize>) -> Self {
        let ends: Vec<[Option<usize>; 2]> = { contacts.iter() }
            .map(|contact| contact.pair.slots.map(&place))
            .collect();
        let links = || {
            ends.iter()
                .zip(contacts)
                .enumerate()
                .filter(|(_, (_, of))| of.links)
        };
        let mut firsts = vec![0u32; bodies + 1];
        for (_, (ends, _)) in links() {
            ends.iter().flatten().for_each(|&end| firsts[end + 1] += 1);
        }
        for i in 0..bodies {
            firsts[i + 1] += firsts[i];
        }
        let mut next = firsts.clone();
        let mut list = vec![0u32; firsts[bodies] as usize];
        for (contact, (ends, _)) in links() {
            for &end in ends.iter().flatten() {
                list[next[end] as usize] = contact as u32;
                next[end] += 1;
            }
        }
        Self { ends, firsts, list }
    }

    fn of(&self, body: usize) -> &[u32] {
        &self.list[self.firsts[body] as usize..self.firsts[body + 1] as usize]
    }

    /// The other body of a contact, if it is of the group.
    fn other(&self, contact: u32, body: usize) -> Option<usize> {
        let [a, b] = self.ends[contact as usize];
        if a == Some(body) { b } else { a }
    }
}

fn of_order(body: &BodyState) -> u64 {
    body.spawn_order.0
}

/// The level of support of each body: the number of links down to a body that is not of the group, which is static.
fn levels<'a>(
    count: usize,
    links_of: impl Fn(usize) -> &'a [u32],
    other: impl Fn(u32, usize) -> Option<usize>,
) -> Vec<u32> {
    let mut levels = vec![NONE; count];
    let stands = |body: usize| links_of(body).iter().any(|&of| other(of, body).is_none());
    let mut queue: Vec<usize> = (0..count).filter(|&body| stands(body)).collect();
    for &body in &queue {
        levels[body] = 1;
    }
    let mut at = 0;
    while let Some(&body) = queue.get(at) {
        at += 1;
        for &contact in links_of(body) {
            if let Some(above) = other(contact, body)
                && levels[above] == NONE
            {
                levels[above] = levels[body] + 1;
                queue.push(above);
            }
        }
    }
    levels
}
