//! The stage **anchors**: classifies every contact with the impulses just solved, equation (10), and writes or deletes anchors,
//! equation (11), at the poses where the contacts were detected.

use super::classifier::classify;
use crate::body::{BodyState, BodyTable};
use crate::contact::{
    Anchor, ContactAnchors, ContactImpulses, ContactPair, ContactPoint, Manifold,
};
use crate::narrowphase::SERIAL_PAIRS;
use crate::settings::{AnchorRule, PhysicsThreads, StabilizationSettings};
use bevy_ecs::prelude::*;
use glam::{Quat, Vec3};
use rayon::prelude::*;

/// Equation (11): the contact point as both bodies see it now, and what tells later whether it still holds.
///
/// `slip` is what the neighbours of the point have slipped already, m, world axes: a point that joins a manifold that sticks
/// must not make it forget. Zero at the onset.
pub fn write(
    rule: AnchorRule,
    [a, b]: [&BodyState; 2],
    normal: Vec3,
    point: &ContactPoint,
    slip: Vec3,
) -> Anchor {
    let (local, rotation) = match rule {
        AnchorRule::PairPose => (
            [
                b.pose.inverse_transform_point(a.pose.position - slip),
                Vec3::ZERO,
            ],
            b.pose.rotation.inverse() * a.pose.rotation,
        ),
        _ => (
            [
                point.local[0],
                b.pose.inverse_transform_point(point.position - slip),
            ],
            Quat::IDENTITY,
        ),
    };
    Anchor {
        sticking: true,
        set: true,
        local,
        normal: [a, b].map(|body| body.pose.rotation.inverse() * normal),
        rotation,
        slip,
    }
}

/// See the module's text.
pub fn anchors(
    table: Res<BodyTable>,
    settings: Res<StabilizationSettings>,
    threads: Res<PhysicsThreads>,
    mut pairs: Query<(
        &ContactPair,
        &Manifold,
        &ContactImpulses,
        &mut ContactAnchors,
    )>,
) {
    let friction = settings.friction;
    if !friction.enabled {
        return;
    }
    let table = &*table;
    for (pairs, manifolds, impulses, mut anchors) in pairs
        .contiguous_iter_mut()
        .expect("pair components are stored in tables")
    {
        let columns = (
            pairs,
            manifolds,
            impulses,
            anchors.bypass_change_detection(),
        );
        threads.run(columns.0.len(), || {
            columns.into_par_iter().with_min_len(SERIAL_PAIRS).for_each(
                |(pair, manifold, impulses, anchors)| {
                    let [Some(a), Some(b)] = pair.slots.map(|slot| table.get(slot)) else {
                        return;
                    };
                    for patch in &manifold.patches {
                        let range = patch.range();
                        let held = &mut anchors.points[range.clone()];
                        classify(
                            friction.classifier,
                            pair.friction,
                            &impulses.points[range.clone()],
                            held,
                        );
                        for (anchor, point) in held.iter_mut().zip(&manifold.points[range]) {
                            if !anchor.sticking {
                                *anchor = Anchor::default();
                            } else if friction.anchors == AnchorRule::Literal {
                                let bodies = [a, b];
                                *anchor = write(
                                    AnchorRule::Literal,
                                    bodies,
                                    patch.normal,
                                    point,
                                    Vec3::ZERO,
                                );
                            } else if !anchor.set {
                                *anchor = write(
                                    friction.anchors,
                                    [a, b],
                                    patch.normal,
                                    point,
                                    anchor.slip,
                                );
                            }
                        }
                    }
                },
            );
        });
    }
}
