//! The stage **islands**: updates islands and levels of support, and wakes islands that must not stay asleep. It runs before the forces, so
//! that woken bodies have their full weight in their first solve.
//!
//! Cost: one comparison for each active body, and otherwise work proportional to the number of changes. The narrowphase reports the edges
//! whose contact has begun or ended. Change ticks find contacts that a user has edited. A comparison of the active bodies with those of the
//! last step finds bodies that were added, removed, or changed in kind.

use super::ConstraintGraph;
use super::activation::{Deactivation, activate, deactivate};
use super::levels::{Kind, Levels};
use super::partition::Partition;
use crate::body::{BodyState, BodyTable, Inactive, Sleeping, SpawnOrder};
use crate::contact::{ContactPair, LostPairs, Manifold};
use crate::revision::Revision;
use crate::settings::StepTime;
use bevy_ecs::change_detection::Tick;
use bevy_ecs::entity::{EntityMapper, MapEntities};
use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemState;
use bevy_reflect::Reflect;
use fixedbitset::FixedBitSet;

/// The island and the level of support of each body: views of the [`ConstraintGraph`].
#[derive(Resource, Clone, Debug, Default, Reflect)]
#[reflect(opaque)]
#[component(map_entities)]
pub struct Islands {
    pub(super) partition: Partition,
    levels: Levels,
    /// Indexed by slot; includes inactive bodies.
    known: Vec<Option<Known>>,
    /// The active bodies, in the order of their slots.
    active: Vec<Member>,
    revision: Revision,
    recent: Recent,
    pub(super) woke: bool,
    pub(super) deactivation: Deactivation,
    /// Pairs of slots of bodies that touched in the last step and no longer do.
    pub(super) parted: Vec<[u32; 2]>,
    /// By island: it sleeps, and some of its bodies were added in this step. Empty if there is no such island.
    pub(super) arriving: Vec<bool>,
    /// Scratch: islands that are awake, by their id, and those of which not all may go to rest.
    pub(super) awake: FixedBitSet,
    pub(super) restless: FixedBitSet,
}

impl MapEntities for Islands {
    fn map_entities<M: EntityMapper>(&mut self, mapper: &mut M) {
        let known = self.known.iter_mut().flatten();
        let active = self.active.iter_mut().map(|member| &mut member.body);
        for body in known.chain(active) {
            body.entity.map_entities(mapper);
        }
        for (_, body) in &mut self.deactivation.bodies {
            body.map_entities(mapper);
        }
        for (pair, _) in &mut self.deactivation.pairs {
            pair.map_entities(mapper);
        }
        self.revision = Revision::next();
        self.recent.since = None;
        self.partition.mark_all(self.revision);
    }
}

/// What has changed since the stage last began, for data that is edited and not derived anew.
#[derive(Clone, Debug, Default)]
pub(crate) struct Recent {
    /// [Revision](crate::revision) of all islands when the stage began. `None` if the changes since are not listed.
    pub since: Option<Revision>,
    /// Slots of the bodies whose links, level of support, kind or activity have changed. A slot may be listed several times.
    pub slots: Vec<u32>,
}

/// A body, and whether contacts can move it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Known {
    entity: Entity,
    spawn_order: SpawnOrder,
    dynamic: bool,
}

/// An active body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Member {
    slot: u32,
    body: Known,
    asleep: bool,
}

impl Known {
    #[inline]
    fn of(body: &BodyState) -> Self {
        Self {
            entity: body.entity,
            spawn_order: body.spawn_order,
            dynamic: body.is_dynamic(),
        }
    }
}

impl Member {
    #[inline]
    fn of((slot, body): (u32, &BodyState)) -> Self {
        Self {
            slot,
            body: Known::of(body),
            asleep: body.asleep,
        }
    }
}

/// Working data of an update.
#[derive(Default)]
struct Update {
    linked: Vec<[u32; 2]>,
    unlinked: Vec<[u32; 2]>,
    /// Slots that now hold another body, a body of another kind, or no body.
    renewed: Vec<u32>,
    /// Bodies that have lost a link.
    ends: Vec<u32>,
    /// Bodies that fell asleep, woke, became inactive, or became active.
    activity_changed: Vec<u32>,
}

/// The active pairs.
pub(super) type Pairs<'w, 's> =
    Query<'w, 's, (Entity, &'static ContactPair, Ref<'static, Manifold>), Without<Inactive>>;

impl Islands {
    /// The island of a dynamic body, by its slot: a number below [`Self::count`]. `None` if the body is not dynamic or its island is inactive.
    #[inline]
    pub fn of(&self, slot: u32) -> Option<usize> {
        self.partition.number(self.partition.id(slot)?)
    }

    /// Number of islands that have active bodies; [inactive](Inactive) islands are not counted.
    pub fn count(&self) -> usize {
        self.partition.count()
    }

    /// Level of support: the number of contacts on the shortest way from a body down to a static or kinematic body. `None` if there is no such
    /// way.
    #[inline]
    pub fn level(&self, slot: u32) -> Option<u32> {
        Some(self.levels.of(slot)).filter(|level| *level != Levels::NONE)
    }

    /// The [revision](crate::revision) of an island. It changes with its members, its links, and which of its bodies sleep.
    pub fn revision_of(&self, island: usize) -> Revision {
        self.partition.revision(self.partition.numbered()[island])
    }

    /// The [revision](crate::revision) of an island by its [identity](Self::id), or `None` if it has no number.
    pub(crate) fn revision_of_id(&self, id: u32) -> Option<Revision> {
        let exists = (id as usize) < self.partition.ids() && self.partition.number(id).is_some();
        exists.then(|| self.partition.revision(id))
    }

    /// The [revision](crate::revision) of all islands. It changes whenever a link or the activity of a body changes.
    pub fn revision(&self) -> Revision {
        self.revision
    }

    /// What has changed since the stage last began.
    pub(crate) fn recent(&self) -> &Recent {
        &self.recent
    }

    /// Begins a new list of recent changes.
    pub(super) fn begin(&mut self) {
        self.recent.since = Some(self.revision);
        self.recent.slots.clear();
    }

    /// Returns true if the island sleeps and some of its bodies were added in this step.
    pub(crate) fn arrives(&self, island: usize) -> bool {
        self.arriving.get(island).copied().unwrap_or(false)
    }

    /// Returns true if [`Self::arrives`] holds for some island.
    pub(crate) fn any_arrives(&self) -> bool {
        self.arriving.contains(&true)
    }

    /// Returns true if a body was woken in this step.
    pub(crate) fn woke(&self) -> bool {
        self.woke
    }

    /// Identity of a dynamic body's island, whether awake, asleep or inactive. It is unique until the next step.
    pub(crate) fn id(&self, slot: u32) -> Option<u32> {
        self.partition.id(slot)
    }

    /// Upper bound of identities: all identities in use are below it.
    pub(crate) fn ids(&self) -> usize {
        self.partition.ids()
    }

    /// Identities of the islands that have a number, by number.
    pub(crate) fn numbered(&self) -> &[u32] {
        self.partition.numbered()
    }

    /// Slots of all bodies in an island by its identity, whether awake, asleep or inactive.
    pub(crate) fn members_of_id(&self, id: u32) -> &[u32] {
        self.partition.members(id)
    }

    /// Slots of all bodies in the island of a dynamic body, whether awake, asleep or inactive.
    pub(crate) fn members(&self, slot: u32) -> &[u32] {
        let island = self.partition.id(slot);
        island.map_or(&[], |island| self.partition.members(island))
    }

    /// Sort key of the order in which bodies and contacts are solved.
    pub(crate) fn rank(&self, slot: u32, body: &BodyState) -> (u32, SpawnOrder) {
        (self.levels.of(slot), body.spawn_order)
    }
}

/// First part of the stage: updates links and islands, wakes islands, and finds the bodies and pairs that become inactive.
pub fn islands(
    mut table: ResMut<BodyTable>,
    (mut graph, mut islands): (ResMut<ConstraintGraph>, ResMut<Islands>),
    lost: Res<LostPairs>,
    pairs: Pairs,
    time: Res<StepTime>,
    mut sleepers: Query<&mut Sleeping>,
) {
    let (graph, islands) = (&mut *graph, &mut *islands);
    islands.begin();
    graph.forget(&lost);
    graph.report(edited(&pairs));
    islands.parted.clear();
    islands.look(graph, &pairs);
    islands.update(graph, &table);
    islands.revise(&std::mem::take(&mut table.solved_anew));
    islands.deactivation.pairs = graph.take_idle(&table, &pairs, &time);
    islands.woke = false;
    islands.arriving.clear();
    let rests = |(_, body): (_, &BodyState)| body.asleep || body.may_rest();
    if table.inactive_count() > 0 || table.active().any(rests) {
        let awake = islands.find_awake(graph, &table);
        islands.wake(&mut table, &awake, &mut sleepers);
        islands.find_arriving(&table);
        islands.activate_arriving(&mut table);
        islands.find_deactivation(&table, &awake);
        islands.awake = awake;
        islands.update(graph, &table);
    }
}

/// Second part of the stage *islands*: makes bodies and pairs inactive or active, and updates the islands accordingly.
pub fn activation(world: &mut World, pairs: &mut SystemState<Pairs>) {
    let deactivation = std::mem::take(&mut world.resource_mut::<Islands>().deactivation);
    if deactivation.is_empty() && world.resource::<BodyTable>().dirty.is_empty() {
        return;
    }
    activate(world);
    deactivate(world, deactivation);
    world.resource_scope(|world, mut graph: Mut<ConstraintGraph>| {
        world.resource_scope(|world, mut islands: Mut<Islands>| {
            let pairs = pairs.get(world).expect("pairs can always be read");
            let table = world.resource::<BodyTable>();
            islands.look(&mut graph, &pairs);
            islands.update(&mut graph, table);
            islands.find_arriving(table);
        });
    });
}

/// Edges of contacts whose manifold was written since the stage ran last, by change detection.
fn edited(pairs: &Pairs) -> Vec<(u32, bool)> {
    /// Ticks are compared in chunks without a branch, so that the compiler vectorizes the common case in which nothing was written.
    const CHUNK: usize = 64;
    let mut found = Vec::new();
    let tables = pairs.contiguous_iter();
    for (_, pairs, manifolds) in tables.expect("pair components are stored in tables") {
        let (last, this) = (manifolds.last_run_tick(), manifolds.this_run_tick());
        let is_new = |tick: &Tick| tick.is_newer_than(last, this);
        let chunks = manifolds.changed_ticks_slice().chunks(CHUNK);
        for (ticks, pairs) in chunks.zip(pairs.chunks(CHUNK)) {
            if ticks.iter().fold(false, |any, tick| any | is_new(tick)) {
                let new = ticks.iter().zip(pairs).filter(|(tick, _)| is_new(tick));
                found.extend(new.map(|(_, pair)| (pair.edge, false)));
            }
        }
    }
    found
}

impl Islands {
    /// Checks the reported contacts: whether they link their bodies, and whether those have parted.
    pub(super) fn look(&mut self, graph: &mut ConstraintGraph, pairs: &Pairs) {
        for (edge, parted) in graph.take_reported() {
            if let Some(entity) = graph.entity(edge)
                && let Ok((_, pair, manifold)) = pairs.get(entity)
            {
                if parted {
                    self.parted.push(pair.slots);
                }
                graph.set_links(edge, !manifold.points.is_empty());
            }
        }
    }

    /// Gives the islands of bodies a new revision, because their contacts are solved in another way.
    fn revise(&mut self, slots: &[u32]) {
        if slots.is_empty() {
            return;
        }
        self.revision = Revision::next();
        self.recent.since = None;
        for &slot in slots {
            self.partition.mark(slot, self.revision);
        }
    }

    /// Takes over the changes in the graph and among the active bodies.
    pub(super) fn update(&mut self, graph: &mut ConstraintGraph, table: &BodyTable) {
        let now = table.active().map(Member::of);
        let same = now.eq(self.active.iter().copied());
        if same && graph.changes.is_empty() {
            return;
        }
        self.revision = Revision::next();
        let changes = std::mem::take(&mut graph.changes);
        let mut update = Update {
            linked: changes.linked,
            unlinked: changes.unlinked,
            ..Default::default()
        };
        for slot in changes.gone {
            self.leave(graph, slot, &mut update);
        }
        if !same {
            self.follow_bodies(graph, table, &mut update);
        }
        let Update {
            linked,
            unlinked,
            renewed,
            mut ends,
            activity_changed,
        } = update;
        let known = &self.known;
        let kind = |slot: u32| match known.get(slot as usize).copied().flatten() {
            None => Kind::Empty,
            Some(body) if body.dynamic => Kind::Dynamic,
            Some(_) => Kind::Fixed,
        };
        self.levels
            .update(graph, kind, [&linked, &unlinked], &renewed);
        for &slots in &linked {
            self.partition.link(slots);
        }
        ends.extend(unlinked.as_flattened());
        self.partition.split(graph, &ends);
        self.partition.renumber();
        let slots = linked.as_flattened().iter().chain(&ends);
        for &slot in slots.chain(&renewed).chain(&activity_changed) {
            self.partition.mark(slot, self.revision);
            self.recent.slots.push(slot);
        }
        self.recent.slots.extend_from_slice(self.levels.changed());
    }

    /// Takes over which bodies are active, and their kind.
    fn follow_bodies(&mut self, graph: &ConstraintGraph, table: &BodyTable, update: &mut Update) {
        let before = std::mem::take(&mut self.active);
        self.active.extend(table.active().map(Member::of));
        for member in before
            .iter()
            .filter(|member| table.is_inactive(member.slot))
        {
            match table.get(member.slot).map(Known::of) {
                Some(body) if body == member.body => {
                    self.partition.set_active(member.slot, false);
                    update.activity_changed.push(member.slot);
                }
                _ => self.leave(graph, member.slot, update),
            }
        }
        // Both lists are in the order of slots.
        let mut before = before.into_iter().peekable();
        for i in 0..self.active.len() {
            let now = self.active[i];
            while before.next_if(|was| was.slot < now.slot).is_some() {}
            if before.peek() == Some(&now) {
                continue;
            }
            match self.known.get(now.slot as usize).copied().flatten() {
                Some(body) if body == now.body => {
                    self.partition.set_active(now.slot, true);
                    update.activity_changed.push(now.slot);
                }
                Some(_) => {
                    self.leave(graph, now.slot, update);
                    self.enter(graph, now, update);
                }
                None => self.enter(graph, now, update),
            }
        }
    }

    /// Adds a body.
    fn enter(&mut self, graph: &ConstraintGraph, now: Member, update: &mut Update) {
        let Member { slot, body, .. } = now;
        if self.known.len() <= slot as usize {
            self.known.resize(slot as usize + 1, None);
        }
        self.known[slot as usize] = Some(body);
        update.renewed.push(slot);
        if body.dynamic {
            self.partition.insert(slot);
            let links = graph.neighbours(slot).map(|other| [slot, other]);
            update.linked.extend(links);
        }
    }

    /// Removes a body, or a body whose kind has changed.
    fn leave(&mut self, graph: &ConstraintGraph, slot: u32, update: &mut Update) {
        let known = self.known.get_mut(slot as usize);
        if let Some(body) = known.and_then(Option::take) {
            update.renewed.push(slot);
            if body.dynamic {
                update.ends.extend(graph.neighbours(slot));
                self.partition.remove(slot);
            }
        }
    }
}

impl ConstraintGraph {
    /// Takes the pairs that become inactive after their bodies. Nothing about them changes any more.
    pub(super) fn take_idle(
        &mut self,
        table: &BodyTable,
        pairs: &Pairs,
        time: &StepTime,
    ) -> Vec<(Entity, [u32; 2])> {
        let mut idle = Vec::new();
        let mut settling = std::mem::take(&mut self.settling);
        settling.retain(|&(edge, entity)| {
            let pair = pairs.get(entity).ok();
            let pair = pair.filter(|_| self.entity(edge) == Some(entity));
            let Some((_, pair, _)) = pair else {
                return false;
            };
            if !pair.slots.iter().all(|&slot| table.is_inactive(slot)) {
                return false;
            }
            // Contact events are sent at the end of a whole step, so a pair may become inactive only in the first substep of the next.
            let settled = pair.is_idle() && time.substep == 0;
            if settled {
                idle.push((entity, pair.slots));
            }
            !settled
        });
        self.settling = settling;
        idle
    }
}
