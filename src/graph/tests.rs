//! Tests that compare the views of the graph with a search through the whole graph, after every change of randomly drawn graphs.

use super::ConstraintGraph;
use super::edges::EdgeKind;
use super::islands::Islands;
use super::levels::{self, Kind, Levels};
use crate::body::{BodyIndex, BodyState, BodyTable, Pose, RigidBody, SpawnOrder, Velocity, WORLD};
use bevy_ecs::prelude::*;
use fastrand::Rng;
use std::collections::{BTreeMap, BTreeSet};

/// A table of bodies and its graph, with the expected content of both.
#[derive(Default)]
pub(crate) struct Site {
    pub table: BodyTable,
    pub graph: ConstraintGraph,
    pub islands: Islands,
    edges: BTreeMap<[u32; 2], (u32, Entity, bool)>,
    /// Joints: slots, number and entity. There may be several between two bodies, and some are to the world.
    joints: Vec<([u32; 2], u32, Entity)>,
    /// The existing bodies.
    bodies: BTreeMap<u32, Entity>,
    /// Bodies that were added or changed since the last update. Only bodies that were active in an update become inactive.
    fresh: BTreeSet<u32>,
    entities: u32,
}

impl Site {
    fn entity(&mut self) -> Entity {
        self.entities += 1;
        Entity::from_raw_u32(self.entities).unwrap()
    }

    pub fn spawn(&mut self, kind: RigidBody) -> u32 {
        let entity = self.entity();
        let mut body = BodyState::new(entity, Pose::default(), Velocity::default());
        body.kind = kind;
        body.spawn_order = SpawnOrder(u64::from(self.entities));
        let BodyIndex(slot) = self.table.insert(body);
        self.bodies.insert(slot, entity);
        self.fresh.insert(slot);
        slot
    }

    pub fn despawn(&mut self, slot: u32) {
        let entity = self.bodies.remove(&slot).unwrap();
        let ends: Vec<_> = self.edges.keys().copied().collect();
        for slots in ends.into_iter().filter(|slots| slots.contains(&slot)) {
            self.disconnect(slots);
        }
        while let Some(i) = self.joints.iter().position(|of| of.0.contains(&slot)) {
            self.part(i);
        }
        self.table.remove(entity, BodyIndex(slot));
        self.table.recycle(slot);
        self.graph.changes.gone.push(slot);
    }

    pub fn connect(&mut self, slots: [u32; 2]) {
        if self.graph.unknown([slots].into_iter()).next().is_some() {
            let edge = self.graph.insert(EdgeKind::Contact, slots);
            let entity = self.entity();
            self.graph.name(edge, entity);
            self.edges.insert(slots, (edge, entity, false));
        }
    }

    fn join(&mut self, slots: [u32; 2]) {
        let edge = self.graph.insert(EdgeKind::Joint, slots);
        let entity = self.entity();
        self.graph.name(edge, entity);
        self.graph.set_links(edge, true);
        self.joints.push((slots, edge, entity));
    }

    fn part(&mut self, joint: usize) {
        let (_, edge, entity) = self.joints.swap_remove(joint);
        self.graph.remove(edge, entity);
    }

    pub fn disconnect(&mut self, slots: [u32; 2]) {
        let (edge, entity, _) = self.edges.remove(&slots).unwrap();
        self.graph.remove(edge, entity);
    }

    pub fn link(&mut self, slots: [u32; 2], links: bool) {
        let (edge, _, known) = self.edges.get_mut(&slots).unwrap();
        *known = links;
        self.graph.set_links(*edge, links);
    }

    pub fn update(&mut self) {
        self.table.removed.clear();
        self.islands.begin();
        self.islands.update(&mut self.graph, &self.table);
        self.fresh.clear();
    }

    /// Makes one random change.
    pub fn edit(&mut self, rng: &mut Rng) {
        let slots: Vec<u32> = self.bodies.keys().copied().collect();
        let slot = *rng.choice(&slots).unwrap();
        let edges: Vec<[u32; 2]> = self.edges.keys().copied().collect();
        match rng.u8(0..100) {
            0..3 => {
                let kind = if rng.u8(0..5) == 0 {
                    RigidBody::Static
                } else {
                    RigidBody::Dynamic
                };
                self.spawn(kind);
            }
            3..6 if slots.len() > 4 => self.despawn(slot),
            6..9 => {
                let body = self.table.get_mut(slot).unwrap();
                body.kind = match body.kind {
                    RigidBody::Dynamic => RigidBody::Static,
                    _ => RigidBody::Dynamic,
                };
                // A change would have marked the body.
                self.table.set_inactive(slot, false);
                self.fresh.insert(slot);
            }
            9..15 => {
                let rests = rng.bool() && !self.fresh.contains(&slot);
                self.table.set_inactive(slot, rests);
            }
            15..18 => {
                let body = self.table.get_mut(slot).unwrap();
                body.asleep = !body.asleep;
            }
            18..40 => {
                // Mostly neighbours in a row, as in a wall, and sometimes distant bodies.
                let far = if rng.u8(0..4) == 0 { 30 } else { 3 };
                let other = slot + rng.u32(1..=far);
                if self.bodies.contains_key(&other) {
                    self.connect([slot, other]);
                }
            }
            40..45 if !edges.is_empty() => self.disconnect(*rng.choice(&edges).unwrap()),
            45..49 => {
                let other = slot + rng.u32(1..=3);
                if rng.u8(0..6) == 0 {
                    self.join([WORLD, slot]);
                } else if self.bodies.contains_key(&other) {
                    self.join([slot, other]);
                }
            }
            49..54 if !self.joints.is_empty() => self.part(rng.usize(0..self.joints.len())),
            _ if !edges.is_empty() => {
                let links = rng.u8(0..5) < 3;
                self.link(*rng.choice(&edges).unwrap(), links);
            }
            _ => (),
        }
    }

    fn is_dynamic(&self, slot: u32) -> bool {
        self.table.get(slot).is_some_and(BodyState::is_dynamic)
    }

    /// Whether a body is in an island: it is active and awake.
    fn is_solved(&self, slot: u32) -> bool {
        let body = self.table.get(slot);
        body.is_some_and(BodyState::is_awake) && !self.table.is_inactive(slot)
    }

    /// The parts that links connect bodies to, of those bodies that may be in one; found by a flood fill.
    fn connected(&self, is_member: impl Fn(u32) -> bool) -> BTreeSet<Vec<u32>> {
        let links = self.edges.iter().filter(|(_, known)| known.2);
        let joints = self.joints.iter().map(|joint| joint.0);
        let links: Vec<[u32; 2]> = links.map(|(&slots, _)| slots).chain(joints).collect();
        let mut label: BTreeMap<u32, u32> = self.bodies.keys().map(|&slot| (slot, slot)).collect();
        loop {
            let mut changed = false;
            for slots in &links {
                if slots.iter().all(|&slot| is_member(slot)) {
                    let least = slots.map(|slot| label[&slot]).into_iter().min().unwrap();
                    for slot in slots {
                        changed |= label.insert(*slot, least) != Some(least);
                    }
                }
            }
            if !changed {
                break;
            }
        }
        let mut islands: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for (slot, label) in label {
            if is_member(slot) {
                islands.entry(label).or_default().push(slot);
            }
        }
        islands.into_values().collect()
    }

    fn check(&self) {
        let sorted = |members: &[u32]| {
            let mut members = members.to_vec();
            members.sort_unstable();
            members
        };
        let wanted = self.connected(|slot| self.is_dynamic(slot));
        let dynamic = self.bodies.keys().copied();
        let dynamic = dynamic.filter(|&slot| self.is_dynamic(slot));
        let found = dynamic.map(|slot| sorted(self.islands.structure(slot)));
        assert_eq!(found.collect::<BTreeSet<_>>(), wanted);
        // Islands are numbered by their first member, and so is the set.
        let wanted = self.connected(|slot| self.is_solved(slot));
        assert_eq!(self.islands.count(), wanted.len());
        for (number, members) in wanted.iter().enumerate() {
            let id = self.islands.numbered()[number];
            assert_eq!(sorted(self.islands.members_of_id(id)), *members);
            for &slot in members {
                assert_eq!(self.islands.of(slot), Some(number));
            }
        }
        let sleepers = self.bodies.keys().filter(|&&slot| !self.is_solved(slot));
        for &slot in sleepers.clone() {
            assert_eq!(self.islands.of(slot), None);
        }
        let sleepers = sleepers.filter(|&&slot| self.is_dynamic(slot)).count();
        assert_eq!(self.islands.sleepers, sleepers);
        let slots = self.table.slots() as u32;
        let kind = |slot: u32| match self.table.get(slot) {
            None => Kind::Empty,
            Some(body) if body.is_dynamic() => Kind::Dynamic,
            Some(_) => Kind::Fixed,
        };
        let wanted = levels::recompute(&self.graph, slots, kind);
        let level = |slot| self.islands.level(slot).unwrap_or(Levels::NONE);
        let found: Vec<u32> = (0..slots).map(level).collect();
        assert_eq!(found, wanted);
    }
}

#[test]
fn islands_and_levels_match_a_search_through_the_whole_graph() {
    for seed in 0..60 {
        let mut rng = Rng::with_seed(seed);
        let mut site = Site::default();
        for i in 0..40 {
            site.spawn(if i % 13 == 0 {
                RigidBody::Static
            } else {
                RigidBody::Dynamic
            });
        }
        for _ in 0..250 {
            // One change at a time, or many at once.
            for _ in 0..rng.u32(1..=12).saturating_sub(6).max(1) {
                site.edit(&mut rng);
            }
            site.update();
            site.check();
        }
    }
}

/// A wall with `width` bricks in each course, each on two bricks; slot 0 is the ground.
fn wall(width: u32, courses: u32) -> Site {
    let mut site = Site::default();
    site.spawn(RigidBody::Static);
    for course in 0..courses {
        for i in 0..width {
            let slot = site.spawn(RigidBody::Dynamic);
            let below = match course {
                0 => vec![0],
                _ => vec![slot - width, (slot - width + 1).min(course * width)],
            };
            for below in below {
                site.connect([below, slot]);
                site.link([below, slot], true);
            }
            if i > 0 {
                site.connect([slot - 1, slot]);
                site.link([slot - 1, slot], true);
            }
        }
    }
    site.update();
    site
}

#[test]
fn an_island_that_comes_apart_is_split_and_joined_again() {
    let mut site = wall(6, 4);
    site.check();
    assert_eq!(site.islands.count(), 1);
    let top = 6 * 4;
    let of_top: Vec<_> = site.edges.keys().copied().collect();
    let of_top: Vec<_> = of_top
        .into_iter()
        .filter(|slots| slots.contains(&top))
        .collect();
    for &slots in &of_top {
        site.link(slots, false);
    }
    site.update();
    site.check();
    assert_eq!(site.islands.count(), 2);
    assert_eq!(site.islands.level(top), None);
    site.link(of_top[0], true);
    site.update();
    site.check();
    assert_eq!(site.islands.count(), 1);
}

#[test]
fn an_island_is_marked_when_it_changes_and_only_then() {
    let mut site = wall(3, 2);
    let (a, b) = (
        site.spawn(RigidBody::Dynamic),
        site.spawn(RigidBody::Dynamic),
    );
    site.connect([a, b]);
    site.update();
    let revisions = |site: &Site| {
        [1, a, b].map(|slot| site.islands.revision_of(site.islands.of(slot).unwrap()))
    };
    let before = revisions(&site);
    site.update();
    assert_eq!(revisions(&site), before);
    site.link([a, b], true);
    site.update();
    let now = revisions(&site);
    assert_eq!(now[0], before[0]);
    assert!(now[1] != before[1] && now[1] == now[2]);
    // A body that falls asleep leaves its island.
    site.table.get_mut(1).unwrap().asleep = true;
    site.update();
    assert_eq!(site.islands.of(1), None);
    let of = |slot| site.islands.revision_of(site.islands.of(slot).unwrap());
    assert_ne!(of(2), before[0]);
    assert_eq!(of(a), now[1]);
}

/// Lists by identity are kept in several places. When each body of a wall was an island before it was merged, they were as long as the
/// world.
#[test]
fn bodies_that_arrive_together_take_one_identity() {
    let site = wall(6, 4);
    site.check();
    assert_eq!((site.islands.count(), site.islands.ids()), (1, 1));
}
