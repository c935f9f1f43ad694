//! The stage **narrowphase**: where the bodies of each pair touch, or may within the step, and which point of the last step
//! each point is.
//!
//! Of cuboids and hulls the points are found by [`polyhedra`], of cylinders and cones by `round`, of other shapes by parry. A manifold
//! is kept while the two bodies hardly move against each other, which costs a tenth of finding it anew. Pairs at rest (asleep, or
//! static) keep theirs untouched.

mod capsules;
mod crowd;
mod detect;
mod dispatcher;
mod forms;
mod matching;
mod parry;
mod passing;
pub mod polyhedra;
mod recycling;
mod reduction;
mod rolling;
mod round;

use crate::body::{BodyState, BodyTable, Pose, Resting};
pub use crowd::crowd;
pub(crate) use dispatcher::ParryManifold;
pub(crate) use matching::{Origins, inherit};

use crate::contact::{
    ContactAnchors, ContactImpulses, ContactPair, ContactTargets, Manifold, NarrowphaseCache,
    is_edited, reorder,
};
use crate::settings::{
    Gravity, NarrowphaseSettings, PhysicsThreads, StabilizationSettings, StepTime,
};
use bevy_ecs::prelude::*;

/// Of the way for which manifolds are kept, the share for which those of round bodies are: so little that nothing can roll.
const CREPT: f32 = 0.02;

type PairColumns<'w> = (
    &'w mut ContactPair,
    &'w mut NarrowphaseCache,
    &'w mut Manifold,
    &'w mut ContactImpulses,
    &'w mut ContactAnchors,
    &'w mut ContactTargets,
);

/// See the module's text.
pub fn narrowphase(
    table: Res<BodyTable>,
    time: Res<StepTime>,
    gravity: Res<Gravity>,
    (stabilization, manifolds): (Res<StabilizationSettings>, Res<NarrowphaseSettings>),
    threads: Res<PhysicsThreads>,
    mut pairs: Query<PairColumns, Without<Resting>>,
) {
    let table = &*table;
    for (mut pair, mut cache, mut manifold, mut impulses, mut anchors, mut targets) in pairs
        .contiguous_iter_mut()
        .expect("pair components are stored in tables")
    {
        let rules = Rules {
            stabilization: &stabilization,
            manifolds: &manifolds,
            time: &time,
            fall: gravity.0.length() * time.dt,
            edited: is_edited!(manifold),
        };
        let columns = (
            pair.bypass_change_detection(),
            cache.bypass_change_detection(),
            manifold.bypass_change_detection(),
            impulses.bypass_change_detection(),
            anchors.bypass_change_detection(),
            targets.bypass_change_detection(),
        );
        threads.each(
            columns,
            |(pair, cache, manifold, impulses, anchors, targets)| {
                if let Some([a, b]) = table.both(pair.slots) {
                    let kept = (manifold, impulses, anchors, targets);
                    look(&rules, [a, b], pair, cache, kept);
                }
            },
        );
    }
}

/// What pairs are looked at by.
struct Rules<'a> {
    stabilization: &'a StabilizationSettings,
    manifolds: &'a NarrowphaseSettings,
    time: &'a StepTime,
    /// What gravity adds to a speed in the step, m/s.
    fall: f32,
    /// Somebody else has changed a manifold.
    edited: bool,
}

/// What a pair keeps for each of its points and patches.
type Kept<'a> = (
    &'a mut Manifold,
    &'a mut ContactImpulses,
    &'a mut ContactAnchors,
    &'a mut ContactTargets,
);

/// Brings the contacts of one pair up to date.
fn look(
    rules: &Rules,
    [a, b]: [&BodyState; 2],
    pair: &mut ContactPair,
    cache: &mut NarrowphaseCache,
    (manifold, impulses, anchors, targets): Kept,
) {
    let (time, fall) = (rules.time, rules.fall);
    let outer = rules.stabilization.outer_distance();
    if a.renewed || b.renewed {
        pair.combine([a, b]);
        // Parry would keep the points of shapes that are no more.
        cache.forget();
        pair.empty = false;
        pair.waits = 0;
    }
    pair.parted = false;
    pair.idle = pair.detected && is_idle(a) && is_idle(b);
    if pair.idle {
        return;
    }
    if pair.waits > 0 && a.put_from.is_none() && b.put_from.is_none() {
        pair.waits -= 1;
        return;
    }
    let reach = outer.max(0.0) + approach(a, b, time.dt) + fall * time.dt;
    let little = rules.manifolds.recycle_share * a.size.min(b.size);
    // In a heap that falls most pairs are such, and ask for no more of their columns. Farther than a search would go: what is hit in
    // the step goes farther than it looked.
    let search = reach + little;
    let stand = cache.stand;
    if pair.empty && !rules.edited && stand.is_apart(a, b, search, || stand.since(a, b)) {
        return;
    }
    pair.detected = true;
    impulses.begin_substep(time, manifold);
    if put_apart(a, b) {
        cache.stand.forget();
        anchors.points.fill(Default::default());
        anchors.patches.fill(Default::default());
        anchors.measured = false;
    }
    let curved = a.is_curved() || b.is_curved();
    // What rolls must be found where it is, or it would gain speed.
    let limit = if curved { CREPT * little } else { little };
    let stand = cache.stand;
    let since = stand.since(a, b);
    if manifold.points.is_empty() && stand.is_apart(a, b, search, || since) {
        // Nothing was there, nor can be.
    } else if stand.holds(since.way(), limit, reach) {
        if a.moved || b.moved || rules.edited {
            since.refresh(manifold);
        }
    } else {
        pair.revision = pair.revision.wrapping_add(1);
        let reach = reach + limit;
        let old = std::mem::take(manifold);
        manifold.between = a.center - b.center;
        let apart = detect::detect(rules, a, b, reach, cache, &old, manifold);
        let lost = match manifold.points.is_empty() && stand.is_known() {
            true => since.lost(&old, cache, little),
            false => None,
        };
        if let Some(lost) = lost {
            *manifold = lost;
        } else {
            // The cast knows of no turns, by which alone the end of a rod may come.
            let turns = match a.is_slender() || b.is_slender() {
                true => a.swept_margin + b.swept_margin,
                false => 0.0,
            };
            let near = outer + fall * time.dt + turns;
            let passing =
                !manifold.points.is_empty() && passing::pass(a, b, manifold, near, time.dt);
            if passing {
                *manifold = Manifold::default();
                cache.forget();
            }
            // A point that rolls is the same wherever it has rolled to.
            let radius = match curved {
                true => f32::INFINITY,
                false => rules.manifolds.match_radius,
            };
            let turns = stand.turns([a, b]);
            let origins = matching::match_points(&old, manifold, turns, radius);
            let of_patches = matching::match_patches(&old, manifold);
            reorder(&origins, &of_patches, impulses, anchors, targets);
            cache.stand.take(a, b);
            if limit > 0.0 && !passing {
                (cache.stand.reach, cache.stand.apart) = (reach, apart);
            }
        }
    }
    let touched = pair.touching;
    pair.touching = manifold.points.iter().any(|p| p.distance <= outer);
    pair.parted = touched && !pair.touching;
    // Only a step's first substep leaves no impulses of points that are no more.
    pair.empty = manifold.points.is_empty() && time.substep == 0;
}

/// Nothing about its contacts can have changed.
fn is_idle(body: &BodyState) -> bool {
    !body.moved && !body.renewed && (body.asleep || !body.is_dynamic())
}

/// The user has put one of the two elsewhere, and by that changed how they stand to each other: nothing that held them there holds any
/// more. What is put elsewhere as a whole keeps all it has.
fn put_apart(a: &BodyState, b: &BodyState) -> bool {
    if a.put_from.is_none() && b.put_from.is_none() {
        return false;
    }
    let was = |body: &BodyState| body.put_from.unwrap_or(body.pose);
    let (before, after) = (was(a).within(&was(b)), a.pose.within(&b.pose));
    let turned = 2.0 * (before.rotation.inverse() * after.rotation).xyz().length();
    let moved = (after.position - before.position).length();
    let farthest = [was(a), was(b), a.pose, b.pose]
        .map(|pose: Pose| pose.position.abs().max_element())
        .into_iter()
        .fold(0.0, f32::max);
    let radius = if a.radius.is_finite() {
        a.radius
    } else {
        b.radius
    };
    moved + turned * radius > ROUNDING + 8.0 * f32::EPSILON * farthest
}

/// Less than this, m, is rounding.
const ROUNDING: f32 = 1e-5;

/// Bound on how far two surfaces can come nearer within the step, m, from the velocities before forces.
fn approach(a: &BodyState, b: &BodyState, dt: f32) -> f32 {
    (a.velocity.linear - b.velocity.linear).length() * dt + a.swept_margin + b.swept_margin
}
