//! The stage **narrowphase**: computes the contact manifold of each pair, and matches its points with those of the last step.
//!
//! Contacts of cuboids and hulls are found by `polyhedra`, of cylinders and cones by `round`, of other shapes by parry. A manifold is
//! kept (recycled) while the two bodies hardly move relative to each other, which costs a tenth of computing it anew. Pairs at rest
//! (asleep or static) keep theirs unchanged.

mod candidates;
mod capsules;
mod composites;
mod crowd;
mod detect;
mod dispatcher;
mod forms;
mod ghosts;
mod matching;
mod meeting;
mod modify;
mod parry;
mod passing;
#[doc(hidden)]
pub mod polyhedra;
mod recycling;
mod reduction;
mod rolling;
mod round;

use crate::body::{BodyState, BodyTable, Pose};
#[doc(hidden)]
pub use crowd::crowd;
use ghosts::Surroundings;
#[doc(hidden)]
pub use modify::modify_contacts;
use recycling::Since;

use crate::broadphase::Reach;
use crate::graph::ConstraintGraph;
use crate::pair::{
    ContactAnchors, ContactImpulses, ContactPair, ContactTargets, Manifold, NarrowphaseCache,
    PairState, PairsMut, Part, reorder, revise_edited,
};
use crate::revision::Revision;
use crate::settings::{
    Gravity, NarrowphaseSettings, PhysicsThreads, StabilizationSettings, StepTime,
};
use crate::solver::ROCKING_SPEED;
use bevy_ecs::entity::Entities;
use bevy_ecs::prelude::*;
use glam::Vec3;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};
use std::sync::{Mutex, PoisonError};

/// Share of the usual movement within which manifolds of round bodies are kept: so small that nothing can roll.
const ROUND_MOVEMENT_SHARE: f32 = 0.02;

/// Number of pairs that are kept in the time in which the contacts of one pair are detected anew.
const PAIRS_KEPT_PER_DETECTION: usize = 32;

/// Computes the contacts of all pairs.
pub fn narrowphase(
    table: Res<BodyTable>,
    (time, gravity): (Res<StepTime>, Res<Gravity>),
    (stabilization, manifolds): (Res<StabilizationSettings>, Res<NarrowphaseSettings>),
    threads: Res<PhysicsThreads>,
    (mut graph, places): (ResMut<ConstraintGraph>, &Entities),
    mut pairs: PairsMut,
    mut detected: Local<usize>,
) {
    let table = &*table;
    let detections = AtomicUsize::new(0);
    // Edges whose contact has begun or ended.
    let changed = Mutex::new(Vec::new());
    let revision = Revision::next();
    let tables = pairs.contiguous_iter_mut();
    for (entities, mut columns) in tables.expect("pair components are stored in tables") {
        for rows in &*graph.active_rows(entities, places) {
            let (mut pair, mut cache, mut manifold, mut impulses, mut anchors, mut targets) =
                columns.part(rows);
            let rules = Rules {
                stabilization: &stabilization,
                manifolds: &manifolds,
                time: &time,
                reach: Reach::new(&stabilization, &manifolds, &time, &gravity),
                edited: revise_edited!(pair, manifold),
                revision,
                around: Some(Surroundings {
                    table,
                    graph: &graph,
                }),
            };
            let columns = (
                pair.bypass_change_detection(),
                cache.bypass_change_detection(),
                manifold.bypass_change_detection(),
                impulses.bypass_change_detection(),
                anchors.bypass_change_detection(),
                targets.bypass_change_detection(),
            );
            threads.each_of(
                columns,
                *detected * PAIRS_KEPT_PER_DETECTION,
                |(pair, cache, manifold, impulses, anchors, targets)| {
                    if let Some([a, b]) = table.both(pair.slots) {
                        let kept = (manifold, impulses, anchors, targets);
                        if let Some(parted) = look(&rules, [a, b], pair, cache, kept) {
                            let mut changed =
                                changed.lock().unwrap_or_else(PoisonError::into_inner);
                            changed.push((pair.edge, parted));
                        }
                        if pair.revision == revision {
                            detections.fetch_add(1, Relaxed);
                        }
                    }
                },
            );
        }
    }
    // It decides only how the work of the next step is divided, and no result.
    *detected = detections.into_inner();
    graph.report(changed.into_inner().unwrap_or_else(PoisonError::into_inner));
}

/// Finds the contacts of new pairs outside the stage.
pub(crate) struct Detector {
    stabilization: StabilizationSettings,
    manifolds: NarrowphaseSettings,
    time: StepTime,
    reach: Reach,
    pub revision: Revision,
}

impl Detector {
    pub fn new(world: &World) -> Self {
        Self {
            stabilization: *world.resource::<StabilizationSettings>(),
            manifolds: *world.resource::<NarrowphaseSettings>(),
            time: *world.resource::<StepTime>(),
            reach: Reach::of(world),
            revision: Revision::next(),
        }
    }

    /// Finds the contacts of a new pair, as the stage does.
    pub fn detect(
        &self,
        bodies: [&BodyState; 2],
        pair: &mut ContactPair,
        cache: &mut NarrowphaseCache,
        kept: Kept,
    ) {
        let rules = Rules {
            stabilization: &self.stabilization,
            manifolds: &self.manifolds,
            time: &self.time,
            reach: self.reach,
            edited: false,
            revision: self.revision,
            around: None,
        };
        look(&rules, bodies, pair, cache, kept);
    }
}

/// The settings for all pairs of a step.
struct Rules<'a> {
    stabilization: &'a StabilizationSettings,
    manifolds: &'a NarrowphaseSettings,
    time: &'a StepTime,
    reach: Reach,
    /// Whether the user has edited a manifold.
    edited: bool,
    /// The revision of the pairs whose contacts are detected anew.
    revision: Revision,
    /// The bodies that may cover edges. Bodies that are found at rest slide over none.
    around: Option<Surroundings<'a>>,
}

/// The data that a pair keeps for each of its points and patches.
type Kept<'a> = (
    &'a mut Manifold,
    &'a mut ContactImpulses,
    &'a mut ContactAnchors,
    &'a mut ContactTargets,
);

/// Brings the contacts of a pair up to date. Returns a value if the pair has begun or ceased to have points, or to touch: whether the
/// bodies have parted, that is, touched in the last step and no longer do.
fn look(
    rules: &Rules,
    [a, b]: [&BodyState; 2],
    pair: &mut ContactPair,
    cache: &mut NarrowphaseCache,
    (manifold, impulses, anchors, targets): Kept,
) -> Option<bool> {
    let time = rules.time;
    let outer = rules.reach.outer;
    let restored = pair.state == PairState::Restored;
    if (a.renewed || b.renewed) && !restored {
        pair.combine([a, b]);
        // Parry would keep the points of the old shapes.
        cache.forget();
        pair.state = PairState::New;
        pair.waits = 0;
    }
    if pair.state != PairState::New && !restored && is_idle(a) && is_idle(b) {
        pair.state = PairState::Idle;
        return None;
    }
    if pair.is_idle() {
        pair.state = PairState::Live;
    }
    if pair.waits > 0 && a.put_from.is_none() && b.put_from.is_none() {
        pair.waits -= 1;
        return None;
    }
    let reach = rules.reach.meeting(a, b);
    let little = rules.reach.little(a, b);
    // Bodies that fall beside each other end here, and read no more of their columns.
    let search = rules.reach.search(a, b);
    let last = cache.last_pose;
    if pair.is_apart() && last.is_apart(a, b, search, || last.since(a, b)) {
        return None;
    }
    let had_points = !manifold.points.is_empty();
    impulses.begin_substep(time, manifold);
    if put_apart(a, b) {
        cache.last_pose.forget();
        impulses.points.fill(Default::default());
        impulses.patches.fill(Default::default());
        impulses.friction.fill(Default::default());
        anchors.points.fill(Default::default());
        anchors.patches.fill(Default::default());
        anchors.measured = None;
    }
    let curved = a.is_curved() || b.is_curved();
    // Contacts of rolling bodies must be computed where they are, or the bodies would gain speed.
    let limit = if curved {
        ROUND_MOVEMENT_SHARE * little
    } else {
        little
    };
    let last = cache.last_pose;
    let since = last.since(a, b);
    let normal = manifold.patches.first().map(|patch| patch.normal);
    let rocks = !curved
        && normal.is_some_and(|normal| are_rocking(&since, [a, b], normal, impulses, time.dt));
    if manifold.points.is_empty() && last.is_apart(a, b, search, || since) {
        // There was no contact, and there can be none.
    } else if last.holds(since.way(), limit, reach) {
        if rocks {
            cache.last_pose.carry([a, b], &since, manifold);
            pair.revision = rules.revision;
        } else if a.moved || b.moved || rules.edited {
            since.refresh(manifold);
        }
    } else if let Some(since) = cache.last_pose.turn([a, b], (reach, limit), manifold) {
        pair.revision = rules.revision;
        since.refresh(manifold);
    } else {
        pair.revision = rules.revision;
        let kept = (&mut *manifold, &mut *impulses, &mut *anchors, &mut *targets);
        detect_anew(rules, [a, b], pair.slots, (reach, limit), cache, kept);
    }
    let touched = pair.touching;
    pair.touching = manifold.points.iter().any(|p| p.distance <= outer);
    if pair.rocks() != rocks {
        pair.set_rocks(rocks);
        pair.revision = rules.revision;
    }
    let parted = touched && !pair.touching;
    // Only in the first substep are there no impulses left of points that are gone.
    pair.state = match manifold.points.is_empty() && time.substep == 0 {
        true => PairState::Apart,
        false => PairState::Live,
    };
    let changed = manifold.points.is_empty() == had_points || parted || restored;
    changed.then_some(parted)
}

/// Bodies that turn by less than this keep their lever arms, rad.
const LITTLE_TURN: f32 = 1e-4;

/// Bodies that turn by more than this in a step keep their lever arms, rad.
const MAX_TURN: f32 = 0.4;

/// Whether one of two bodies that press on each other rocks on the other. Then lever arms turn with them, and are those of the middle of
/// the step in a solve. Arms that stay as they were at the detection act like a torque against the motion: a block that rocks would lose
/// two thirds of its swings.
fn are_rocking(
    since: &Since,
    bodies: [&BodyState; 2],
    normal: Vec3,
    impulses: &ContactImpulses,
    dt: f32,
) -> bool {
    let turned_far = since.turned() > LITTLE_TURN;
    turned_far && impulses.carries() && {
        // Bodies on a floor that turns, or in a drum, turn with it.
        let [a, b] = bodies.map(|body| body.velocity.angular);
        let spin = a - b;
        // A top spins about the normal, and does not rock.
        let along = spin.dot(normal);
        let across = spin.length_squared() - along * along;
        let most = MAX_TURN / dt;
        across > (along * along).max(ROCKING_SPEED * ROCKING_SPEED)
            && a.length_squared().max(b.length_squared()) < most * most
    }
}

/// Detects the contacts of a pair anew, and moves what is kept of the old points to the new ones. `reach` is the distance up to which
/// contacts are searched, and `limit` the motion within which they are kept, m.
fn detect_anew(
    rules: &Rules,
    [a, b]: [&BodyState; 2],
    slots: [u32; 2],
    (reach, limit): (f32, f32),
    cache: &mut NarrowphaseCache,
    (manifold, impulses, anchors, targets): Kept,
) {
    let Reach {
        outer, fall, dt, ..
    } = rules.reach;
    let last = cache.last_pose;
    let reach = reach + limit;
    let old = std::mem::take(manifold);
    manifold.between = a.center - b.center;
    let apart = detect::detect(rules, a, b, reach, cache, &old, manifold);
    meeting::find(rules, [a, b], (apart, reach), manifold);
    if manifold.points.is_empty() && last.is_known() {
        let little = rules.reach.little(a, b);
        if let Some(lost) = last.since(a, b).lost(&old, cache, little) {
            *manifold = lost;
            return;
        }
    }
    // The cast ignores rotation, which alone may bring the end of a rod near.
    let turns = match a.is_slender() || b.is_slender() {
        true => a.swept_margin + b.swept_margin,
        false => 0.0,
    };
    let near = outer + fall * dt + turns;
    if let Some(around) = &rules.around {
        around.remove_ghosts(slots, [a, b], (outer, dt), manifold);
    }
    let passing = !manifold.points.is_empty() && passing::pass(a, b, manifold, near, dt);
    if passing {
        *manifold = Manifold::default();
        cache.forget();
    }
    meeting::look_ahead(rules, [a, b], slots, (reach, cache.axis), manifold);
    // A rolling point matches wherever it has rolled to.
    let radius = match a.is_curved() || b.is_curved() {
        true => f32::INFINITY,
        false => rules.manifolds.match_radius,
    };
    let turns = last.turns([a, b]);
    let origins = matching::match_points(&old, manifold, turns, radius);
    let of_patches = matching::match_patches(&old, manifold);
    reorder(&origins, &of_patches, impulses, anchors, targets);
    // Where bodies hit each other, friction acts at the middle of the patch: it would spin a body that lands on a corner faster than arms
    // that are fixed during a step allow.
    if impulses.carries() && !a.is_curved() && !b.is_curved() {
        manifold.center_on_load();
    }
    cache.last_pose.take(a, b);
    if limit > 0.0 && !passing {
        (cache.last_pose.reach, cache.last_pose.apart) = (reach, apart);
    }
}

/// Whether nothing about the contacts of this body can have changed.
fn is_idle(body: &BodyState) -> bool {
    !body.moved && !body.renewed && (body.asleep || !body.is_dynamic())
}

/// Whether the user has moved one of the two bodies, and with it their relative pose. Their anchors and loads are deleted then. Bodies that
/// are moved together keep theirs.
fn put_apart(a: &BodyState, b: &BodyState) -> bool {
    if a.put_from.is_none() && b.put_from.is_none() {
        return false;
    }
    let was = |body: &BodyState| body.put_from.as_deref().copied().unwrap_or(body.pose);
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
    moved + turned * radius > MOVEMENT_ROUNDING + 8.0 * f32::EPSILON * farthest
}

/// Movements below this are rounding, m.
const MOVEMENT_ROUNDING: f32 = 1e-5;
