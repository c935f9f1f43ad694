//! Crowds: bodies that overlap so many others that no solver could part all of them at once.
//!
//! A thousand bricks in one cubic metre meet in half a million pairs. A body can follow only a few of its contacts: when it has left the
//! deepest one, the others have changed. A pair therefore has contacts only while it is among the [`MAX_DEEP_PAIRS`] deepest pairs of one
//! of its two bodies. The other pairs have none, and are checked again some steps later.
//!
//! Only overlaps deeper than those in any structure count, so that bodies on a large floor or in a bowl are not a crowd.

use super::is_idle;
use crate::body::BodyTable;
use crate::diagnosis::{BodyProblem, FoundProblems, ReportedProblems};
use crate::graph::ConstraintGraph;
use crate::pair::{ContactPair, Manifold, Origins, PairState, PairsMut, Part, reorder};
use crate::revision::Revision;
use crate::settings::StepTime;
use crate::solver::{Both, sort};
use bevy_ecs::entity::Entities;
use bevy_ecs::prelude::*;

/// Number of deep pairs of a body that always have contacts.
pub(crate) const MAX_DEEP_PAIRS: usize = 16;

/// Pairs without contacts are checked again after this number of steps, spread evenly so that no step has all of them.
const STEPS_BETWEEN_CHECKS: u64 = 8;

/// Overlap from which on a pair is deep, as a share of the smaller body's size.
const DEEP_OVERLAP: f32 = 0.1;

/// A deep pair. They are ordered by depth, deepest first.
struct DeepPair {
    depth: f32,
    pair: Entity,
    slots: [u32; 2],
}

/// Removes the contacts of pairs that are not among the deepest of either body; a part of the stage *narrowphase*.
pub fn crowd(
    (table, mut graph, time): (Res<BodyTable>, ResMut<ConstraintGraph>, Res<StepTime>),
    places: &Entities,
    mut pairs: PairsMut,
    (mut suspects, mut told): (ResMut<FoundProblems>, ResMut<ReportedProblems>),
) {
    let is_crowded = |slot: u32| graph.edges_of(slot).len() > MAX_DEEP_PAIRS;
    let any = table
        .active()
        .any(|(slot, body)| body.is_awake() && is_crowded(slot));
    if !any {
        told.crowded = false;
        return;
    }
    let mut deep = find_deep(&table, &graph, places, &mut pairs);
    let spawn_order = |slot: u32| table.get(slot).map(|body| body.spawn_order);
    // The order must not depend on the entities of pairs.
    sort::by_key(&mut deep, |pair| {
        let [a, b] = pair.slots.both(spawn_order);
        (-pair.depth, a.unwrap_or_default(), b.unwrap_or_default())
    });
    let mut counts = vec![0usize; table.slots()];
    deep.retain(|pair| {
        let counts_for = pair.slots.both(|slot| {
            counts[slot as usize] += 1;
            counts[slot as usize] <= MAX_DEEP_PAIRS
        });
        counts_for == [false; 2]
    });
    // If no pair exceeds the limit, pairs of the crowd may still wait.
    let Some(first) = deep.first() else {
        return;
    };
    if !std::mem::replace(&mut told.crowded, true)
        && let Some(body) = table.get(first.slots[0])
    {
        suspects.0.push((body.entity, BodyProblem::Crowded));
    }
    let revision = Revision::next();
    for DeepPair { pair, .. } in deep {
        let Ok((_, columns)) = pairs.get_mut(pair) else {
            continue;
        };
        let (mut pair, mut cache, mut manifold, mut impulses, mut anchors, mut targets) = columns;
        let pair = pair.bypass_change_detection();
        *manifold.bypass_change_detection() = Manifold::default();
        let impulses = impulses.bypass_change_detection();
        let anchors = anchors.bypass_change_detection();
        let targets = targets.bypass_change_detection();
        let none = Origins::default();
        reorder(&none, &none, impulses, anchors, targets);
        cache.bypass_change_detection().last_pose.forget();
        pair.revision = revision;
        pair.waits = (STEPS_BETWEEN_CHECKS / 2
            + (pair.spawn_orders[0].0 + pair.spawn_orders[1].0) % STEPS_BETWEEN_CHECKS)
            as u8;
        pair.touching = false;
        // Only in the first substep are there no impulses left of points that are gone.
        pair.state = match time.substep {
            0 => PairState::Apart,
            _ => PairState::Live,
        };
        graph.report([(pair.edge, pair.announced())]);
    }
}

/// Finds the deep pairs. In a falling heap most bodies have many pairs and few contacts, so pairs that do not touch are passed over first.
fn find_deep(
    table: &BodyTable,
    graph: &ConstraintGraph,
    places: &Entities,
    pairs: &mut PairsMut,
) -> Vec<DeepPair> {
    let mut deep = Vec::new();
    let tables = pairs.contiguous_iter_mut();
    for (entities, mut columns) in tables.expect("pair components are stored in tables") {
        for rows in &*graph.active_rows(entities, places) {
            let entities = &entities[rows.start as usize..rows.end as usize];
            let (mut pair, _, mut manifold, ..) = columns.part(rows);
            let pairs = pair.bypass_change_detection().iter();
            let manifolds = manifold.bypass_change_detection().iter();
            for ((&entity, pair), manifold) in entities.iter().zip(pairs).zip(manifolds) {
                if pair.touching
                    && let Some(depth) = depth(table, pair, manifold)
                {
                    deep.push(DeepPair {
                        depth,
                        pair: entity,
                        slots: pair.slots,
                    });
                }
            }
        }
    }
    deep
}

/// Penetration depth of a pair, m, if its bodies overlap and contacts can separate them.
fn depth(table: &BodyTable, pair: &ContactPair, manifold: &Manifold) -> Option<f32> {
    let distances = manifold.points.iter().map(|point| point.distance);
    let depth = -distances.fold(0.0, f32::min);
    let [a, b] = table.both(pair.slots)?;
    let counts = a.is_dynamic() && b.is_dynamic() && !(is_idle(a) && is_idle(b));
    (counts && depth > DEEP_OVERLAP * a.size.min(b.size)).then_some(depth)
}
