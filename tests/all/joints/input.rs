//! Bad input: a clear error, the joint disabled, the world alive, and a way out again.

use super::{ball, drain};
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::joint::JointProblem;
use drystone::prelude::*;
use support::Lab;

/// What is wrong with a pendulum, and the problem that is reported.
type Break = fn(&mut SphericalJoint, [Entity; 4]);

#[test]
fn invalid_joints_are_reported_and_come_back_when_they_are_mended() {
    let cases: [(Break, &str); 12] = [
        (
            |joint, _| joint.frame1.anchor = JointAnchor::Local(Vec3::NAN),
            "anchor",
        ),
        (
            |joint, _| joint.frame2.anchor = JointAnchor::FromGlobal(Vec3::INFINITY),
            "anchor",
        ),
        (
            |joint, _| joint.frame1.basis = JointBasis::Local(Quat::from_xyzw(0.0, 0.0, 0.0, 0.0)),
            "basis",
        ),
        (|joint, _| joint.twist_axis = Vec3::ZERO, "axis"),
        (
            |joint, _| joint.twist_limits = Some(JointLimits::new(0.5, -0.5)),
            "above the maximum",
        ),
        (
            |joint, _| joint.swing_limits = Some(JointLimits::new(f32::NAN, 1.0)),
            "not numbers",
        ),
        (|joint, _| joint.swing_cone = Some(0.0), "swing cone"),
        (|joint, _| joint.swing_cone = Some(f32::NAN), "swing cone"),
        (|joint, _| joint.friction = -1.0, "friction"),
        (
            |joint, [_, _, stray, _]| joint.body1 = Some(stray),
            "not a body",
        ),
        (|joint, _| joint.body1 = joint.body2, "both of its bodies"),
        (
            |joint, [_, fixed, _, _]| (joint.body1, joint.body2) = (None, Some(fixed)),
            "dynamic",
        ),
    ];
    for (spoil, says) in cases {
        let mut lab = Lab::shipped(1.0 / 60.0);
        let bob = ball(&mut lab, 1.0, Vec3::ZERO);
        let fixed = lab.spawn((RigidBody::Static, Transform::default()));
        let stray = lab.spawn(Transform::default());
        let other = ball(&mut lab, 1.0, Vec3::X * 5.0);
        let good = SphericalJoint::new(None, bob).with_anchor(Vec3::Y);
        let hook = lab.spawn((good, Name::new("hook")));
        lab.spawn(FixedJoint::new(None, other));
        lab.run(0.2);
        let good = lab.world.get::<SphericalJoint>(hook).unwrap().clone();
        let mut joint = lab.world.get_mut::<SphericalJoint>(hook).unwrap();
        spoil(&mut joint, [bob, fixed, stray, other]);
        lab.run(0.1);
        let told = drain::<JointError>(&mut lab);
        assert_eq!(told.len(), 1, "{says}: {told:?}");
        let line = told[0].to_string();
        assert!(
            line.contains(says) && line.contains("`hook`"),
            "{says}: {line}"
        );
        assert!(line.contains("comes back by itself"), "{line}");
        assert!(lab.world.entity(hook).contains::<QuarantinedJoint>());
        assert!(lab.position(bob).y < -0.02, "{says}: it falls");
        assert!(
            lab.position(other).distance(Vec3::X * 5.0) < 1e-3,
            "{says}: others hold"
        );
        *lab.world.get_mut::<SphericalJoint>(hook).unwrap() = good;
        lab.run(1.5);
        assert!(
            !lab.world.entity(hook).contains::<QuarantinedJoint>(),
            "{says}"
        );
        let far = lab.position(bob).distance(Vec3::Y);
        assert!((far - 1.0).abs() < 0.01, "{says}: {far}");
        assert_eq!(lab.errors(), []);
    }
}

#[test]
fn other_invalid_input() {
    let mut lab = Lab::shipped(1.0 / 60.0);
    let bob = ball(&mut lab, 1.0, Vec3::ZERO);
    let problems: Vec<(Entity, JointProblem)> = vec![
        (
            lab.spawn(DistanceJoint::new(None, bob).with_limits(0.0, 0.0)),
            JointProblem::InvalidDistance,
        ),
        (
            lab.spawn(SpringJoint::new(None, bob).with_stiffness(-1.0)),
            JointProblem::InvalidMotor,
        ),
        (
            lab.spawn(
                RevoluteJoint::new(None, bob).with_motor(JointMotor::velocity(f32::NAN, 1.0)),
            ),
            JointProblem::InvalidMotor,
        ),
        (
            lab.spawn((FixedJoint::new(None, bob), BreakForce::new(f32::NAN))),
            JointProblem::InvalidBreakForce,
        ),
        (
            lab.spawn((FixedJoint::new(None, bob), SphericalJoint::new(None, bob))),
            JointProblem::SeveralJoints,
        ),
        (
            lab.spawn(FixedJoint::new(None, None)),
            JointProblem::NothingMoves,
        ),
    ];
    lab.run(0.2);
    let told = drain::<JointError>(&mut lab);
    let found: Vec<_> = told
        .iter()
        .map(|error| (error.joint, error.problem))
        .collect();
    assert_eq!(found, problems);
    assert!(lab.position(bob).y < -0.1, "it falls");
}

/// A body that is quarantined is not the fault of its joint.
#[test]
fn a_joint_waits_for_a_quarantined_body() {
    let mut lab = Lab::shipped(1.0 / 60.0);
    let bob = ball(&mut lab, 1.0, Vec3::ZERO);
    lab.spawn(SphericalJoint::new(None, bob).with_anchor(Vec3::Y));
    lab.run(0.2);
    lab.world.entity_mut(bob).insert(Mass(f32::NAN));
    lab.run(0.2);
    assert_eq!(lab.errors().len(), 1);
    assert_eq!(drain::<JointError>(&mut lab), []);
    lab.world.entity_mut(bob).insert(Mass(2.0));
    lab.run(1.0);
    assert!(lab.position(bob).length() < 5e-3);
}
