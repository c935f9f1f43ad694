//! The stage **islands**: updates islands and levels of support, and [wakes](super::waking) bodies that must not stay asleep. It runs
//! before the forces, so that woken bodies have their full weight in their first solve.
//!
//! Cost: one comparison for each active body, and otherwise work proportional to the number of changes. The narrowphase reports the edges
//! whose contact has begun or ended. Change ticks find contacts that a user has edited. A comparison of the active bodies with those of the
//! last step finds bodies that were added, removed, or changed in kind.

use super::ConstraintGraph;
use super::activation::{Deactivation, activate, deactivate};
use super::forces::Forces;
use super::levels::{Kind, Levels};
use super::partition::Partition;
use super::sleeping::Drifts;
use super::waking::{Accounts, Need, Sleepers, Wakes};
use crate::body::{BodyState, BodyTable, SpawnOrder, cover, written_rows};
use crate::joint_types::JointEdge;
use crate::pair::{LostPairs, PairsRef, Part};
use crate::restored::Restored;
use crate::revision::Revision;
use crate::settings::{Gravity, SleepSettings, StepTime};
use crate::stored::clone_fields;
use bevy_ecs::entity::{Entities, EntityMapper, MapEntities};
use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemState;
use std::fmt;

/// The island, the structure and the level of support of each body: views of the [`ConstraintGraph`].
///
/// A *structure* is a set of dynamic bodies that are connected by links, whether they sleep or not. An *island* is a set of awake bodies
/// that are connected by links between awake bodies: they are solved together. Static, kinematic and sleeping bodies separate islands.
#[derive(Resource, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[component(map_entities)]
pub struct Islands {
    /// Islands. In the step in which sleeping bodies are added, they and the sleeping bodies that they touch are islands too.
    pub(super) partition: Partition,
    pub(super) structures: Partition,
    levels: Levels,
    /// Indexed by slot; includes inactive bodies.
    known: Vec<Option<Known>>,
    /// The active bodies, in the order of their slots.
    active: Vec<Member>,
    revision: Revision,
    recent: Recent,
    pub(super) woke: bool,
    pub(super) deactivation: Deactivation,
    /// Slots of bodies of which a contact has ended, or was removed.
    pub(super) parted: Vec<u32>,
    /// Slots of bodies whose kind has changed, so that others may rest on them no longer.
    pub(super) changed_kind: Vec<u32>,
    /// Slots of the sleeping bodies that get static loads in this step, in order: those that were added, and those connected with them.
    pub(super) loading: Vec<u32>,
    /// By island: its bodies are among those. Empty if there is no such island.
    arriving: Vec<bool>,
    /// Sleeping bodies that awake bodies touch.
    pub(super) boundary: Vec<u32>,
    /// Number of sleeping bodies.
    pub(super) sleepers: usize,
    /// The forces on sleeping bodies that touch awake ones.
    pub(super) accounts: Accounts,
    /// The time since small changes of these forces were last followed, s.
    pub(super) unfollowed: f32,
    /// The drift of bodies that are still, by slot.
    pub(super) drifts: Drifts,
}

clone_fields!(Islands {
    partition,
    structures,
    levels,
    known,
    active,
    revision,
    recent,
    woke,
    deactivation,
    parted,
    changed_kind,
    loading,
    arriving,
    boundary,
    sleepers,
    accounts,
    unfollowed,
    drifts,
});

impl Default for Islands {
    fn default() -> Self {
        Self {
            partition: Partition::with_numbers(),
            structures: Partition::default(),
            levels: Levels::default(),
            known: Vec::new(),
            active: Vec::new(),
            revision: Revision::default(),
            recent: Recent::default(),
            woke: false,
            deactivation: Deactivation::default(),
            parted: Vec::new(),
            changed_kind: Vec::new(),
            loading: Vec::new(),
            arriving: Vec::new(),
            boundary: Vec::new(),
            sleepers: 0,
            accounts: Accounts::default(),
            unfollowed: 0.0,
            drifts: Drifts::default(),
        }
    }
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
        self.revision = Revision::next();
        self.recent.since = None;
        self.partition.mark_all(self.revision);
    }
}

/// The changes since the stage last began, for data that is edited and not derived anew.
#[derive(Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Recent {
    /// [Revision](crate::revision) of all islands when the stage began. `None` if the changes since are not listed.
    pub since: Option<Revision>,
    /// Slots of the bodies whose links, level of support, kind or activity have changed. A slot may be listed several times.
    pub slots: Vec<u32>,
}

clone_fields!(Recent { since, slots });

/// Without what decides only whether data is edited or derived anew, with the same bits.
impl fmt::Debug for Recent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Recent")
            .field("slots", &self.slots)
            .finish_non_exhaustive()
    }
}

/// A body, and whether contacts can move it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Known {
    entity: Entity,
    spawn_order: SpawnOrder,
    dynamic: bool,
    /// Whether it is in an island.
    solved: bool,
}

/// An active body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Member {
    slot: u32,
    body: Known,
    asleep: bool,
}

impl Known {
    /// Returns true if this is the same body, and contacts can move it as before.
    fn is_same(&self, other: &Self) -> bool {
        (self.entity, self.spawn_order, self.dynamic)
            == (other.entity, other.spawn_order, other.dynamic)
    }

    fn sleeps(&self) -> bool {
        self.dynamic && !self.solved
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
    /// Links of bodies that were added to islands, and bodies whose neighbour was removed from them.
    joined: Vec<[u32; 2]>,
    left: Vec<u32>,
    /// Bodies that fell asleep, woke, became inactive, or became active.
    activity_changed: Vec<u32>,
}

impl Islands {
    /// The island of an awake body, by its slot: a number below [`Self::count`]. `None` if the body is not dynamic or sleeps.
    #[inline]
    pub fn of(&self, slot: u32) -> Option<usize> {
        self.partition.number(self.partition.id(slot)?)
    }

    /// Number of islands.
    pub fn count(&self) -> usize {
        self.partition.count()
    }

    /// Level of support: the number of contacts on the shortest way from a body down to a static or kinematic body. `None` if there is no
    /// such way.
    #[inline]
    pub fn level(&self, slot: u32) -> Option<u32> {
        Some(self.levels.of(slot)).filter(|level| *level != Levels::NONE)
    }

    /// The [revision](crate::revision) of an island. It changes with its members and their links.
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

    /// The changes since the stage last began.
    pub(crate) fn recent(&self) -> &Recent {
        &self.recent
    }

    /// Begins a new list of recent changes.
    pub(super) fn begin(&mut self) {
        self.recent.since = Some(self.revision);
        self.recent.slots.clear();
    }

    /// Returns true if the bodies of the island sleep, and some of them were added in this step.
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

    /// Identity of the structure of a dynamic body. It is unique until the next step.
    pub(crate) fn structure_id(&self, slot: u32) -> Option<u32> {
        self.structures.id(slot)
    }

    /// Slots of all bodies in the structure of a dynamic body.
    pub(crate) fn structure(&self, slot: u32) -> &[u32] {
        let structure = self.structures.id(slot);
        structure.map_or(&[], |structure| self.structures.members(structure))
    }

    /// Identity of an awake body's island. It is unique until the next step.
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

    /// Slots of all bodies in an island by its identity.
    pub(crate) fn members_of_id(&self, id: u32) -> &[u32] {
        self.partition.members(id)
    }

    /// Sort key of the order in which bodies and contacts are solved.
    pub(crate) fn rank(&self, slot: u32, body: &BodyState) -> (u32, SpawnOrder) {
        (self.levels.of(slot), body.spawn_order)
    }
}

/// Small changes of the forces on sleeping bodies are followed this often, s.
const FOLLOWING_PERIOD: f32 = 0.25;

/// First part of the stage: updates links and islands, wakes bodies, and finds the bodies and pairs that become inactive.
pub fn islands(
    mut table: ResMut<BodyTable>,
    (mut graph, mut islands, mut wakes): (ResMut<ConstraintGraph>, ResMut<Islands>, ResMut<Wakes>),
    (lost, mut restored): (Res<LostPairs>, ResMut<Restored>),
    (pairs, forces): (PairsRef, Forces),
    (time, settings, gravity): (Res<StepTime>, Res<SleepSettings>, Res<Gravity>),
    (mut sleepers, joints, places): (Sleepers, Query<&'static JointEdge>, &Entities),
) {
    let (graph, islands) = (&mut *graph, &mut *islands);
    islands.begin();
    wakes.begin_run();
    graph.forget(&lost);
    let edited = edited(graph, &pairs, places);
    graph.report(edited);
    std::mem::swap(&mut islands.parted, &mut graph.parted);
    graph.parted.clear();
    islands.changed_kind.clear();
    islands.loading.clear();
    islands.boundary.clear();
    islands.look(graph, &pairs);
    islands.update(graph, &table);
    islands.revise(&std::mem::take(&mut table.solved_anew));
    islands.deactivation.pairs = graph.take_idle(&table, &pairs, &time);
    islands.woke = false;
    let restored = match restored.has_accounts() {
        true => restored.take_accounts(),
        false => Default::default(),
    };
    islands.restore_accounts(&table, &restored);
    let rests = |(_, body): (_, &BodyState)| body.asleep || body.may_rest();
    if table.inactive_count() > 0 || table.active().any(rests) {
        let need = Need {
            graph,
            table: &table,
            forces: &forces,
            sleepers: &sleepers,
            joints: &joints,
            // Before what has been laid on a sleeper sleeps, too.
            interval: (0.5 * settings.delay).min(FOLLOWING_PERIOD),
            speed: settings.linear_speed,
            gravity: gravity.0,
            dt: time.dt,
        };
        let rising = islands.find_rising(&need, settings.waking);
        wakes.record(&table, &rising);
        islands.wake(&mut table, &rising, &mut sleepers);
        let rising = islands.find_loading(graph, &mut table, &restored);
        wakes.record(&table, &rising);
        islands.wake(&mut table, &rising, &mut sleepers);
        islands.find_deactivation(&table);
        // In most steps nothing has changed since the update above, which compares all active bodies.
        if islands.woke || !islands.loading.is_empty() {
            islands.update(graph, &table);
        }
        // Bodies that are loaded count as solved in this step, which closes their accounts.
        islands.restore_accounts(&table, &restored);
    }
    islands.find_arriving();
}

/// Second part of the stage *islands*: makes bodies and pairs inactive or active, and updates the islands accordingly.
pub fn activation(world: &mut World, pairs: &mut SystemState<PairsRef>) {
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
            islands.find_arriving();
        });
    });
}

/// Edges of active contacts whose manifold was written since the stage ran last, by change detection.
fn edited(graph: &ConstraintGraph, pairs: &PairsRef, places: &Entities) -> Vec<(u32, bool)> {
    let mut found = Vec::new();
    let tables = pairs.contiguous_iter();
    for (entities, mut columns) in tables.expect("pair components are stored in tables") {
        for rows in &*graph.active_rows(entities, places) {
            let (pairs, manifolds, ..) = columns.part(rows);
            let written = written_rows(&manifolds);
            found.extend(written.map(|row| (pairs[row].edge, false)));
        }
    }
    found
}

impl Islands {
    /// Checks the reported contacts: whether they link their bodies, and whether those have parted.
    pub(super) fn look(&mut self, graph: &mut ConstraintGraph, pairs: &PairsRef) {
        for (edge, parted) in graph.take_reported() {
            if graph.is_active(edge)
                && let Some(entity) = graph.entity(edge)
                && let Ok((_, (pair, manifold, ..))) = pairs.get(entity)
            {
                if parted {
                    self.parted.extend(pair.slots);
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
        let now = table.active().map(|body| member(body, &self.loading));
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
        self.follow(graph, update);
    }

    /// Takes over inactive bodies that were added or removed between two steps, and their links. Those that were removed have no edges
    /// left.
    pub(crate) fn exchange(
        &mut self,
        graph: &mut ConstraintGraph,
        table: &BodyTable,
        entering: &[u32],
        leaving: &[u32],
    ) {
        self.revision = Revision::next();
        let changes = std::mem::take(&mut graph.changes);
        let mut update = Update {
            linked: changes.linked,
            unlinked: changes.unlinked,
            ..Default::default()
        };
        for &slot in leaving.iter().chain(&changes.gone) {
            self.leave(graph, slot, &mut update);
        }
        for &slot in entering {
            if let Some(body) = table.get(slot) {
                let now = Member {
                    slot,
                    body: known(body, false),
                    asleep: body.asleep,
                };
                self.enter(graph, now, &mut update);
            }
        }
        self.follow(graph, update);
    }

    /// Takes over inactive bodies that were added between two steps: structures, of which each body has its level of support.
    pub(crate) fn add_structures<'a>(
        &mut self,
        table: &BodyTable,
        structures: impl Iterator<Item = &'a [(u32, u32)]>,
    ) {
        self.revision = Revision::next();
        self.recent.since = None;
        let slots = table.slots();
        cover(&mut self.known, slots, None);
        self.levels.cover(slots);
        self.structures.cover(slots);
        // These bodies are added to it when they wake.
        self.partition.cover(slots);
        for structure in structures {
            let mut dynamic = Vec::with_capacity(structure.len());
            for &(slot, level) in structure {
                let Some(body) = table.get(slot).map(|body| known(body, false)) else {
                    continue;
                };
                self.known[slot as usize] = Some(body);
                self.levels.put(slot, level);
                if body.dynamic {
                    dynamic.push(slot);
                }
            }
            self.sleepers += dynamic.len();
            self.structures.insert_all(dynamic);
        }
    }

    /// Brings levels, structures and islands up to date.
    fn follow(&mut self, graph: &ConstraintGraph, update: Update) {
        let Update {
            linked,
            unlinked,
            renewed,
            mut ends,
            joined,
            left,
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
        ends.extend(unlinked.as_flattened());
        self.structures.take_in(linked.iter());
        self.partition.take_in(linked.iter().chain(&joined));
        for &slots in &linked {
            self.structures.link(slots);
        }
        self.structures.split(graph, &ends);
        for &slots in linked.iter().chain(&joined) {
            self.partition.link(slots);
        }
        ends.extend(left);
        self.partition.split(graph, &ends);
        self.partition.renumber();
        // Levels also change by links of sleeping bodies, which are in no island.
        let slots = linked.iter().chain(&joined).flatten().chain(&ends);
        let slots = slots.chain(&renewed).chain(&activity_changed);
        for &slot in slots.chain(self.levels.changed()) {
            self.partition.mark(slot, self.revision);
            self.recent.slots.push(slot);
        }
    }

    /// Takes over which bodies are active, and their kind.
    fn follow_bodies(&mut self, graph: &ConstraintGraph, table: &BodyTable, update: &mut Update) {
        let before = std::mem::take(&mut self.active);
        let now = table.active().map(|body| member(body, &self.loading));
        self.active.extend(now);
        for was in before.iter().filter(|was| table.is_inactive(was.slot)) {
            match table.get(was.slot).map(|body| known(body, false)) {
                Some(body) if body.is_same(&was.body) => {
                    self.set_solved(graph, was.slot, false, update);
                    update.activity_changed.push(was.slot);
                }
                _ => self.leave(graph, was.slot, update),
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
                Some(body) if body.is_same(&now.body) => {
                    self.set_solved(graph, now.slot, now.body.solved, update);
                    update.activity_changed.push(now.slot);
                }
                Some(_) => {
                    self.changed_kind.push(now.slot);
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
        self.known[slot as usize] = Some(Known {
            solved: false,
            ..body
        });
        update.renewed.push(slot);
        if body.dynamic {
            self.sleepers += 1;
            self.structures.insert(slot);
            let links = graph.neighbours(slot).map(|other| [slot, other]);
            update.linked.extend(links);
        }
        self.set_solved(graph, slot, body.solved, update);
    }

    /// Removes a body, or a body whose kind has changed.
    fn leave(&mut self, graph: &ConstraintGraph, slot: u32, update: &mut Update) {
        self.set_solved(graph, slot, false, update);
        let known = self.known.get_mut(slot as usize);
        if let Some(body) = known.and_then(Option::take) {
            self.sleepers -= usize::from(body.sleeps());
            self.accounts.close(slot);
            self.drifts.forget(slot);
            update.renewed.push(slot);
            if body.dynamic {
                update.ends.extend(graph.neighbours(slot));
                self.structures.remove(slot);
            }
        }
    }

    /// Adds a dynamic body to the islands, or removes it.
    fn set_solved(
        &mut self,
        graph: &ConstraintGraph,
        slot: u32,
        solved: bool,
        update: &mut Update,
    ) {
        let known = self.known.get_mut(slot as usize);
        let known = known.and_then(Option::as_mut);
        let Some(body) = known.filter(|body| body.solved != solved) else {
            return;
        };
        body.solved = solved;
        match solved {
            true => {
                self.sleepers -= 1;
                self.accounts.close(slot);
                self.partition.insert(slot);
                let links = graph.neighbours(slot).map(|other| [slot, other]);
                update.joined.extend(links);
            }
            false => {
                self.sleepers += 1;
                update.left.extend(graph.neighbours(slot));
                self.partition.remove(slot);
            }
        }
    }

    /// Finds the islands of sleeping bodies that get static loads.
    fn find_arriving(&mut self) {
        self.arriving.clear();
        if self.loading.is_empty() {
            return;
        }
        let islands = self.partition.numbered().iter();
        let first = islands.map(|&island| self.partition.members(island)[0]);
        self.arriving
            .extend(first.map(|slot| is_among(&self.loading, slot)));
    }
}

/// Whether a slot is among others that are in order.
#[inline]
pub(super) fn is_among(slots: &[u32], slot: u32) -> bool {
    slots.binary_search(&slot).is_ok()
}

/// A body as islands see it. `solved` says whether it is in an island.
#[inline]
fn known(body: &BodyState, solved: bool) -> Known {
    Known {
        entity: body.entity,
        spawn_order: body.spawn_order,
        dynamic: body.is_dynamic(),
        solved,
    }
}

/// An active body as islands see it, where these sleeping bodies get static loads.
#[inline]
fn member((slot, body): (u32, &BodyState), loading: &[u32]) -> Member {
    let solved = body.is_awake() || body.is_dynamic() && is_among(loading, slot);
    Member {
        slot,
        body: known(body, solved),
        asleep: body.asleep,
    }
}

impl ConstraintGraph {
    /// Takes the pairs that become inactive after their bodies. Nothing about them changes any more.
    pub(super) fn take_idle(
        &mut self,
        table: &BodyTable,
        pairs: &PairsRef,
        time: &StepTime,
    ) -> Vec<(u32, [u32; 2])> {
        let mut idle = Vec::new();
        let mut settling = std::mem::take(&mut self.settling);
        settling.retain(|&(edge, entity)| {
            let pair = pairs.get(entity).ok();
            let pair = pair.filter(|_| self.entity(edge) == Some(entity) && self.is_active(edge));
            let Some((_, (pair, ..))) = pair else {
                return false;
            };
            if !pair.slots.iter().all(|&slot| table.is_inactive(slot)) {
                return false;
            }
            // Contact events are sent at the end of a whole step, so a pair may become inactive only in the first substep of the next.
            let settled = pair.is_idle() && time.substep == 0;
            if settled {
                idle.push((edge, pair.slots));
            }
            !settled
        });
        self.settling = settling;
        idle
    }
}
