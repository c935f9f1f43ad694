//! Friction stabilization, equations (12)–(15) of the paper, and the stage **friction error**.
//!
//! A point that stuck in the last step should not have moved. Its error e is the distance between the positions to which the two bodies
//! have carried its anchor. The solver is given a tangential velocity that corrects this error.

use crate::body::{BodyState, BodyTable};
use crate::graph::{ConstraintGraph, Islands};
use crate::pair::{
    Anchor, ContactAnchors, ContactPoint, ContactTargets, Lists, Manifold, ManifoldPatch,
    MovingSurfaces, PairsMut, Part, PatchAnchor, Target, fit, revise_edited,
};
use crate::settings::{
    ActiveSettings, AnchorRule, Classifier, PhysicsThreads, SolverSettings, StabilizationSettings,
    StepTime,
};
use crate::solver::{Both, Slip};
use bevy_ecs::entity::Entities;
use bevy_ecs::prelude::*;
use bevy_math::ops;
use glam::Vec3;
use smallvec::SmallVec;

/// The projection P_n onto the contact plane, after equation (12).
#[inline]
pub fn project(normal: Vec3, v: Vec3) -> Vec3 {
    v - normal * normal.dot(v)
}

/// The slip of an anchor, equations (12)–(13): e = P_n (x_A − x_B), m, world axes. `normal` is the current normal; x_A and x_B are the
/// positions to which the bodies have carried the anchor.
#[inline]
pub fn anchor_error(normal: Vec3, x_a: Vec3, x_b: Vec3) -> Vec3 {
    project(normal, x_a - x_b)
}

/// The tangential velocity that corrects an error, equations (14)–(15), m/s. Zero for errors within the tolerance.
pub fn slip_correction(settings: &StabilizationSettings, error: Vec3, dt: f32) -> Vec3 {
    let friction = &settings.friction;
    if error.length() <= friction.tolerance {
        return Vec3::ZERO;
    }
    (error * (-friction.gain / dt)).clamp_length_max(settings.max_correction_speed)
}

/// The velocity of the first body relative to the second along the surface at a point, m/s, world axes. `position` is the point, m.
pub fn slip_velocity([a, b]: [&BodyState; 2], normal: Vec3, position: Vec3) -> Vec3 {
    project(normal, a.velocity_at(position) - b.velocity_at(position))
}

/// The slip of a sticking point, m, world axes. `None` if its anchor no longer holds.
///
/// An anchor no longer holds if its two images are too far apart, along the surface or along the normal, or if the normal has rotated too
/// far in the frame of either body. The latter is rolling, which must not be corrected. `position` is the current position of the point,
/// m; `last` the length of the last step, s.
pub fn slip(
    settings: &StabilizationSettings,
    anchor: &Anchor,
    normal: Vec3,
    curved: bool,
    [a, b]: [&BodyState; 2],
    position: Vec3,
    last: f32,
) -> Option<Vec3> {
    let friction = &settings.friction;
    let last_step = || slip_velocity([a, b], normal, position) * last;
    if friction.anchors == AnchorRule::Trackless {
        return Some(last_step());
    }
    if !anchor.set {
        return None;
    }
    // A curved contact point moves over both surfaces while it rolls. Its slip is not affected, and is zero in pure rolling.
    if curved && friction.anchors != AnchorRule::Literal {
        let slipped = project(normal, anchor.slip) + last_step();
        return (slipped.length() <= friction.max_error).then_some(slipped);
    }
    let [x_a, x_b] = [(a, 0), (b, 1)].both(|(body, i)| body.pose.transform_point(anchor.local[i]));
    let error = anchor_error(normal, x_a, x_b);
    let parted = normal.dot(x_a - x_b).abs();
    let straight = ops::cos(friction.max_turn);
    let turned = [(a, anchor.normal[0]), (b, anchor.normal[1])]
        .iter()
        .any(|(body, local)| normal.dot(body.pose.rotation * *local) < straight);
    let holds =
        error.length() <= friction.max_error && parted <= friction.max_separation && !turned;
    holds.then_some(error)
}

/// The slip of a whole patch since its bodies began to stick. `None` if its anchor no longer holds.
///
/// It compares the patch's centre as a point of A with the position to which B would have carried that point without slip.
#[inline]
pub fn pose_slip(
    settings: &StabilizationSettings,
    anchor: &PatchAnchor,
    normal: Vec3,
    [a, b]: [&BodyState; 2],
    center: Vec3,
) -> Option<PlanarSlip> {
    let friction = &settings.friction;
    // The rotation of A relative to B since the anchor was set, and the displacements of its origin and of its arm to the centre.
    let turned = a.pose.rotation * (b.pose.rotation * anchor.rotation()).inverse();
    let (axis, w) = (turned.xyz(), turned.w);
    let across = axis.cross(center - a.pose.position);
    let carried = a.pose.position - b.pose.position - b.pose.rotation * anchor.position;
    let way = carried + 2.0 * (w * across - axis.cross(across));
    let turned = 2.0 * axis * w.signum();
    let shift = project(normal, way);
    let parted = normal.dot(way).abs();
    let squared = |x: f32| x * x;
    let holds = shift.length_squared() <= squared(friction.max_error)
        && parted <= friction.max_separation
        && turned.length_squared() <= squared(friction.max_turn);
    holds.then_some(PlanarSlip {
        center,
        shift,
        twist: normal * normal.dot(turned),
    })
}

/// The slip of two surfaces on each other: a rigid motion in the contact plane.
///
/// The slips of points of one manifold may contradict each other, if they were anchored at different times or carried around a corner: no
/// motion of two rigid bodies can correct them all. A solver would respond with friction impulses that work against each other and grow
/// until they fill the cone. It is therefore given the rigid motion nearest to the slips of the points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanarSlip {
    center: Vec3,
    /// Slip at the centre, m.
    shift: Vec3,
    /// Rotation about the normal, rad, as a vector along it.
    twist: Vec3,
}

impl PlanarSlip {
    /// The least-squares fit to pairs of points and their slips (world, m). `None` if there are no points.
    pub fn fit(normal: Vec3, slips: &[(Vec3, Vec3)]) -> Option<Self> {
        let share = 1.0 / slips.len().max(1) as f32;
        let center = slips.iter().map(|(p, _)| *p).sum::<Vec3>() * share;
        let shift = slips.iter().map(|(_, e)| *e).sum::<Vec3>() * share;
        let (mut moment, mut spread) = (0.0, 0.0);
        for (point, e) in slips {
            let arm = project(normal, *point - center);
            moment += normal.dot(arm.cross(*e));
            spread += arm.length_squared();
        }
        let twist = if spread > 0.0 {
            normal * (moment / spread)
        } else {
            Vec3::ZERO
        };
        (!slips.is_empty()).then_some(Self {
            center,
            shift,
            twist,
        })
    }

    /// The same slip as a shift at a point and a rotation about the normal.
    #[inline]
    fn about(&self, normal: Vec3, point: Vec3) -> Slip {
        Slip {
            shift: self.at(point),
            twist: normal.dot(self.twist),
        }
    }

    /// The slip at a point, m.
    pub fn at(&self, point: Vec3) -> Vec3 {
        self.shift + self.twist.cross(point - self.center)
    }
}

/// The slip of a patch from its sticking points. Deletes anchors that no longer hold.
fn measure_points(
    settings: &StabilizationSettings,
    patch: &ManifoldPatch,
    bodies: [&BodyState; 2],
    points: &[ContactPoint],
    anchors: &mut [Anchor],
    last: f32,
) -> Option<PlanarSlip> {
    let mut slips: SmallVec<[(Vec3, Vec3); 8]> = SmallVec::new();
    for (point, anchor) in points.iter().zip(anchors) {
        if !anchor.sticking {
            continue;
        }
        let position = bodies[0].center + point.arm;
        match slip(
            settings,
            anchor,
            patch.normal,
            patch.curved,
            bodies,
            position,
            last,
        ) {
            Some(error) => slips.push((position, error)),
            None => *anchor = Anchor::default(),
        }
    }
    PlanarSlip::fit(patch.normal, &slips)
}

/// The slip of a patch under any anchor rule. Deletes anchors that no longer hold.
fn measure(
    settings: &StabilizationSettings,
    patch: &ManifoldPatch,
    bodies: [&BodyState; 2],
    points: &[ContactPoint],
    anchor: &mut PatchAnchor,
    anchors: &mut [Anchor],
    last: f32,
) -> Option<PlanarSlip> {
    if !settings.friction.enabled {
        // Recycled manifolds keep their targets, so earlier ones must be cleared.
        return None;
    }
    if settings.friction.anchors != AnchorRule::PairPose {
        return measure_points(settings, patch, bodies, points, anchors, last);
    }
    if !anchor.set {
        return None;
    }
    let center = bodies[0].center + patch.center;
    let slip = pose_slip(settings, anchor, patch.normal, bodies, center);
    if slip.is_none() {
        *anchor = PatchAnchor::default();
    }
    slip
}

/// Measures the slip of all pairs and writes it to their [`ContactTargets`].
pub fn friction_error(
    (table, islands, surfaces): (Res<BodyTable>, Res<Islands>, Res<MovingSurfaces>),
    (graph, places): (Res<ConstraintGraph>, &Entities),
    time: Res<StepTime>,
    settings: Res<StabilizationSettings>,
    solver: Res<SolverSettings>,
    (threads, active_settings): (Res<PhysicsThreads>, Res<ActiveSettings>),
    mut pairs: PairsMut,
) {
    let (table, settings, last) = (&*table, &*settings, time.previous_dt);
    let by_points = solver.solver.is_point_solver();
    let by_pose = settings.friction.anchors == AnchorRule::PairPose;
    let tables = pairs.contiguous_iter_mut();
    for (entities, mut columns) in tables.expect("pair components are stored in tables") {
        for rows in &*graph.active_rows(entities, places) {
            let (mut pairs, _, manifolds, _, mut anchors, mut targets) = columns.part(rows);
            revise_edited!(pairs, manifolds, anchors);
            let activate = active_settings.changed || islands.woke();
            let always = active_settings.changed || by_points || !by_pose;
            let columns = (
                &*pairs,
                &*manifolds,
                anchors.bypass_change_detection(),
                targets.bypass_change_detection(),
            );
            threads.each(columns, |(pair, manifold, anchors, targets)| {
                if pair.is_idle() && !activate || pair.is_apart() && !always {
                    return;
                }
                let Some([a, b]) = table.both(pair.slots) else {
                    return;
                };
                if anchors.measured == Some(pair.revision) && !a.moved && !b.moved && !always {
                    return;
                }
                anchors.measured = Some(pair.revision);
                let lists = Lists {
                    anchors: Some((&mut *anchors, !by_pose)),
                    targets: Some((&mut *targets, by_points)),
                    ..Default::default()
                };
                fit(manifold, lists);
                if let Some(velocity) = surfaces.get(pair.edge) {
                    slide(velocity, manifold, anchors, targets);
                    return;
                }
                for (i, patch) in manifold.patches.iter().enumerate() {
                    let range = manifold.range(patch);
                    let points = &manifold.points[range.clone()];
                    let held = match by_pose {
                        true => &mut [],
                        false => &mut anchors.points[range.clone()],
                    };
                    let anchor = &mut anchors.patches[i];
                    let slip = measure(settings, patch, [a, b], points, anchor, held, last);
                    targets.patches[i] = slip.map(|slip| slip.about(patch.normal, slip.center));
                    if by_points {
                        let targets = &mut targets.points[range];
                        let at = (a.center, points);
                        demand(settings, slip, at, held, targets, time.max_recent_dt);
                    }
                }
            });
        }
    }
}

/// Sets the targets of a pair whose surfaces move against their bodies: a velocity instead of a slip.
fn slide(
    velocity: Vec3,
    manifold: &Manifold,
    anchors: &mut ContactAnchors,
    targets: &mut ContactTargets,
) {
    anchors.patches.fill(PatchAnchor::default());
    anchors.points.fill(Anchor::default());
    targets.patches.fill(None);
    for patch in &manifold.patches {
        let range = manifold.range(patch);
        // Only point solvers have targets of points.
        for target in targets.points.get_mut(range).into_iter().flatten() {
            target.tangential = project(patch.normal, velocity);
        }
    }
}

/// Sets the tangential velocities that correct the slip of a patch at its points, whose lever arms begin at `center`.
fn demand(
    settings: &StabilizationSettings,
    slip: Option<PlanarSlip>,
    (center, points): (Vec3, &[ContactPoint]),
    anchors: &mut [Anchor],
    targets: &mut [Target],
    dt: f32,
) {
    let Some(slip) = slip else {
        for target in targets {
            target.tangential = Vec3::ZERO;
        }
        return;
    };
    let friction = &settings.friction;
    let each =
        friction.classifier == Classifier::PerPoint && friction.anchors != AnchorRule::PairPose;
    for (i, (point, target)) in points.iter().zip(targets).enumerate() {
        let error = slip.at(center + point.arm);
        let mut sticks = !each;
        if let Some(anchor) = anchors.get_mut(i) {
            anchor.slip = error;
            sticks |= anchor.sticking;
        }
        let held = sticks && point.distance <= settings.outer_distance();
        target.tangential = if held {
            slip_correction(settings, error, dt)
        } else {
            Vec3::ZERO
        };
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
    fn a_patch_slips_as_a_rigid_body_does() {
        let twist = Vec3::Y * 0.01;
        let corners =
            [(-1.0, -2.0), (1.0, -2.0), (1.0, 2.0), (-1.0, 2.0)].map(|(x, z)| Vec3::new(x, 0.5, z));
        let moved = corners.map(|p| (p, Vec3::X * 0.03 + twist.cross(p)));
        let slip = PlanarSlip::fit(Vec3::Y, &moved).unwrap();
        for (p, e) in moved {
            assert!((slip.at(p) - e).length() < 1e-6);
        }
        // Slips that no rigid motion can have, here corners pulled apart, are left out.
        let apart = corners.map(|p| (p, 0.01 * p.with_y(0.0)));
        let slip = PlanarSlip::fit(Vec3::Y, &apart).unwrap();
        assert!(slip.at(corners[0]).length() < 1e-6);
        assert_eq!(PlanarSlip::fit(Vec3::Y, &[]), None);
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
