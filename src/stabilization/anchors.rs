//! The stage **anchors**: classifies every contact with the impulses just solved, equation (10), and writes or deletes its anchor,
//! equation (11), at the poses where the contact was detected. A patch that only creeps keeps its anchor, in contrast to the paper.

use super::classifier::{ContactImpulse, classify, holds_twist, sticks};
use super::friction::slip_velocity;
use crate::body::{BodyState, BodyTable};
use crate::graph::{ConstraintGraph, Islands};
use crate::pair::{
    Anchor, ContactAnchors, ContactImpulses, ContactPair, ContactPoint, ContactTargets, Lists,
    Manifold, ManifoldPatch, PairsMut, Part, PatchAnchor, fit, revise_edited,
};
use crate::settings::{
    AnchorRule, Classifier, FrictionStabilization, PhysicsThreads, StabilizationSettings, StepTime,
};
use crate::solver::{Both, Slip};
use bevy_ecs::entity::Entities;
use bevy_ecs::prelude::*;
use glam::{Quat, Vec3};
use smallvec::SmallVec;
use std::ops::Range;

/// Share of its load at rest by which the normal force of a patch may differ if it is loaded steadily. At 0.2 and more, bricks that a blow
/// has loosened stick more often at 60 Hz than with shorter steps.
const STEADY_LOAD_SHARE: f32 = 0.04;

/// Writes the anchor of a sticking point, equation (11): the contact point in the frames of both bodies, and the data that tell later
/// whether it still holds.
///
/// `slip` is the slip of the neighbouring points, m, world axes; zero when sticking begins. A point that joins a sticking manifold must
/// not make it forget its slip.
pub(crate) fn write([a, b]: [&BodyState; 2], normal: Vec3, position: Vec3, slip: Vec3) -> Anchor {
    Anchor {
        sticking: true,
        set: true,
        local: [
            a.pose.inverse_transform_point(position),
            b.pose.inverse_transform_point(position - slip),
        ],
        normal: [a, b].both(|body| body.pose.rotation.inverse() * normal),
        slip,
    }
}

/// Writes the anchor of a sticking patch: the pose of A relative to B.
pub(crate) fn write_pose([a, b]: [&BodyState; 2]) -> PatchAnchor {
    PatchAnchor::new(
        b.pose.inverse_transform_point(a.pose.position),
        b.pose.rotation.inverse() * a.pose.rotation,
    )
}

/// Moves the anchor of a patch by a slip about the patch's centre (world, m): the amount by which the solver has found it dragged along.
fn drag(b: &BodyState, anchor: &mut PatchAnchor, normal: Vec3, center: Vec3, by: Slip) {
    let turn = Quat::from_axis_angle(normal, by.twist);
    let position = b.pose.transform_point(anchor.position);
    let position = center + by.shift + turn * (position - center);
    let rotation = turn * b.pose.rotation * anchor.rotation();
    *anchor = PatchAnchor::new(
        b.pose.inverse_transform_point(position),
        (b.pose.rotation.inverse() * rotation).normalize(),
    );
}

/// Writes the anchors of bodies that rock anew, with the slip that they have. An anchor that stayed would draw a body that rocks onto its
/// other edge back to where that edge was when the anchor was set.
fn follow_rocking(
    manifold: &Manifold,
    targets: &ContactTargets,
    bodies: [&BodyState; 2],
    anchors: &mut ContactAnchors,
) {
    let patches = anchors.patches.iter_mut().zip(&manifold.patches);
    for ((anchor, patch), slip) in patches.zip(&targets.patches) {
        if let Some(slip) = slip.filter(|_| anchor.set) {
            let sticking = anchor.sticking;
            let back = Slip {
                shift: -slip.shift,
                twist: -slip.twist,
            };
            let center = bodies[0].center + patch.center;
            *anchor = write_pose(bodies);
            drag(bodies[1], anchor, patch.normal, center, back);
            anchor.sticking = sticking;
            anchors.measured = None;
        }
    }
}

/// Writes and deletes the anchors of all pairs. Does nothing if friction stabilization is disabled.
pub fn anchors(
    (table, islands): (Res<BodyTable>, Res<Islands>),
    (graph, places): (Res<ConstraintGraph>, &Entities),
    (settings, time): (Res<StabilizationSettings>, Res<StepTime>),
    threads: Res<PhysicsThreads>,
    mut pairs: PairsMut,
) {
    let friction = settings.friction;
    if !friction.enabled {
        return;
    }
    let (table, woke) = (&*table, islands.woke());
    let tables = pairs.contiguous_iter_mut();
    for (entities, mut columns) in tables.expect("pair components are stored in tables") {
        for rows in &*graph.active_rows(entities, places) {
            let (mut pairs, _, manifolds, mut impulses, mut anchors, targets) = columns.part(rows);
            revise_edited!(pairs, manifolds);
            let columns = (
                &*pairs,
                &*manifolds,
                impulses.bypass_change_detection(),
                anchors.bypass_change_detection(),
                &*targets,
            );
            threads.each(columns, |(pair, manifold, impulses, anchors, targets)| {
                // A pair that is not solved keeps its state.
                if pair.is_idle() && !woke || pair.is_apart() {
                    return;
                }
                let Some([a, b]) = table.both(pair.slots) else {
                    return;
                };
                if !a.is_awake() && !b.is_awake() {
                    return;
                }
                let bodies = [a, b];
                let by_pose = friction.anchors == AnchorRule::PairPose;
                let lists = Lists {
                    impulses: Some((&mut *impulses, false)),
                    anchors: Some((&mut *anchors, !by_pose)),
                    ..Default::default()
                };
                fit(manifold, lists);
                if by_pose {
                    if pair.rocks() {
                        follow_rocking(manifold, targets, bodies, anchors);
                    }
                    hold_patches(&friction, pair, manifold, impulses, bodies, anchors, &time);
                } else {
                    hold_points(&friction, pair, manifold, impulses, bodies, anchors);
                }
            });
        }
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
    for (number, patch) in manifold.patches.iter().enumerate() {
        let range = manifold.range(patch);
        let held = &mut anchors.points[range.clone()];
        let given = given(impulses, patch, range.clone(), number);
        let given: SmallVec<[ContactImpulse; 8]> = given.collect();
        let coefficient = pair.surface_between(patch, bodies).friction;
        classify(friction.classifier, coefficient, &given, held);
        for (anchor, point) in held.iter_mut().zip(&manifold.points[range]) {
            let position = bodies[0].center + point.arm;
            if !anchor.sticking {
                *anchor = Anchor::default();
            } else if friction.anchors == AnchorRule::Literal {
                *anchor = write(bodies, patch.normal, position, Vec3::ZERO);
            } else if !anchor.set {
                *anchor = write(bodies, patch.normal, position, anchor.slip);
            }
        }
    }
}

/// The impulses at the points of a patch.
fn given<'a>(
    impulses: &'a ContactImpulses,
    patch: &'a ManifoldPatch,
    range: Range<usize>,
    number: usize,
) -> impl Iterator<Item = ContactImpulse> + 'a {
    range.map(move |point| ContactImpulse {
        normal: impulses.points[point].normal,
        tangential: impulses.tangential_at(patch, number, point),
    })
}

fn hold_patches(
    friction: &FrictionStabilization,
    pair: &ContactPair,
    manifold: &Manifold,
    impulses: &mut ContactImpulses,
    bodies: [&BodyState; 2],
    anchors: &mut ContactAnchors,
    time: &StepTime,
) {
    for (i, patch) in manifold.patches.iter().enumerate() {
        let anchor = &mut anchors.patches[i];
        let was = anchor.sticking;
        let dragged = std::mem::take(&mut impulses.patches[i].dragged);
        let coefficient = pair.surface_between(patch, bodies).friction;
        let rule = friction.classifier;
        anchor.sticking =
            !patch.curved && holds(rule, coefficient, manifold, impulses, i, was, time.dt);
        let stays = anchor.sticking
            || anchor.set && creeps(friction.creep_speed, manifold, impulses, i, bodies, time);
        if !stays {
            if anchor.set {
                anchors.measured = None;
            }
            *anchor = PatchAnchor::default();
            continue;
        }
        if !anchor.set {
            anchors.measured = None;
            *anchor = write_pose(bodies);
        }
        if dragged != Slip::default() {
            anchors.measured = None;
            let center = bodies[0].center + patch.center;
            drag(bodies[1], anchor, patch.normal, center, dragged);
        }
    }
}

/// Whether a patch under a steady load slid so slowly as the step began that it keeps its anchor, which moves only as far as the solver
/// drags it. Only Soft Step drags anchors, and only it finds loads at rest.
///
/// An anchor that is written anew carries nothing, whatever the old one carried. The limit of friction varies a little from step to step,
/// so a patch that is pushed with nearly that force slides in one step and sticks in the next. If it lost its anchor each time, it would
/// creep for ever.
#[cold]
fn creeps(
    creep_speed: f32,
    manifold: &Manifold,
    impulses: &ContactImpulses,
    number: usize,
    bodies: [&BodyState; 2],
    time: &StepTime,
) -> bool {
    let patch = &manifold.patches[number];
    let range = manifold.range(patch);
    let (mut force, mut at_rest) = (0.0, 0.0);
    for point in &impulses.points[range.clone()] {
        force += point.normal_force;
        at_rest += point.rest_force;
    }
    // In a step that is far shorter than others, the force is mostly that of the small velocities that it stopped, whatever the load.
    let share = time.dt / time.max_recent_dt;
    let slow = |point: &ContactPoint| {
        let velocity = slip_velocity(bodies, patch.normal, bodies[0].center + point.arm);
        velocity.length() < creep_speed
    };
    !patch.curved
        && at_rest > 0.0
        && (force - at_rest).abs() * share < STEADY_LOAD_SHARE * at_rest
        && manifold.points[range].iter().all(slow)
}

/// Whether a patch sticks as a whole.
#[inline]
fn holds(
    rule: Classifier,
    friction: f32,
    manifold: &Manifold,
    impulses: &ContactImpulses,
    number: usize,
    was: bool,
    dt: f32,
) -> bool {
    let patch = &manifold.patches[number];
    let of_patch = &impulses.patches[number];
    let (mut normal, mut lever) = (0.0, 0.0);
    let range = manifold.range(patch);
    let solved = &impulses.points[range.clone()];
    for (point, impulse) in manifold.points[range.clone()].iter().zip(solved) {
        normal += impulse.normal;
        lever += impulse.normal * (point.arm - patch.center).length();
    }
    let tangential = match impulses.friction.get(range.clone()) {
        Some(points) => points.iter().map(|point| point.tangential).sum(),
        None => of_patch.tangential,
    };
    let sum = ContactImpulse { normal, tangential };
    let each = given(impulses, patch, range, number);
    sticks(rule, friction, &sum, each, was)
        && holds_twist(friction, of_patch.twist_moment * dt, lever)
}
