//! The stage **islands**: groups bodies that push on each other, finds what stands on what (its level of support), and wakes islands that
//! may not sleep on. It comes before forces, so that what wakes has all of its weight when it is first solved.
//!
//! Static and kinematic bodies do not connect islands. Islands that sleep go to [rest](crate::body::Resting).

mod graph;
mod order;
mod rest;
mod sleeping;

pub use rest::rouse;
pub use sleeping::sleeping;

use crate::body::{Age, BodyState, BodyTable, Resting, Sleeping, Velocity};
use crate::contact::{ContactPair, Manifold};
use crate::settings::StepTime;
use crate::state::next_version;
use bevy_ecs::entity::{EntityMapper, MapEntities};
use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemState;
use graph::Graph;
use order::Levels;
use rest::{Groups, Tired};

/// Which island each body is in, and what stands on what.
#[derive(Resource, Clone, Default)]
#[component(map_entities)]
pub struct Islands {
    graph: Graph,
    levels: Levels,
    links: Vec<Link>,
    /// Scratch for the next ones.
    spare: Vec<Link>,
    members: Vec<Member>,
    version: u64,
    woke: bool,
    resting: Groups,
    tired: Tired,
    /// Who touched in the last step, and does no more.
    parted: Vec<[u32; 2]>,
    /// Islands that rest, and that who does not rest touches, or has ceased to touch.
    touched: Vec<u32>,
    /// By island: it sleeps, and some of its bodies have come in this step. Empty where none has.
    arriving: Vec<bool>,
}

impl MapEntities for Islands {
    fn map_entities<M: EntityMapper>(&mut self, mapper: &mut M) {
        for link in &mut self.links {
            link.pair.map_entities(mapper);
        }
        for member in &mut self.members {
            member.entity.map_entities(mapper);
        }
        self.resting.map_entities(mapper);
        self.version = next_version();
    }
}

/// A pair that touches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Link {
    /// Those of its bodies.
    pub slots: [u32; 2],
    pub pair: Entity,
    /// Where the query had it.
    pub row: u32,
}

/// A body that is active, and what it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Member {
    slot: u32,
    entity: Entity,
    age: Age,
    dynamic: bool,
    asleep: bool,
}

impl Member {
    #[inline]
    fn of((slot, body): (u32, &BodyState)) -> Self {
        Self {
            slot,
            entity: body.entity,
            age: body.age,
            dynamic: body.is_dynamic(),
            asleep: body.asleep,
        }
    }

    /// The same body of the same kind, be it awake or asleep.
    fn is_same(&self, other: &Self) -> bool {
        let asleep = other.asleep;
        Self { asleep, ..*self } == *other
    }
}

/// The pairs that do not rest.
type Pairs<'w, 's> =
    Query<'w, 's, (Entity, &'static ContactPair, &'static Manifold), Without<Resting>>;

impl Islands {
    /// The island of a dynamic body that does not rest, by its slot.
    pub fn of(&self, slot: u32) -> Option<usize> {
        self.graph.of(slot)
    }

    /// How many there are, but for those that [rest](crate::body::Resting).
    pub fn count(&self) -> usize {
        self.graph.count
    }

    /// How many contacts a body is away from what stands still; `None` where nothing carries it.
    #[inline]
    pub fn level(&self, slot: u32) -> Option<u32> {
        Some(self.levels.of(slot)).filter(|level| *level != Levels::NONE)
    }

    /// An island sleeps, and some of its bodies have come into the world in this step.
    pub(crate) fn arrives(&self, island: usize) -> bool {
        self.arriving.get(island).copied().unwrap_or(false)
    }

    /// Some island does.
    pub(crate) fn any_arrives(&self) -> bool {
        self.arriving.contains(&true)
    }

    /// The pairs that touch, but for those at rest.
    pub(crate) fn links(&self) -> &[Link] {
        &self.links
    }

    /// Somebody was woken in this step.
    pub(crate) fn woke(&self) -> bool {
        self.woke
    }

    /// Another whenever who touches whom, who is awake, or where pairs are kept is not as it was.
    pub(crate) fn version(&self) -> u64 {
        self.version
    }

    /// Takes over who touches whom; true where that or who they are is not as it was.
    fn link(&mut self, table: &BodyTable, pairs: &Pairs, time: &StepTime) -> bool {
        let mut links = std::mem::take(&mut self.spare);
        links.clear();
        self.tired.pairs.clear();
        self.parted.clear();
        for ((entity, pair, manifold), row) in pairs.iter().zip(0..) {
            // What touches has been told by the end of the step.
            if pair.idle && time.substep == 0 && pair.slots.iter().all(|&slot| table.rests(slot)) {
                self.tired.pairs.push((entity, pair.slots));
            }
            if pair.parted {
                self.parted.push(pair.slots);
            }
            if !manifold.points.is_empty() {
                links.push(Link {
                    slots: pair.slots,
                    pair: entity,
                    row,
                });
            }
        }
        let same = links == self.links
            && self.members.len() == table.active().count()
            && (table.active().map(Member::of).zip(&self.members)).all(|(a, b)| a.is_same(b));
        self.spare = std::mem::replace(&mut self.links, links);
        if !same {
            self.regroup(table);
        }
        !same
    }

    fn regroup(&mut self, table: &BodyTable) {
        let moves = |slot: u32| table.get(slot).is_some_and(BodyState::is_dynamic);
        let stands_still = |slot: u32| table.get(slot).is_some_and(|body| !body.is_dynamic());
        let links: Vec<[u32; 2]> = self.links.iter().map(|link| link.slots).collect();
        self.levels.find(table.slots(), &links, stands_still);
        let mut links = links;
        let mut members: Vec<u32> = table.active().map(|(slot, _)| slot).collect();
        members.retain(|&slot| moves(slot));
        links.retain(|slots| slots.iter().all(|&slot| moves(slot)));
        for slot in links.as_flattened_mut() {
            *slot = self.node(table, *slot);
        }
        self.touched.clear();
        let parted = self.parted.as_flattened().iter().copied();
        let slots = self.links.iter().flat_map(|link| link.slots).chain(parted);
        let touched = slots.filter(|&slot| table.rests(slot) && moves(slot));
        self.touched
            .extend(touched.filter_map(|slot| self.resting.of(slot)));
        self.touched.sort_unstable();
        self.touched.dedup();
        members.extend(
            self.touched
                .iter()
                .map(|&island| table.slots() as u32 + island),
        );
        let nodes = table.slots() + self.resting.count();
        self.graph.regroup(nodes, members.into_iter(), &links);
    }

    /// Where a body stands in the graph: in its slot, or, where it rests, behind all slots as its island.
    fn node(&self, table: &BodyTable, slot: u32) -> u32 {
        // A static body may be in the slot of one that rested.
        let rests = table.rests(slot) && table.get(slot).is_some_and(BodyState::is_dynamic);
        match self.resting.of(slot).filter(|_| rests) {
            Some(island) => table.slots() as u32 + island,
            None => slot,
        }
    }

    /// The island that a body is in, be it one that rests and is touched by who does not.
    fn find(&self, table: &BodyTable, slot: u32) -> Option<usize> {
        self.graph.of(self.node(table, slot))
    }

    /// A number of the island that a dynamic body is in, be it awake, asleep or at rest. It is that of no other island until the next step.
    pub(crate) fn number(&self, table: &BodyTable, slot: u32) -> Option<usize> {
        self.find(table, slot).or_else(|| {
            let at_rest = self.resting.of(slot).filter(|_| table.rests(slot))?;
            Some(self.graph.count + at_rest as usize)
        })
    }

    /// The slots of all bodies in the island of a dynamic one, be they awake, asleep or at rest.
    pub(crate) fn members(&self, table: &BodyTable, slot: u32) -> Vec<u32> {
        let at_rest = |group: u32| {
            let members = self.resting.members(table, group);
            members.map(|(slot, _)| slot)
        };
        let Some(island) = self.find(table, slot) else {
            // Nothing that is active touches it.
            let group = self.resting.of(slot).filter(|_| table.rests(slot));
            return group.into_iter().flat_map(at_rest).collect();
        };
        let active = table.active().map(|(slot, _)| slot);
        let active = active.filter(|&slot| self.graph.of(slot) == Some(island));
        let groups = self.touched.iter().copied();
        let groups =
            groups.filter(|group| self.graph.of(table.slots() as u32 + group) == Some(island));
        active.chain(groups.flat_map(at_rest)).collect()
    }

    /// What bodies and contacts are solved in the order of.
    pub(crate) fn rank(&self, slot: u32, body: &BodyState) -> (u32, Age) {
        (self.levels.of(slot), body.age)
    }
}

/// First part of the stage: who touches whom, who wakes, and who goes to rest.
pub fn islands(
    mut table: ResMut<BodyTable>,
    mut islands: ResMut<Islands>,
    pairs: Pairs,
    time: Res<StepTime>,
    mut sleepers: Query<&mut Sleeping>,
) {
    let islands = &mut *islands;
    let new = islands.link(&table, &pairs, &time);
    islands.woke = false;
    islands.arriving.clear();
    islands.resting.forget_gone(&table);
    let rests = |(_, body): (_, &BodyState)| body.asleep || body.may_rest();
    if !islands.touched.is_empty() || table.active().any(rests) {
        let awake = islands.find_awake(&table);
        islands.wake(&mut table, &awake, &mut sleepers);
        islands.find_arriving(&table);
        islands.activate_arriving(&mut table);
        islands.tire(&table, &awake);
    }
    let now = table.active().map(Member::of);
    if new || islands.woke || !now.eq(islands.members.iter().copied()) {
        islands.version = next_version();
        islands.members.clear();
        islands.members.extend(table.active().map(Member::of));
    }
}

/// Second part: where bodies or pairs go to rest or are roused, islands are found anew.
pub fn regroup(world: &mut World, pairs: &mut SystemState<Pairs>) {
    let tired = std::mem::take(&mut world.resource_mut::<Islands>().tired);
    if tired.is_empty() && world.resource::<BodyTable>().stirred.is_empty() {
        return;
    }
    rouse(world);
    rest::lay_down(world, tired);
    world.resource_scope(|world, mut islands: Mut<Islands>| {
        let pairs = pairs.get(world).expect("pairs can always be read");
        let table = world.resource::<BodyTable>();
        islands.link(table, &pairs, world.resource::<StepTime>());
        islands.find_arriving(table);
        islands.tired = Tired::default();
        islands.version = next_version();
        islands.members.clear();
        islands.members.extend(table.active().map(Member::of));
    });
}

impl Islands {
    /// Islands sleep and wake as a whole. What is awake, was roused by the user, or is carried by something that moves wakes the rest;
    /// and so does what has parted: what a body lay on, or what held it down, has gone away.
    fn find_awake(&self, table: &BodyTable) -> Vec<bool> {
        let mut awake = vec![false; self.graph.count];
        for (slot, body) in table.active() {
            if let Some(island) = self.graph.of(slot) {
                awake[island] |= !body.asleep || body.roused;
            }
        }
        for Link { slots: [a, b], .. } in &self.links {
            for (carrier, carried) in [(a, b), (b, a)] {
                let (Some(below), Some(above)) = (table.get(*carrier), table.get(*carried)) else {
                    continue;
                };
                // What comes into the world together with its ground may sleep on it.
                let changes = (below.moved || below.renewed) && !(below.arrived && above.arrived);
                let moves =
                    !below.is_dynamic() && (changes || below.velocity != Velocity::default());
                if moves && let Some(island) = self.find(table, *carried) {
                    awake[island] = true;
                }
            }
        }
        for &slot in self.parted.as_flattened() {
            if let Some(island) = self.find(table, slot) {
                awake[island] = true;
            }
        }
        awake
    }

    /// Wakes all bodies of islands that are awake; those that rest are roused next.
    fn wake(&mut self, table: &mut BodyTable, awake: &[bool], sleepers: &mut Query<&mut Sleeping>) {
        let asleep = table.active().filter(|(_, body)| body.asleep);
        let mut rising: Vec<u32> = asleep
            .map(|(slot, _)| slot)
            .filter(|&slot| self.graph.of(slot).is_some_and(|island| awake[island]))
            .collect();
        for i in 0..self.touched.len() {
            let island = self.touched[i];
            let node = table.slots() as u32 + island;
            if self.graph.of(node).is_some_and(|island| awake[island]) {
                for (slot, _) in self.resting.take(table, island) {
                    table.stir(slot);
                    rising.push(slot);
                }
            }
        }
        self.woke = !rising.is_empty();
        for slot in rising {
            let body = table.get_mut(slot).expect("it was just seen");
            body.asleep = false;
            if let Ok(mut sleeping) = sleepers.get_mut(body.entity) {
                sleeping.wake();
            }
        }
    }

    /// Finds islands that sleep and of which bodies have come in this step.
    fn find_arriving(&mut self, table: &BodyTable) {
        self.arriving.clear();
        let comes = |body: &BodyState| body.arrived && body.asleep;
        if !table.active().any(|(_, body)| comes(body)) {
            return;
        }
        self.arriving.resize(self.graph.count, false);
        let mut awake = vec![false; self.graph.count];
        for (slot, body) in table.active() {
            if let Some(island) = self.graph.of(slot) {
                self.arriving[island] |= comes(body);
                awake[island] |= body.is_awake();
            }
        }
        for (arriving, awake) in self.arriving.iter_mut().zip(awake) {
            *arriving &= !awake;
        }
    }

    /// Of what comes onto an island at rest all of it bears a part, and takes part in this step. It sleeps on.
    fn activate_arriving(&mut self, table: &mut BodyTable) {
        for i in 0..self.touched.len() {
            let group = self.touched[i];
            let node = table.slots() as u32 + group;
            if self
                .graph
                .of(node)
                .is_some_and(|island| self.arrives(island))
            {
                for (slot, _) in self.resting.take(table, group) {
                    table.stir(slot);
                }
            }
        }
    }

    /// Finds who may go to rest: islands that sleep, and what stands still. (Pairs of two that rest are found with the links.)
    fn tire(&mut self, table: &BodyTable, awake: &[bool]) {
        let mut rest: Vec<bool> = awake.iter().map(|awake| !awake).collect();
        for (slot, body) in table.active() {
            if let Some(island) = self.graph.of(slot) {
                rest[island] &= body.may_rest();
            } else if body.may_rest() {
                self.tired.bodies.push((slot, body.entity));
            }
        }
        let mut groups: Vec<Vec<(u32, Entity)>> = vec![Vec::new(); rest.len()];
        for (slot, body) in table.active() {
            if let Some(island) = self.graph.of(slot).filter(|&island| rest[island]) {
                groups[island].push((slot, body.entity));
                self.tired.bodies.push((slot, body.entity));
            }
        }
        // What it touches that rests already joins it.
        for i in 0..self.touched.len() {
            let touched = self.touched[i];
            let node = table.slots() as u32 + touched;
            let island = self.graph.of(node).filter(|&island| rest[island]);
            if let Some(group) = island.map(|island| &mut groups[island])
                && !group.is_empty()
            {
                group.extend(self.resting.take(table, touched));
            }
        }
        for group in groups.into_iter().filter(|group| !group.is_empty()) {
            self.resting.insert(group);
        }
    }
}

impl BodyState {
    /// It sleeps or stands still, did so in the step before, and nothing was done to it.
    fn may_rest(&self) -> bool {
        let still = match self.is_dynamic() {
            true => self.asleep && !self.roused,
            false => self.velocity == Velocity::default() && self.target.is_none(),
        };
        let put = self.moved || self.put_from.is_some();
        still && !put && !self.renewed && !self.arrived
    }
}
