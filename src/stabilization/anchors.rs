//! The stage **anchors**: classifies every contact with the impulses just solved, equation (10), and writes or deletes anchors,
//! equation (11), at the poses where the contacts were detected.

use super::classifier::{classify, holds_twist, sticks};
use crate::body::{BodyState, BodyTable, Resting};
use crate::contact::{
    Anchor, ContactAnchors, ContactImpulses, ContactPair, ContactPoint, Impulse, Manifold,
    ManifoldPatch, PatchAnchor,
};
use crate::islands::Islands;
use crate::settings::{
    AnchorRule, FrictionStabilization, PhysicsThreads, StabilizationSettings, StepTime,
};
use crate::solver::Slip;
use bevy_ecs::prelude::*;
use glam::{Quat, Vec3};

/// Equation (11): the contact point as both bodies see it now, and what tells later whether it still holds.
///
/// `slip` is what the neighbours of the point have slipped already, m, world axes: a point that joins a manifold that sticks
/// must not make it forget. Zero at the onset.
pub fn write([a, b]: [&BodyState; 2], normal: Vec3, position: Vec3, slip: Vec3) -> Anchor {
    Anchor {
        sticking: true,
        set: true,
        local: [
            a.pose.inverse_transform_point(position),
            b.pose.inverse_transform_point(position - slip),
        ],
        normal: [a, b].map(|body| body.pose.rotation.inverse() * normal),
        slip,
    }
}

/// How A stands to B now.
pub fn write_pose([a, b]: [&BodyState; 2]) -> PatchAnchor {
    PatchAnchor {
        sticking: true,
        set: true,
        position: b.pose.inverse_transform_point(a.pose.position),
        rotation: b.pose.rotation.inverse() * a.pose.rotation,
    }
}

/// The anchor of a patch moved by so far about the patch's centre (world, m), as the solver has found it dragged.
fn drag(b: &BodyState, anchor: &mut PatchAnchor, normal: Vec3, center: Vec3, by: Slip) {
    let turn = Quat::from_axis_angle(normal, by.twist);
    let position = b.pose.transform_point(anchor.position);
    let position = center + by.shift + turn * (position - center);
    let rotation = turn * b.pose.rotation * anchor.rotation;
    anchor.position = b.pose.inverse_transform_point(position);
    anchor.rotation = (b.pose.rotation.inverse() * rotation).normalize();
}

/// See the module's text.
pub fn anchors(
    (table, islands): (Res<BodyTable>, Res<Islands>),
    (settings, time): (Res<StabilizationSettings>, Res<StepTime>),
    threads: Res<PhysicsThreads>,
    mut pairs: Query<
        (
            &ContactPair,
            &Manifold,
            &mut ContactImpulses,
            &mut ContactAnchors,
        ),
        Without<Resting>,
    >,
) {
    let friction = settings.friction;
    if !friction.enabled {
        return;
    }
    let (table, woke) = (&*table, islands.woke());
    for (pairs, manifolds, mut impulses, mut anchors) in pairs
        .contiguous_iter_mut()
        .expect("pair components are stored in tables")
    {
        let columns = (
            pairs,
            manifolds,
            impulses.bypass_change_detection(),
            anchors.bypass_change_detection(),
        );
        threads.each(columns, |(pair, manifold, impulses, anchors)| {
            // What is not solved sticks or slides as it did.
            if pair.idle && !woke {
                return;
            }
            let [Some(a), Some(b)] = pair.slots.map(|slot| table.get(slot)) else {
                return;
            };
            if !a.is_awake() && !b.is_awake() {
                return;
            }
            let bodies = [a, b];
            if friction.anchors == AnchorRule::PairPose {
                hold_patches(
                    &friction, pair, manifold, impulses, bodies, anchors, time.dt,
                );
            } else {
                hold_points(&friction, pair, manifold, impulses, bodies, anchors);
            }
        });
    }
}

fn hold_points(
    friction: &FrictionStabilization,
    pair: &ContactPair,
    manifold: &Manifold,
    impulses: &ContactImpulses,
    bodies: [&BodyState; 2],
    anchors: &mut ContactAnchors,
) {
    anchors
        .points
        .resize(manifold.points.len(), Anchor::default());
    for patch in &manifold.patches {
        let range = patch.range();
        let held = &mut anchors.points[range.clone()];
        let solved = &impulses.points[range.clone()];
        classify(friction.classifier, pair.friction, solved, held);
        for (anchor, point) in held.iter_mut().zip(&manifold.points[range]) {
            if !anchor.sticking {
                *anchor = Anchor::default();
            } else if friction.anchors == AnchorRule::Literal {
                *anchor = write(bodies, patch.normal, point.position, Vec3::ZERO);
            } else if !anchor.set {
                *anchor = write(bodies, patch.normal, point.position, anchor.slip);
            }
        }
    }
}

fn hold_patches(
    friction: &FrictionStabilization,
    pair: &ContactPair,
    manifold: &Manifold,
    impulses: &mut ContactImpulses,
    bodies: [&BodyState; 2],
    anchors: &mut ContactAnchors,
    dt: f32,
) {
    for (i, patch) in manifold.patches.iter().enumerate() {
        let anchor = &mut anchors.patches[i];
        let solved = &impulses.points[patch.range()];
        let points = &manifold.points[patch.range()];
        let center = ManifoldPatch::center(points);
        let lever = |(point, impulse): (&ContactPoint, &Impulse)| {
            impulse.normal * (point.arms[0] - center).length()
        };
        let lever = points.iter().zip(solved).map(lever).sum();
        let was = anchor.sticking;
        let dragged = std::mem::take(&mut impulses.patches[i].dragged);
        anchor.sticking = !patch.curved
            && sticks(friction.classifier, pair.friction, solved, was)
            && holds_twist(pair.friction, impulses.patches[i].warm_twist * dt, lever);
        if !anchor.sticking {
            anchors.measured &= !anchor.set;
            *anchor = PatchAnchor::default();
            continue;
        }
        if !anchor.set {
            anchors.measured = false;
            *anchor = write_pose(bodies);
        }
        if dragged != Slip::default() {
            anchors.measured = false;
            let center = bodies[0].center + center;
            drag(bodies[1], anchor, patch.normal, center, dragged);
        }
    }
}
