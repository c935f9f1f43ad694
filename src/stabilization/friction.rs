//! Friction stabilization, equations (12)–(15) of the paper, and the stage **friction error**.
//!
//! A point that stuck in the last step should not have moved. How far it did, e, is measured between the places where the
//! two bodies carried its anchor, and the solver is asked for a tangential velocity that undoes it.

use crate::body::{BodyState, BodyTable};
use crate::contact::{Anchor, ContactAnchors, ContactPair, ContactPoint, ContactTargets, Manifold};
use crate::narrowphase::SERIAL_PAIRS;
use crate::settings::{AnchorRule, PhysicsThreads, StabilizationSettings, StepTime};
use bevy_ecs::prelude::*;
use glam::Vec3;
use rayon::prelude::*;

/// The projection P_n onto the contact plane, after equation (12).
pub fn project(normal: Vec3, v: Vec3) -> Vec3 {
    v - normal * normal.dot(v)
}

/// Equations (12)–(13): e = P_n (x_A − x_B), m, world axes, with the current normal; x_A and x_B are where the bodies have
/// carried the anchor.
pub fn anchor_error(normal: Vec3, x_a: Vec3, x_b: Vec3) -> Vec3 {
    project(normal, x_a - x_b)
}

/// Equations (14)–(15): the tangential velocity to demand, m/s, against the error.
pub fn slip_correction(settings: &StabilizationSettings, error: Vec3, dt: f32) -> Vec3 {
    let friction = &settings.friction;
    if error.length() <= friction.tolerance {
        return Vec3::ZERO;
    }
    (error * (-friction.gain / dt)).clamp_length_max(settings.max_correction_speed)
}

/// Where A and B have carried an anchor, x_A and x_B of equation (12), for a contact point at `point`.
///
/// A pair-pose anchor is evaluated at the contact point itself: the material of A that is there now, and where B would have
/// it had nothing moved.
fn carried(
    rule: AnchorRule,
    anchor: &Anchor,
    a: &BodyState,
    b: &BodyState,
    point: Vec3,
) -> [Vec3; 2] {
    match rule {
        AnchorRule::PairPose => {
            let in_a = a.pose.inverse_transform_point(point);
            let in_b = anchor.local[0] + anchor.rotation * in_a;
            [point, b.pose.transform_point(in_b)]
        }
        _ => [
            a.pose.transform_point(anchor.local[0]),
            b.pose.transform_point(anchor.local[1]),
        ],
    }
}

/// How far a sticking point has slipped, m, world axes; `None` where its anchor no longer holds.
///
/// Anchors are given up when they have come too far apart, along the surface or along the normal, and when the normal has
/// turned in either body: that is rolling, which must not be undone.
pub fn slip(
    settings: &StabilizationSettings,
    anchor: &Anchor,
    normal: Vec3,
    curved: bool,
    [a, b]: [&BodyState; 2],
    point: &ContactPoint,
    dt: f32,
) -> Option<Vec3> {
    let friction = &settings.friction;
    let last_step = || {
        project(
            normal,
            a.velocity_at(point.position) - b.velocity_at(point.position),
        ) * dt
    };
    if friction.anchors == AnchorRule::Trackless {
        return Some(last_step());
    }
    if !anchor.set {
        return None;
    }
    // A curved contact point wanders over both surfaces while it rolls. What it slips is the same, and is zero in pure
    // rolling.
    if curved && friction.anchors != AnchorRule::Literal {
        let slipped = project(normal, anchor.slip) + last_step();
        return (slipped.length() <= friction.max_error).then_some(slipped);
    }
    let [x_a, x_b] = carried(friction.anchors, anchor, a, b, point.position);
    let error = anchor_error(normal, x_a, x_b);
    let parted = normal.dot(x_a - x_b).abs();
    let straight = friction.max_turn.cos();
    let turned = [(a, anchor.normal[0]), (b, anchor.normal[1])]
        .iter()
        .any(|(body, local)| normal.dot(body.pose.rotation * *local) < straight);
    let holds = error.length() <= friction.max_error
        && parted <= friction.max_separation * settings.envelope
        && !turned;
    holds.then_some(error)
}

/// See the module's text.
pub fn friction_error(
    table: Res<BodyTable>,
    time: Res<StepTime>,
    settings: Res<StabilizationSettings>,
    threads: Res<PhysicsThreads>,
    mut pairs: Query<(
        &ContactPair,
        &Manifold,
        &mut ContactAnchors,
        &mut ContactTargets,
    )>,
) {
    let (table, settings, dt) = (&*table, &*settings, time.dt);
    for (pairs, manifolds, mut anchors, mut targets) in pairs
        .contiguous_iter_mut()
        .expect("pair components are stored in tables")
    {
        let columns = (
            pairs,
            manifolds,
            anchors.bypass_change_detection(),
            targets.bypass_change_detection(),
        );
        threads.run(|| {
            columns.into_par_iter().with_min_len(SERIAL_PAIRS).for_each(
                |(pair, manifold, anchors, targets)| {
                    for target in &mut targets.points {
                        target.tangential = Vec3::ZERO;
                    }
                    let [Some(a), Some(b)] = pair.slots.map(|slot| table.get(slot)) else {
                        return;
                    };
                    if !settings.friction.enabled {
                        return;
                    }
                    for patch in &manifold.patches {
                        for i in patch.range() {
                            let (point, anchor) = (&manifold.points[i], &mut anchors.points[i]);
                            if !anchor.sticking || point.distance > settings.outer_distance() {
                                continue;
                            }
                            let bodies = [a, b];
                            match slip(
                                settings,
                                anchor,
                                patch.normal,
                                patch.curved,
                                bodies,
                                point,
                                dt,
                            ) {
                                Some(error) => {
                                    anchor.slip = error;
                                    targets.points[i].tangential =
                                        slip_correction(settings, error, dt);
                                }
                                None => *anchor = Anchor::default(),
                            }
                        }
                    }
                },
            );
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::Preset;

    #[test]
    fn the_error_is_measured_in_the_current_contact_plane() {
        let e = anchor_error(Vec3::Y, Vec3::new(0.1, 0.5, 0.2), Vec3::new(0.0, -0.5, 0.0));
        assert_eq!(e, Vec3::new(0.1, 0.0, 0.2));
    }

    #[test]
    fn the_correction_opposes_the_error_above_the_tolerance_and_is_clamped() {
        let settings = Preset::Paper.stabilization();
        let c = slip_correction(&settings, Vec3::X * 0.01, 0.1);
        assert!((c + Vec3::X * 0.08).length() < 1e-6, "{c}");
        assert_eq!(slip_correction(&settings, Vec3::X * 1e-6, 0.1), Vec3::ZERO);
        let far = slip_correction(&settings, Vec3::Z * 10.0, 0.1);
        assert!((far + Vec3::Z * 2.0).length() < 1e-6, "{far}");
    }
}
