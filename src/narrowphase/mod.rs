//! The stage **narrowphase**: where the bodies of each pair touch, or may within the step, and which point of the last step
//! each point is.
//!
//! Parry finds the points; it keeps a manifold while the two bodies hardly move against each other, which costs a tenth of
//! finding it anew. Pairs at rest (asleep, or static) keep theirs untouched.

mod corners;
mod cylinders;
mod features;
mod matching;
mod passing;
mod planes;
mod recycling;
mod reduction;
mod seams;

use crate::body::{BodyState, BodyTable, Pose};
pub(crate) use matching::{Origins, inherit};

use crate::contact::{
    ContactAnchors, ContactImpulses, ContactPair, ContactPoint, ContactTargets, Manifold,
    NarrowphaseCache, Patch, Stand,
};
use crate::settings::{Gravity, PhysicsThreads, StabilizationSettings, StepTime};
use bevy_ecs::prelude::*;
use glam::Vec3;
use parry3d::query::{DefaultQueryDispatcher, PersistentQueryDispatcher};
use rayon::prelude::*;
use smallvec::SmallVec;

/// Points of a patch nearer to each other than this share of the smaller face's size become one: two bricks that are all but
/// aligned touch at each corner twice, a few millimetres apart, and the point that a step finds there would not be that
/// of the last one.
const MERGE: f32 = 0.05;

/// How far outside a face, as a share of the smaller face's size, a corner still lies on it.
const SLACK: f32 = 1e-4;

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
    settings: Res<StabilizationSettings>,
    threads: Res<PhysicsThreads>,
    mut pairs: Query<PairColumns>,
) {
    let (table, settings, time) = (&*table, &*settings, &*time);
    let fall = gravity.0.length() * time.dt;
    for (mut pair, mut cache, mut manifold, mut impulses, mut anchors, mut targets) in pairs
        .contiguous_iter_mut()
        .expect("pair components are stored in tables")
    {
        let columns = (
            pair.bypass_change_detection(),
            cache.bypass_change_detection(),
            manifold.bypass_change_detection(),
            impulses.bypass_change_detection(),
            anchors.bypass_change_detection(),
            targets.bypass_change_detection(),
        );
        let grain = threads.grain(columns.0.len());
        threads.run(columns.0.len(), || {
            columns.into_par_iter().with_min_len(grain).for_each(
                |(pair, cache, manifold, impulses, anchors, targets)| {
                    if let [Some(a), Some(b)] = pair.slots.map(|slot| table.get(slot)) {
                        let kept = (manifold, impulses, anchors, targets);
                        look(settings, time, fall, [a, b], pair, cache, kept);
                    }
                },
            );
        });
    }
}

/// What a pair keeps for each of its points and patches.
type Kept<'a> = (
    &'a mut Manifold,
    &'a mut ContactImpulses,
    &'a mut ContactAnchors,
    &'a mut ContactTargets,
);

/// Brings the contacts of one pair up to date. `fall`: what gravity adds to a speed in the step, m/s.
fn look(
    settings: &StabilizationSettings,
    time: &StepTime,
    fall: f32,
    [a, b]: [&BodyState; 2],
    pair: &mut ContactPair,
    cache: &mut NarrowphaseCache,
    (manifold, impulses, anchors, targets): Kept,
) {
    if a.renewed || b.renewed {
        pair.combine([a, b]);
        // Parry would keep the points of shapes that are no more.
        cache.forget();
    }
    pair.parted = false;
    if pair.detected && is_idle(a) && is_idle(b) {
        return;
    }
    pair.detected = true;
    impulses.begin_substep(time);
    if put_apart(a, b) {
        cache.stand = None;
        anchors.points.fill(Default::default());
        anchors.patches.fill(Default::default());
    }
    let reach = settings.outer_distance().max(0.0) + approach(a, b, time.dt) + fall * time.dt;
    let curved = a.is_curved() || b.is_curved();
    // What rolls must be found where it is, or it would gain speed.
    let little = settings.recycle_share * a.size().min(b.size());
    let limit = if curved { CREPT * little } else { little };
    let stand = cache.stand;
    if stand.is_some_and(|stand| stand.holds(a, b, limit, reach)) {
        recycling::refresh(manifold, a, b);
    } else {
        let reach = reach + limit;
        let old = std::mem::take(manifold);
        detect(settings, a, b, reach, cache, manifold);
        let lost = match manifold.points.is_empty() {
            true => stand.and_then(|stand| stand.lost(&old, cache, a, b, little)),
            false => None,
        };
        if let Some(lost) = lost {
            *manifold = lost;
        } else {
            let near = settings.outer_distance() + fall * time.dt;
            let passing = passing::pass(a, b, manifold, near, time.dt);
            if passing {
                *manifold = Manifold::default();
                cache.forget();
            }
            // A point that rolls is the same wherever it has rolled to.
            let radius = match curved {
                true => f32::INFINITY,
                false => settings.envelope,
            };
            let origins = matching::match_points(&old, manifold, cache, radius);
            impulses.reorder(&origins);
            matching::inherit(&origins, &mut anchors.points);
            let origins = matching::match_patches(&old, manifold);
            matching::inherit(&origins, &mut impulses.patches);
            matching::inherit(&origins, &mut anchors.patches);
            let (points, patches) = (manifold.points.len(), manifold.patches.len());
            targets.points.clear();
            targets.points.resize(points, Default::default());
            targets.patches.clear();
            targets.patches.resize(patches, Default::default());
            let keep = limit > 0.0 && !passing;
            cache.stand = keep.then(|| Stand::of(a, b, reach));
        }
    }
    let outer = settings.outer_distance();
    let touched = pair.touching;
    pair.touching = manifold.points.iter().any(|p| p.distance <= outer);
    pair.parted = touched && !pair.touching;
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
    moved + turned * radius > NOTHING + 8.0 * f32::EPSILON * farthest
}

/// Less than this, m, is rounding.
const NOTHING: f32 = 1e-5;

/// Bound on how far two surfaces can come nearer within the step, m, from the velocities before forces.
fn approach(a: &BodyState, b: &BodyState, dt: f32) -> f32 {
    (a.velocity.linear - b.velocity.linear).length() * dt + a.turns_by(dt) + b.turns_by(dt)
}

/// Nearer than this share of the smaller radius two centres are one.
const COINCIDENT: f32 = 1e-6;

/// Between bodies in one place no way apart is better than another: each has a place of its own to go to, or many would be thrown
/// out along one line.
fn part(a: &BodyState, b: &BodyState) -> Manifold {
    let place = |body: &BodyState| {
        let mut rng = fastrand::Rng::with_seed(body.age.0);
        Vec3::from_array(std::array::from_fn(|_| rng.f32()))
    };
    let normal = (place(a) - place(b)).normalize_or(Vec3::Y);
    let distance = -a.radius.min(b.radius);
    let position = a.center;
    let mut manifold = Manifold::default();
    manifold.points.push(ContactPoint {
        position,
        local: [a, b].map(|body| body.pose.inverse_transform_point(position)),
        arms: [Vec3::ZERO; 2],
        distance,
        detected: distance,
    });
    manifold.patches.push(Patch {
        normal,
        first: 0,
        count: 1,
        curved: false,
    });
    manifold
}

/// Fills the manifold with the points no further apart than `reach`, m.
fn detect(
    settings: &StabilizationSettings,
    a: &BodyState,
    b: &BodyState,
    reach: f32,
    cache: &mut NarrowphaseCache,
    manifold: &mut Manifold,
) {
    let NarrowphaseCache {
        manifolds,
        workspace,
        ..
    } = cache;
    let (Some(shape_a), Some(shape_b)) = (a.shape(), b.shape()) else {
        return;
    };
    // What is hollow may have another in its middle that does not touch it.
    let solid = shape_a.is_convex() && shape_b.is_convex();
    if solid && (a.center - b.center).length() <= COINCIDENT * a.radius.min(b.radius) {
        manifolds.clear();
        *workspace = None;
        *manifold = part(a, b);
        return;
    }
    let between = a.pose.to_parry().inv_mul(&b.pose.to_parry());
    let curved = a.is_curved() || b.is_curved();
    if curved {
        // A manifold that is kept turns with the surface, and a cylinder would roll off by itself.
        manifolds.clear();
        *workspace = None;
    }
    let found = DefaultQueryDispatcher
        .contact_manifolds(&between, shape_a, shape_b, reach, manifolds, workspace);
    if found.is_err() {
        // Parry has no contacts between two surfaces without volume, such as two meshes.
        manifolds.clear();
    }
    let block = |body: &BodyState, half| corners::Block {
        pose: body.pose,
        half,
    };
    let blocks = match (shape_a.as_cuboid(), shape_b.as_cuboid()) {
        (Some(in_a), Some(in_b)) => {
            Some((block(a, in_a.half_extents), block(b, in_b.half_extents)))
        }
        _ => None,
    };
    let cylinders = cylinders::meet(a, b);
    for found in manifolds.iter_mut() {
        let (sub_a, sub_b) = (
            found.subshape_pos1().copied(),
            found.subshape_pos2().copied(),
        );
        let turned = sub_a.map_or(found.local_n1, |sub| sub.rotation * found.local_n1);
        // A ball's centre inside another shape's edge has no normal: part the bodies upwards.
        let normal = -(a.pose.rotation * turned);
        let mut normal = normal.try_normalize().unwrap_or(Vec3::Y);
        if cylinders {
            normal = cylinders::normal(a, b, normal);
        }

        if let Some((in_a, in_b)) = &blocks
            && seams::graze(in_a, in_b, normal, settings.outer_distance())
        {
            for contact in &mut found.points {
                contact.data = 0;
            }
            continue;
        }

        let size = a.face_size(normal).min(b.face_size(normal));
        let mut candidates = Candidates::new();
        let own = match cylinders {
            true => features::contacts(a, b, normal),
            false => planes::contacts(a, b),
        };
        candidates.extend(own.into_iter().map(|[on_a, on_b]| Candidate {
            position: 0.5 * (on_a + on_b),
            distance: normal.dot(on_a - on_b),
            source: None,
        }));
        let own = !candidates.is_empty();
        for (i, contact) in found.points.iter().enumerate().filter(|_| !own) {
            let local_a = sub_a.map_or(contact.local_p1, |sub| sub * contact.local_p1);
            let local_b = sub_b.map_or(contact.local_p2, |sub| sub * contact.local_p2);
            let mut on = [
                a.pose.transform_point(local_a),
                b.pose.transform_point(local_b),
            ];
            let mut distance = contact.dist;
            if cylinders {
                on[0] = cylinders::on_surface(a, on[0], -normal);
                on[1] = cylinders::on_surface(b, on[1], normal);
                distance = normal.dot(on[0] - on[1]);
            }
            candidates.push(Candidate {
                position: 0.5 * (on[0] + on[1]),
                distance,
                source: Some(i),
            });
        }
        candidates.retain(|c| c.distance.is_finite() && c.distance <= reach);
        thin_out(&mut candidates, MERGE * size);
        if let Some((in_a, in_b)) = blocks
            && candidates.len() < 4
            && turned != Vec3::ZERO
        {
            // Without any point of parry's the normal may be an old one.
            let lowest = candidates.iter().map(|c| c.distance).fold(-reach, f32::min) - reach;
            for ([on_a, on_b], distance) in corners::corners(in_a, in_b, normal, SLACK * size) {
                if (lowest..=reach).contains(&distance) {
                    candidates.push(Candidate {
                        position: 0.5 * (on_a + on_b),
                        distance,
                        source: None,
                    });
                }
            }
            thin_out(&mut candidates, MERGE * size);
        }

        // A round side touches along a line, whose middle adds nothing and comes and goes.
        let rolls = curved && reduction::is_line(&candidates, size);
        if rolls {
            reduction::keep_ends(&mut candidates);
        }
        if settings.reduce_manifolds {
            reduction::reduce(&mut candidates, normal);
        }

        // Until matching reads it, parry's data holds the number of the old point, high, and that of the new one, low.
        for contact in &mut found.points {
            contact.data = (contact.data & OLD) << 16;
        }
        let first = manifold.points.len();
        for Candidate {
            position,
            distance,
            source,
        } in candidates
        {
            let local = [a, b].map(|body| body.pose.inverse_transform_point(position));
            manifold.points.push(ContactPoint {
                position,
                local,
                arms: [a, b].map(|body| position - body.center),
                distance,
                detected: distance,
            });
            if let Some(source) = source {
                found.points[source].data |= manifold.points.len() as u32;
            }
        }
        let count = manifold.points.len() - first;
        if count > 0 {
            manifold.patches.push(Patch {
                normal,
                first: first as u32,
                count: count as u32,
                curved: rolls,
            });
        }
    }
}

/// A contact point on its way into the manifold.
#[derive(Clone, Copy)]
struct Candidate {
    position: Vec3,
    distance: f32,
    /// Which of parry's points it is.
    source: Option<usize>,
}

type Candidates = SmallVec<[Candidate; 8]>;

/// Puts the deepest points first and drops what is nearer than `merge` (m) to a deeper one.
///
/// The order is that in which the solver visits them. Under few iterations the points visited first take more than their share
/// of the load. If that is always the same corner the body leans over it; if it is the deepest, it is righted. Worth a
/// factor of 4 to 10 in the drift of walls and stacks (`docs/findings.md`).
fn thin_out(candidates: &mut Candidates, merge: f32) {
    candidates.sort_by(|x, y| x.distance.total_cmp(&y.distance));
    let mut kept = Candidates::new();
    for &candidate in candidates.iter() {
        let near = |k: &Candidate| k.position.distance_squared(candidate.position) < merge * merge;
        if !kept.iter().any(near) {
            kept.push(candidate);
        }
    }
    *candidates = kept;
}

/// Mask of the part of parry's contact data that holds the number (from 1) of our point.
pub(crate) const OLD: u32 = 0xffff;
