//! The swing cone of spherical joints.

use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::prelude::*;
use support::Lab;

/// Steps of 60, 30 and 10 Hz, s.
const STEPS: [f32; 3] = [1.0 / 60.0, 1.0 / 30.0, 0.1];

/// An arm of 1 m along a direction from the origin, held there by a joint about that axis.
fn arm(lab: &mut Lab, along: Vec3, joint: impl Fn(SphericalJoint) -> SphericalJoint) -> Entity {
    let at = Transform::from_translation(0.5 * along)
        .with_rotation(Quat::from_rotation_arc(Vec3::Y, along));
    let arm = lab.spawn((
        RigidBody::Dynamic,
        Collider::capsule(0.1, 0.8),
        Mass(4.0),
        at,
    ));
    let shoulder = SphericalJoint::new(None, arm)
        .with_anchor(Vec3::ZERO)
        .with_twist_axis(along);
    lab.spawn(joint(shoulder));
    arm
}

/// The swing of an arm from where it was added, and its twist as the rotation that is left without the swing, rad.
fn swing_and_twist(lab: &Lab, arm: Entity, along: Vec3) -> (f32, f32) {
    let was = Quat::from_rotation_arc(Vec3::Y, along);
    let turn = lab.pose(arm).rotation * was.inverse();
    let now = turn * along;
    let twist = Quat::from_rotation_arc(along, now).inverse() * turn;
    (
        now.angle_between(along),
        2.0 * twist.xyz().dot(along).atan2(twist.w),
    )
}

/// Thrown in all directions, it swings to the same angle, though the limits of a box would let it swing farther in some.
#[test]
fn an_arm_stops_at_its_cone_in_all_directions() {
    for dt in STEPS {
        for way in 0..8 {
            let angle = std::f32::consts::TAU * way as f32 / 8.0;
            let mut lab = Lab::shipped(dt);
            let arm = arm(&mut lab, Vec3::NEG_Y, |joint| joint.with_swing_cone(0.7));
            let push = Quat::from_rotation_y(angle) * Vec3::X;
            let spin = 8.0 * Vec3::NEG_Y.cross(push);
            lab.set_velocity(arm, spin.cross(lab.position(arm)), spin);
            let mut widest = 0f32;
            for _ in 0..(2.0 / dt) as usize {
                lab.step();
                widest = widest.max(swing_and_twist(&lab, arm, Vec3::NEG_Y).0);
            }
            let past = (widest - 0.7).to_degrees();
            assert!((-0.5..0.5).contains(&past), "{dt}, {way}: {past}° past it");
        }
    }
}

#[test]
fn an_arm_rests_at_its_cone() {
    for dt in STEPS {
        // Level, it falls to the lowest point of its cone.
        let mut lab = Lab::shipped(dt);
        let arm = arm(&mut lab, Vec3::X, |joint| joint.with_swing_cone(0.5));
        lab.run(2.0);
        for _ in 0..30 {
            lab.step();
            let (swing, _) = swing_and_twist(&lab, arm, Vec3::X);
            assert!((swing - 0.5).abs().to_degrees() < 0.1, "{dt}: {swing}");
            let [v, w] = [lab.velocity(arm).linear, lab.velocity(arm).angular];
            assert!(v.length().max(w.length()) < 1e-5, "{dt}: {v} {w}");
        }
    }
}

/// Where it does not reach the cone, an arm moves as it does without one.
#[test]
fn a_cone_has_no_influence_inside() {
    for dt in STEPS {
        let run = |cone: bool| {
            let mut lab = Lab::shipped(dt);
            let arm = arm(&mut lab, Vec3::NEG_Y, |joint| match cone {
                true => joint.with_swing_cone(1.2),
                false => joint,
            });
            let spin = Vec3::new(2.0, 1.5, 3.0);
            lab.set_velocity(arm, spin.cross(lab.position(arm)), spin);
            let mut path = Vec::new();
            for _ in 0..(3.0 / dt) as usize {
                lab.step();
                path.push(lab.pose(arm));
            }
            path
        };
        for (with, without) in run(true).into_iter().zip(run(false)) {
            let apart = with.position.distance(without.position);
            assert!(apart < 1e-5, "{dt}: {apart}");
        }
    }
}

/// The twist is limited by itself, however far the arm has swung.
#[test]
fn twist_stops_at_its_limits_beside_a_swing() {
    for dt in STEPS {
        let mut lab = Lab::shipped(dt);
        let arm = arm(&mut lab, Vec3::NEG_Y, |joint| {
            joint.with_swing_cone(0.9).with_twist_limits(-0.4, 0.4)
        });
        let spin = Vec3::new(0.0, 6.0, 7.0);
        lab.set_velocity(arm, spin.cross(lab.position(arm)), spin);
        let (mut swung, mut twisted) = (0f32, 0f32);
        for _ in 0..(4.0 / dt) as usize {
            lab.step();
            let (swing, twist) = swing_and_twist(&lab, arm, Vec3::NEG_Y);
            (swung, twisted) = (swung.max(swing), twisted.max(twist.abs()));
        }
        let past = [swung - 0.9, twisted - 0.4].map(f32::to_degrees);
        assert!(
            past.iter().all(|past| (-2.0..0.5).contains(past)),
            "{dt}: {past:?}° past them"
        );
    }
}
