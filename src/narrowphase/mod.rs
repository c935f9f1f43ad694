//! The stage **narrowphase**: where the bodies of each pair touch, or may within the step, and which point of the last step
//! each point is ([`matching`]).
//!
//! Parry finds the points; it keeps a manifold while the two bodies hardly move against each other, which costs a tenth of
//! finding it anew. Pairs at rest (asleep, or static) keep theirs untouched.

mod corners;
pub mod matching;

use crate::body::{BodyState, BodyTable};
use crate::contact::{
    ContactAnchors, ContactImpulses, ContactPair, ContactPoint, ContactTargets, Manifold,
    NarrowphaseCache, Patch,
};
use crate::settings::{Gravity, PhysicsThreads, StabilizationSettings, StepTime};
use bevy_ecs::prelude::*;
use parry3d::query::{DefaultQueryDispatcher, PersistentQueryDispatcher};
use rayon::prelude::*;

/// Below this many pairs threads cost more than they save.
pub(crate) const SERIAL_PAIRS: usize = 64;

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
    let (table, settings) = (&*table, &*settings);
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
        threads.run(|| {
            columns.into_par_iter().with_min_len(SERIAL_PAIRS).for_each(
                |(pair, cache, manifold, impulses, anchors, targets)| {
                    let [Some(a), Some(b)] = pair.slots.map(|slot| table.get(slot)) else {
                        return;
                    };
                    if a.renewed || b.renewed {
                        pair.friction = a.friction.combine(b.friction);
                        pair.restitution = a.restitution.combine(b.restitution);
                    }
                    if is_idle(a) && is_idle(b) {
                        return;
                    }
                    let reach = settings.outer_distance().max(0.0)
                        + (approach_speed(a, b) + fall) * time.dt;
                    let old = std::mem::take(manifold);
                    detect(a, b, reach, cache, manifold);
                    let origins = matching::match_points(&old, manifold, cache, settings.envelope);
                    matching::inherit(&origins, &mut impulses.points);
                    matching::inherit(&origins, &mut anchors.points);
                    targets.points.clear();
                    targets.points.resize(origins.len(), Default::default());
                    let outer = settings.outer_distance();
                    pair.touching = manifold.points.iter().any(|p| p.distance <= outer);
                },
            );
        });
    }
}

/// Nothing about its contacts can have changed.
fn is_idle(body: &BodyState) -> bool {
    !body.moved && !body.renewed && (body.asleep || !body.is_dynamic())
}

/// Bound on how fast two surfaces can come nearer, m/s, from the velocities before forces.
fn approach_speed(a: &BodyState, b: &BodyState) -> f32 {
    let turning = |body: &BodyState| match body.velocity.angular.length() {
        0.0 => 0.0,
        speed => speed * body.radius,
    };
    (a.velocity.linear - b.velocity.linear).length() + turning(a) + turning(b)
}

/// Fills the manifold with the points no further apart than `reach`, m.
fn detect(
    a: &BodyState,
    b: &BodyState,
    reach: f32,
    cache: &mut NarrowphaseCache,
    manifold: &mut Manifold,
) {
    let NarrowphaseCache {
        manifolds,
        workspace,
    } = cache;
    let between = a.pose.to_parry().inv_mul(&b.pose.to_parry());
    let (shape_a, shape_b) = (a.collider.shape(), b.collider.shape());
    let curved = a.collider.is_curved() || b.collider.is_curved();
    if curved {
        // A manifold that is kept turns with the surface, and a cylinder would roll off by itself.
        manifolds.clear();
        *workspace = None;
    }
    let found = DefaultQueryDispatcher.contact_manifolds(
        &between, &**shape_a, &**shape_b, reach, manifolds, workspace,
    );
    if found.is_err() {
        // Parry has no contacts between two surfaces without volume, such as two meshes.
        manifolds.clear();
    }
    let merge = (1e-3 * a.radius.min(b.radius)).powi(2);
    for found in manifolds.iter_mut() {
        let (sub_a, sub_b) = (
            found.subshape_pos1().copied(),
            found.subshape_pos2().copied(),
        );
        let turned = sub_a.map_or(found.local_n1, |sub| sub.rotation * found.local_n1);
        // A ball's centre inside another shape's edge has no normal: part the bodies upwards.
        let normal = -(a.pose.rotation * turned);
        let normal = normal.try_normalize().unwrap_or(glam::Vec3::Y);
        let first = manifold.points.len();
        for contact in &mut found.points {
            let local_a = sub_a.map_or(contact.local_p1, |sub| sub * contact.local_p1);
            let local_b = sub_b.map_or(contact.local_p2, |sub| sub * contact.local_p2);
            let on_a = a.pose.transform_point(local_a);
            let on_b = b.pose.transform_point(local_b);
            let position = 0.5 * (on_a + on_b);
            let duplicate = manifold.points[first..]
                .iter_mut()
                .find(|p| p.position.distance_squared(position) < merge);
            if !contact.dist.is_finite() || contact.dist > reach {
                contact.data = 0;
            } else if let Some(twin) = duplicate {
                // Exactly aligned boxes come with every corner twice.
                twin.distance = twin.distance.min(contact.dist);
                contact.data = 0;
            } else {
                manifold.points.push(ContactPoint {
                    position,
                    local: [
                        a.pose.inverse_transform_point(position),
                        b.pose.inverse_transform_point(position),
                    ],
                    distance: contact.dist,
                });
                // Until matching reads it: the number of the old point, high; that of the new one, low.
                contact.data = (contact.data & OLD) << 16 | manifold.points.len() as u32;
            }
        }
        let boxes = (shape_a.as_cuboid(), shape_b.as_cuboid());
        if manifold.points.len() - first < 4
            && turned != glam::Vec3::ZERO
            && let (Some(in_a), Some(in_b)) = boxes
        {
            let block = |body: &BodyState, half| corners::Block {
                pose: body.pose,
                half,
            };
            let (in_a, in_b) = (block(a, in_a.half_extents), block(b, in_b.half_extents));
            // Without any point of parry's the normal may be an old one.
            let deepest = manifold.points[first..].iter().map(|p| p.distance);
            let lowest = deepest.fold(-reach, f32::min) - reach;
            for ([on_a, on_b], distance) in corners::corners(in_a, in_b, normal, 0.1 * merge.sqrt())
            {
                let position = 0.5 * (on_a + on_b);
                let mut known = manifold.points[first..].iter();
                if (lowest..=reach).contains(&distance)
                    && !known.any(|p| p.position.distance_squared(position) < merge)
                {
                    manifold.points.push(ContactPoint {
                        position,
                        local: [a, b].map(|body| body.pose.inverse_transform_point(position)),
                        distance,
                    });
                }
            }
        }
        let count = manifold.points.len() - first;
        if count > 0 {
            manifold.patches.push(Patch {
                normal,
                first: first as u32,
                count: count as u32,
                curved: curved && count <= 2,
            });
        }
    }
}

/// Mask of the part of parry's contact data that holds the number (from 1) of our point.
pub(crate) const OLD: u32 = 0xffff;
