//! Begin and end of contact edges: the second half of the stage *broadphase*.
//!
//! The broadphase finds which boxes overlap. This module spawns a [`ContactPair`] entity and its edge when two boxes begin to overlap. It
//! despawns the pair when they cease to overlap, when one of the bodies was removed, or when the two may no longer collide. Pairs that a
//! user despawned, or removed components from, are made anew.

use super::ConstraintGraph;
use super::activation::activate;
use super::active::find_active_rows;
use super::edges::EdgeKind;
use super::room::with_room;
use crate::body::{BodyState, BodyTable, SpawnOrder};
use crate::broadphase::{Broadphase, Reach};
use crate::diagnosis::{BodyProblem, EXTREME_MASS_RATIO, FoundProblems};
use crate::pair::{
    ContactAnchors, ContactImpulses, ContactPair, ContactTargets, EndedPairs, LostPairs, Manifold,
    NarrowphaseCache, PairParts,
};
use crate::restored::{Restored, RestoredContacts};
use crate::revision::Revision;
use crate::solver::{Both, sort};
use bevy_ecs::entity::EntityHashSet;
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::prelude::*;
use bevy_platform::collections::HashSet;

/// Remains of a pair that a user has taken apart.
type Broken = (
    Or<(
        (
            With<ContactPair>,
            Or<(
                Without<Manifold>,
                Without<ContactTargets>,
                Without<ContactImpulses>,
                Without<ContactAnchors>,
                Without<NarrowphaseCache>,
                With<Disabled>,
            )>,
        ),
        // Identified by the private component: a manifold alone may be a user's own copy.
        (Without<ContactPair>, With<NarrowphaseCache>),
    )>,
    Allow<Disabled>,
);

/// Despawns the pairs that ended and spawns those that began. Activates bodies that touched a body that was removed.
pub fn pair_changes(
    world: &mut World,
    mut ending: Local<Vec<Entity>>,
    broken: &mut QueryState<Entity, Broken>,
) {
    let restored = world.resource_mut::<Restored>().take_contacts();
    ending.clear();
    ending.extend(broken.iter(world));
    let broadphase = world.resource::<Broadphase>();
    let is_same = broadphase.found.is_empty() && broadphase.waiting.is_empty();
    if is_same && world.resource::<LostPairs>().0.is_empty() && ending.is_empty() {
        find_active_rows(world);
        return;
    }
    let found = std::mem::take(&mut world.resource_mut::<Broadphase>().found);
    let (table, graph) = (
        world.resource::<BodyTable>(),
        world.resource::<ConstraintGraph>(),
    );
    let broadphase = world.resource::<Broadphase>();
    let lives = |pair: &ContactPair, i: usize| {
        let body = table.get(pair.slots[i]);
        body.is_some_and(|body| pair.is_of(i, body))
    };
    let goes_on = |pair: &ContactPair| {
        lives(pair, 0) && lives(pair, 1) && broadphase.overlap(table, pair.slots)
    };
    let disturbed = found.disturbed.iter();
    let disturbed = disturbed.flat_map(|&slot| graph.contact_ends(slot));
    let doubtful = disturbed.filter(|&(_, slots)| !broadphase.still_overlap(table, slots));
    let doubtful = doubtful.map(|(pair, _)| pair);
    let ended = doubtful.filter(|&pair| {
        let pair = world.get::<ContactPair>(pair);
        pair.is_some_and(|pair| !goes_on(pair))
    });
    ending.extend(ended);
    for pair in ending.drain(..) {
        world.try_despawn(pair).ok();
    }

    let lost = std::mem::take(&mut *world.resource_mut::<LostPairs>());
    let new = world.resource_scope(|world, mut graph: Mut<ConstraintGraph>| {
        graph.forget(&lost);
        let again = world.resource_scope(|world, broadphase: Mut<Broadphase>| {
            let mut table = world.resource_mut::<BodyTable>();
            give_up(&mut table, &broadphase, &lost, &mut graph.parted)
        });
        for &slot in &found.removed {
            // A slot can be reused only from here on: no pair refers to it any more.
            world.resource_mut::<BodyTable>().recycle(slot);
            graph.changes.gone.push(slot);
        }
        let waiting = std::mem::take(&mut world.resource_mut::<Broadphase>().waiting);
        let overlaps = found.overlaps.into_iter().chain(waiting).chain(again);
        begin(world, &mut graph, overlaps, &restored)
    });
    spawn(world, new, restored);
    tell(world, &lost);
    activate(world);
    find_active_rows(world);
}

/// Ends pairs whose bodies no longer collide, after the *broadphase*.
pub(crate) fn end_pairs(world: &mut World, pairs: &EntityHashSet) {
    for &pair in pairs {
        world.try_despawn(pair).ok();
    }
    // Those that a user has despawned are left to the next *broadphase*.
    let all = &mut world.resource_mut::<LostPairs>().0;
    let lost = LostPairs(
        all.extract_if(.., |(pair, _)| pairs.contains(pair))
            .collect(),
    );
    world.resource_mut::<ConstraintGraph>().forget(&lost);
    tell(world, &lost);
    find_active_rows(world);
}

/// Notes that [`ContactEnded`](crate::contact::ContactEnded) must be sent for lost pairs.
fn tell(world: &mut World, lost: &LostPairs) {
    let told = lost.0.iter().filter(|(_, pair)| pair.announced());
    let told = told.map(|(_, pair)| (pair.spawn_orders, pair.bodies));
    world.resource_mut::<EndedPairs>().0.extend(told);
}

/// Activates the bodies that touched in lost pairs, and notes that they have parted. Returns the slots of the pairs that must be made anew.
fn give_up(
    table: &mut BodyTable,
    broadphase: &Broadphase,
    lost: &LostPairs,
    parted: &mut Vec<u32>,
) -> Vec<[u32; 2]> {
    let mut again = Vec::new();
    for (_, pair) in &lost.0 {
        let alive = [0, 1].both(|i| {
            let slot = pair.slots[i];
            let body = table.get_mut(slot).filter(|body| pair.is_of(i, body));
            let dynamic = body.map(|body| {
                body.disturbed |= pair.touching;
                body.is_dynamic()
            });
            if pair.touching && dynamic == Some(true) {
                table.mark_dirty(slot);
                parted.push(slot);
            }
            dynamic.is_some()
        });
        if alive == [true; 2] && broadphase.overlap(table, pair.slots) {
            again.push(pair.slots);
        }
    }
    again
}

/// Makes pairs and their edges for overlaps that have none, in order. Those of fast bodies that are far apart wait.
fn begin(
    world: &mut World,
    graph: &mut ConstraintGraph,
    overlaps: impl Iterator<Item = [u32; 2]>,
    restored: &RestoredContacts,
) -> Vec<ContactPair> {
    let reach = Reach::of(world);
    let table = world.resource::<BodyTable>();
    let broadphase = world.resource::<Broadphase>();
    let mut waiting = Vec::new();
    let near = graph.unknown(overlaps).filter(|&slots| {
        let is_far = broadphase.is_far(table, slots, &reach);
        if is_far {
            waiting.push(slots);
        }
        !is_far
    });
    let mut overlaps: Vec<([SpawnOrder; 2], [u32; 2])> = near
        .filter_map(|slots| Some((table.both(slots)?.both(|body| body.spawn_order), slots)))
        .collect();
    world.resource_mut::<Broadphase>().waiting = waiting;
    let mut new: Vec<ContactPair> = Vec::new();
    if overlaps.is_empty() {
        return new;
    }
    let table = world.resource::<BodyTable>();
    // The tree's shape depends on its history; the order of pairs must not. A pair that a user has despawned may be there twice.
    sort::by_key(&mut overlaps, |&(orders, [a, b])| {
        (orders, u64::from(a) << 32 | u64::from(b))
    });
    overlaps.dedup();
    graph.reserve(overlaps.len(), table.slots());
    let mut warnings = Vec::new();
    let revision = Revision::next();
    for (_, slots) in overlaps {
        if let Some(bodies) = table.both(slots) {
            warn(bodies, &mut warnings);
            let edge = graph.insert(EdgeKind::Contact, slots);
            let mut pair = ContactPair::new(edge, slots, bodies, revision);
            restored.mark(&mut pair);
            new.push(pair);
        }
    }
    report(world, warnings);
    new
}

/// Spawns new pairs, and names their edges. Observers of pairs may use the graph.
fn spawn(world: &mut World, new: Vec<ContactPair>, restored: RestoredContacts) {
    if new.is_empty() {
        return;
    }
    let edges: Vec<_> = new.iter().map(|pair| (pair.edge, pair.slots)).collect();
    // The required components are in the bundle, so that none is made one by one.
    let new = new.into_iter();
    let new = new.map(|pair| (pair, PairParts::default()));
    let count = new.len();
    let spawned: Vec<Entity> = world.spawn_batch(with_room(new, count)).collect();
    restored.fill(world, &spawned);
    world.resource_scope(|world, mut graph: Mut<ConstraintGraph>| {
        let table = world.resource::<BodyTable>();
        for ((edge, slots), pair) in edges.into_iter().zip(spawned) {
            graph.name(edge, pair);
            if slots.into_iter().all(|slot| table.is_inactive(slot)) {
                graph.settling.push((edge, pair));
            }
        }
    });
}

/// Reports warnings about new pairs, in the order of the pairs. Each of many bodies in one place is named only once.
pub(crate) fn report(world: &mut World, mut warnings: Vec<(Entity, BodyProblem)>) {
    let mut named = HashSet::<Entity>::default();
    warnings.retain(|(body, problem)| {
        !matches!(problem, BodyProblem::Coincident { .. }) || named.insert(*body)
    });
    world.resource_mut::<FoundProblems>().0.extend(warnings);
}

impl ConstraintGraph {
    /// Removes the edges of lost pairs.
    pub(super) fn forget(&mut self, lost: &LostPairs) {
        for (entity, pair) in &lost.0 {
            self.remove(pair.edge, *entity);
        }
    }
}

/// Collects warnings about a new pair of dynamic bodies: an extreme mass ratio, or the same centre of mass.
pub(crate) fn warn([a, b]: [&BodyState; 2], warnings: &mut Vec<(Entity, BodyProblem)>) {
    if !a.is_dynamic() || !b.is_dynamic() {
        return;
    }
    let ratio = a.mass.inverse_mass / b.mass.inverse_mass;
    // A body that dominates counts as infinitely heavy.
    let counts = !a.dominates(b) && !b.dominates(a);
    if counts && !(EXTREME_MASS_RATIO.recip()..=EXTREME_MASS_RATIO).contains(&ratio) {
        let (heavy, light) = if ratio < 1.0 { (a, b) } else { (b, a) };
        warnings.push((
            heavy.entity,
            BodyProblem::ExtremeMassRatio {
                other: light.entity,
            },
        ));
    }
    if (a.center - b.center).length() <= 1e-6 * a.radius.min(b.radius) {
        warnings.push((b.entity, BodyProblem::Coincident { other: a.entity }));
    }
}
