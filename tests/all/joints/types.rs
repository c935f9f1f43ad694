//! Each type does what its name says.

use super::{ball, body, forces};
use bevy_transform::components::Transform;
use drystone::prelude::*;
use support::{G, Lab, assert_near};

#[test]
fn a_door_swings_about_its_hinge() {
    let mut lab = Lab::shipped(1.0 / 60.0);
    let door = body(
        &mut lab,
        Collider::cuboid(1.0, 2.0, 0.05),
        20.0,
        Vec3::new(0.5, 1.0, 0.0),
    );
    lab.set_velocity(door, Vec3::Z * -0.5, Vec3::Y);
    let hinge = RevoluteJoint::new(None, door)
        .with_anchor(Vec3::Y)
        .with_hinge_axis(Vec3::Y);
    let hinge = lab.spawn(hinge);
    for _ in 0..180 {
        lab.step();
        let at = lab.position(door);
        assert!((at.with_y(0.0).length() - 0.5).abs() < 2e-3, "{at}");
        assert!((at.y - 1.0).abs() < 2e-3, "{at}");
        let upright = lab.pose(door).rotation * Vec3::Y;
        assert!(upright.dot(Vec3::Y) > 1.0 - 1e-5, "{upright}");
    }
    // Nothing brakes it, so it has gone on at 1 rad/s.
    let spin = lab.velocity(door).angular;
    assert!((spin - Vec3::Y).length() < 0.02, "{spin}");
    assert_near(
        forces(&lab, hinge).force.y,
        20.0 * G,
        1e-2,
        "weight of the door",
    );
}

#[test]
fn a_hinge_stops_at_its_limits_and_stays_there() {
    for axis in [Vec3::Y, Vec3::NEG_Y, Vec3::new(0.0, 2.0, 0.0)] {
        let mut lab = Lab::shipped(1.0 / 60.0);
        let door = body(
            &mut lab,
            Collider::cuboid(1.0, 2.0, 0.05),
            20.0,
            Vec3::new(0.5, 1.0, 0.0),
        );
        lab.set_velocity(door, Vec3::Z * -0.5, Vec3::Y);
        let (min, max) = if axis.y > 0.0 {
            (-0.2, 0.8)
        } else {
            (-0.8, 0.2)
        };
        let hinge = RevoluteJoint::new(None, door)
            .with_anchor(Vec3::Y)
            .with_hinge_axis(axis)
            .with_angle_limits(min, max);
        lab.spawn(hinge);
        let mut most: f32 = 0.0;
        for _ in 0..180 {
            lab.step();
            let out = lab.pose(door).rotation * Vec3::X;
            most = most.max(f32::atan2(-out.z, out.x));
        }
        assert!((most - 0.8).abs() < 0.02, "{axis}: {most}");
    }
}

#[test]
fn a_slider_slides_along_its_axis_only() {
    let mut lab = Lab::shipped(1.0 / 60.0);
    let drawer = body(&mut lab, Collider::cuboid(0.5, 0.2, 0.5), 3.0, Vec3::Y);
    lab.set_velocity(drawer, Vec3::new(0.4, 0.0, 0.0), Vec3::ZERO);
    lab.spawn(PrismaticJoint::new(None, drawer).with_limits(-0.1, 0.3));
    let mut far: f32 = 0.0;
    for _ in 0..120 {
        lab.step();
        let pose = lab.pose(drawer);
        far = far.max(pose.position.x);
        assert!(
            (pose.position - Vec3::Y).with_x(0.0).length() < 2e-3,
            "{pose:?}"
        );
        assert!(
            pose.rotation.angle_between(Quat::IDENTITY) < 2e-3,
            "{pose:?}"
        );
    }
    assert!((far - 0.3).abs() < 5e-3, "{far}");
}

#[test]
fn a_bar_in_a_sleeve_slides_and_turns_and_does_nothing_else() {
    let mut lab = Lab::shipped(1.0 / 60.0);
    let bar = body(&mut lab, Collider::cuboid(1.0, 0.1, 0.1), 3.0, Vec3::Y);
    lab.set_velocity(bar, Vec3::X * 0.4, Vec3::X * 2.0);
    let sleeve = lab.spawn(CylindricalJoint::new(None, bar).with_slide_limits(-0.1, 0.3));
    let mut far: f32 = 0.0;
    for _ in 0..120 {
        lab.step();
        let pose = lab.pose(bar);
        far = far.max(pose.position.x);
        let aside = (pose.position - Vec3::Y).with_x(0.0).length();
        assert!(aside < 2e-3, "{pose:?}");
        let tilt = (pose.rotation * Vec3::X).angle_between(Vec3::X);
        assert!(tilt < 2e-3, "{pose:?}");
    }
    assert!((far - 0.3).abs() < 5e-3, "{far}");
    // The end of the slide does not brake the rotation, and the sleeve bears the weight.
    let spin = lab.velocity(bar).angular;
    assert!((spin - Vec3::X * 2.0).length() < 0.02, "{spin}");
    assert_near(forces(&lab, sleeve).force.y, 3.0 * G, 1e-2, "weight");
}

#[test]
fn a_bar_in_a_sleeve_is_driven_and_braked_along_and_about_its_axis() {
    let mut lab = Lab::shipped(1.0 / 60.0);
    let shape = || Collider::cuboid(1.0, 0.1, 0.1);
    let driven = body(&mut lab, shape(), 3.0, Vec3::Y);
    let joint = CylindricalJoint::new(None, driven)
        .with_slide_motor(JointMotor::velocity(0.2, 100.0))
        .with_angle_motor(JointMotor::velocity(1.5, 100.0))
        .with_angle_limits(0.0, 1.0);
    lab.spawn(joint);
    let braked = body(&mut lab, shape(), 3.0, Vec3::Y * 3.0);
    lab.set_velocity(braked, Vec3::X, Vec3::X);
    lab.spawn(CylindricalJoint::new(None, braked).with_friction(30.0, 0.1));
    lab.run(2.0);
    let at = lab.pose(driven);
    assert_near(at.position.x, 0.4, 2e-2, "driven along");
    assert_near(at.rotation.to_scaled_axis().x, 1.0, 1e-2, "driven about");
    // ½ v² m / F.
    let at = lab.pose(braked);
    assert_near(at.position.x, 0.5 * 3.0 / 30.0, 5e-2, "braked along");
    assert!(lab.velocity(braked).angular.length() < 1e-4);
}

#[test]
fn a_rope_is_slack_and_then_tight() {
    let mut lab = Lab::shipped(1.0 / 60.0);
    let bucket = ball(&mut lab, 5.0, Vec3::Y * 2.5);
    let rope = DistanceJoint::new(None, bucket)
        .with_local_anchor1(Vec3::Y * 3.0)
        .with_max_distance(2.0);
    let rope = lab.spawn(rope);
    // It falls freely for 1.5 m.
    lab.run(0.5);
    assert_eq!(forces(&lab, rope).force, Vec3::ZERO);
    assert_near(
        lab.velocity(bucket).linear.y,
        -0.5 * G,
        1e-2,
        "falls freely",
    );
    lab.run(3.0);
    assert!(
        (lab.position(bucket).y - 1.0).abs() < 3e-3,
        "{}",
        lab.position(bucket)
    );
    assert_near(forces(&lab, rope).force.y, 5.0 * G, 1e-2, "tight");
    // It does not push.
    lab.set_velocity(bucket, Vec3::Y * 2.0, Vec3::ZERO);
    lab.run(0.1);
    assert!(lab.position(bucket).y > 1.1);
    assert_eq!(forces(&lab, rope).force, Vec3::ZERO);
}

#[test]
fn a_rod_keeps_its_length_both_ways() {
    let mut lab = Lab::shipped(1.0 / 60.0);
    let foot = lab.spawn((RigidBody::Static, Transform::default()));
    let bob = ball(&mut lab, 1.0, Vec3::new(0.6, 0.8, 0.0));
    lab.spawn(DistanceJoint::new(foot, bob));
    for _ in 0..120 {
        lab.step();
        let far = lab.position(bob).length();
        assert!((far - 1.0).abs() < 3e-3, "{far}");
    }
}

#[test]
fn a_fixed_joint_holds_a_cantilever() {
    let mut lab = Lab::shipped(1.0 / 60.0);
    let wall = lab.spawn((RigidBody::Static, Transform::from_xyz(-0.5, 2.0, 0.0)));
    let mut last = wall;
    let mut joints = Vec::new();
    for i in 0..5 {
        let at = Vec3::new(0.25 + 0.5 * i as f32, 2.0, 0.0);
        let block = body(&mut lab, Collider::cuboid(0.5, 0.5, 0.5), 100.0, at);
        let joint = FixedJoint::new(last, block).with_anchor(at - Vec3::X * 0.25);
        joints.push(lab.spawn(joint));
        last = block;
    }
    lab.run(3.0);
    let sag = 2.0 - lab.position(last).y;
    println!("the tip hangs {:.3} mm low", 1e3 * sag);
    assert!(sag.abs() < 2e-3, "{sag}");
    let root = forces(&lab, joints[0]);
    assert_near(root.force.y, 500.0 * G, 1e-2, "weight");
    assert_near(root.torque.z, 500.0 * G * 1.25, 1e-2, "moment");
}

#[test]
fn a_spring_oscillates_at_its_frequency() {
    let mut lab = Lab::shipped(1.0 / 60.0);
    lab.world.insert_resource(Gravity(Vec3::ZERO));
    let bob = ball(&mut lab, 2.0, Vec3::X * 1.5);
    let spring = SpringJoint::new(None, bob)
        .with_local_anchor1(Vec3::ZERO)
        .with_rest_length(1.0)
        .with_stiffness(50.0);
    lab.spawn(spring);
    // Half periods, by when it comes through the rest length.
    let mut crossings = Vec::new();
    let mut before = lab.position(bob).x - 1.0;
    for step in 1..600 {
        lab.step();
        let now = lab.position(bob).x - 1.0;
        if before * now < 0.0 {
            crossings.push((step as f32 - now / (now - before)) * lab.dt);
        }
        before = now;
    }
    let count = crossings.len() - 1;
    let period = 2.0 * (crossings[count] - crossings[0]) / count as f32;
    let expected = std::f32::consts::TAU * (2.0_f32 / 50.0).sqrt();
    assert_near(period, expected, 1e-2, "period");
}

#[test]
fn a_motor_reaches_its_speed_with_its_torque() {
    let mut lab = Lab::shipped(1.0 / 60.0);
    lab.world.insert_resource(Gravity(Vec3::ZERO));
    let wheel = body(&mut lab, Collider::cylinder(0.5, 0.2), 10.0, Vec3::ZERO);
    let inertia = lab_inertia(&mut lab, wheel);
    let motor = RevoluteJoint::new(None, wheel)
        .with_hinge_axis(Vec3::Y)
        .with_motor(JointMotor::velocity(5.0, 2.0));
    let joint = lab.spawn(motor);
    lab.run(0.5);
    assert_near(
        lab.velocity(wheel).angular.y,
        2.0 / inertia * 0.5,
        2e-2,
        "by its torque",
    );
    lab.run(3.0);
    assert_near(lab.velocity(wheel).angular.y, 5.0, 1e-3, "its speed");
    // A servo goes to an angle and holds it.
    let mut hinge = lab.world.get_mut::<RevoluteJoint>(joint).unwrap();
    hinge.motor = Some(JointMotor::position(1.0, 200.0, 60.0));
    lab.run(10.0);
    let out = lab.pose(wheel).rotation * Vec3::X;
    assert_near(f32::atan2(-out.z, out.x), 1.0, 1e-2, "its angle");
}

fn lab_inertia(lab: &mut Lab, body: bevy_ecs::entity::Entity) -> f32 {
    lab.step();
    lab.mass(body).inverse_inertia.y.recip()
}

#[test]
fn friction_holds_up_to_its_maximum() {
    for (friction, holds) in [(60.0, true), (40.0, false)] {
        let mut lab = Lab::shipped(1.0 / 60.0);
        let cage = body(&mut lab, Collider::cuboid(0.5, 0.5, 0.5), 5.0, Vec3::Y);
        let joint = PrismaticJoint::new(None, cage)
            .with_slider_axis(Vec3::Y)
            .with_friction(friction);
        lab.spawn(joint);
        lab.run(1.0);
        let fallen = 1.0 - lab.position(cage).y;
        match holds {
            true => assert!(fallen.abs() < 1e-3, "{fallen}"),
            false => assert_near(fallen, 0.5 * (G - friction / 5.0), 0.05, "slides"),
        }
    }
}

#[test]
fn a_limited_ball_joint_swings_no_farther() {
    let mut lab = Lab::shipped(1.0 / 60.0);
    let arm = body(&mut lab, Collider::capsule(0.1, 0.8), 4.0, Vec3::Y * -0.5);
    lab.set_velocity(arm, Vec3::X * 3.0, Vec3::Z * 6.0);
    let shoulder = SphericalJoint::new(None, arm)
        .with_anchor(Vec3::ZERO)
        .with_swing_limits(-0.5, 0.5)
        .with_twist_limits(-0.3, 0.3);
    lab.spawn(shoulder);
    let mut most: f32 = 0.0;
    for _ in 0..240 {
        lab.step();
        let down = lab.pose(arm).rotation * Vec3::Y;
        most = most.max(down.angle_between(Vec3::Y));
    }
    assert!((0.45..0.55).contains(&most), "{most}");
}

#[test]
fn several_joints_hold_two_bodies_together() {
    let mut lab = Lab::shipped(1.0 / 60.0);
    let post = lab.spawn((RigidBody::Static, Transform::default()));
    let gate = body(
        &mut lab,
        Collider::cuboid(1.0, 2.0, 0.1),
        30.0,
        Vec3::X * 0.5,
    );
    // Two ball joints on top of each other are a hinge.
    let hooks =
        [0.8, -0.8].map(|y| lab.spawn(SphericalJoint::new(post, gate).with_anchor(Vec3::Y * y)));
    lab.run(2.0);
    let at = lab.position(gate);
    assert!((at - Vec3::X * 0.5).length() < 3e-3, "{at}");
    let [upper, lower] = hooks.map(|hook| forces(&lab, hook).force);
    assert_near(upper.y + lower.y, 30.0 * G, 1e-2, "weight");
    assert_near(-upper.x, 30.0 * G * 0.5 / 1.6, 2e-2, "upper hook pulls");
    assert_near(lower.x, 30.0 * G * 0.5 / 1.6, 2e-2, "lower hook pushes");
}

#[test]
fn anchors_that_are_not_given_are_where_the_bodies_are() {
    let mut lab = Lab::shipped(1.0 / 60.0);
    let turned = Quat::from_euler(bevy_math_euler(), 0.3, 0.4, 0.5);
    let one = Transform::from_xyz(1.0, 2.0, 3.0).with_rotation(turned);
    let one = lab.spawn((RigidBody::Static, one));
    let other = body(&mut lab, Collider::ball(0.2), 1.0, Vec3::new(1.5, 2.5, 3.0));
    let joint = lab.spawn(FixedJoint::new(one, other));
    lab.run(1.0);
    assert!(lab.position(other).distance(Vec3::new(1.5, 2.5, 3.0)) < 1e-3);
    // The step that added it has made its frames local.
    let joint = lab.world.get::<FixedJoint>(joint).unwrap();
    let JointAnchor::Local(anchor) = joint.frame1.anchor else {
        panic!("{:?}", joint.frame1);
    };
    let expected = turned.inverse() * Vec3::new(0.5, 0.5, 0.0);
    assert!(anchor.distance(expected) < 1e-5, "{anchor}");
}

fn bevy_math_euler() -> glam::EulerRot {
    glam::EulerRot::XYZ
}

#[test]
fn a_generic_joint_does_what_its_axes_say() {
    let mut lab = Lab::shipped(1.0 / 60.0);
    let bead = ball(&mut lab, 1.0, Vec3::Y);
    lab.set_velocity(bead, Vec3::new(0.5, 0.0, 0.7), Vec3::Y * 3.0);
    let joint = GenericJoint::new(None, bead)
        .with_locked_axes(JointAxes::LIN_Y | JointAxes::ANG_X | JointAxes::ANG_Z)
        .with_limits(JointAxes::LIN_Z, -0.5, 0.5)
        .with_friction(JointAxes::ANG_Y, 1.0);
    lab.spawn(joint);
    lab.run(2.0);
    let at = lab.position(bead);
    assert!(
        (at.x - 1.0).abs() < 0.02 && (at.y - 1.0).abs() < 2e-3,
        "{at}"
    );
    assert!((at.z - 0.5).abs() < 0.01, "{at}");
    assert!(lab.velocity(bead).angular.length() < 1e-2);
}

/// A carriage that can slide along x only bears a pendulum: its joint pulls it neither down nor round.
#[test]
fn locked_axes_bear_what_joints_ask() {
    for dt in [1.0 / 60.0, 0.1] {
        let mut lab = Lab::shipped(dt);
        let carriage = body(
            &mut lab,
            Collider::cuboid(0.5, 0.2, 0.2),
            2.0,
            Vec3::Y * 3.0,
        );
        let axes = LockedAxes::new().lock_translation_y().lock_rotation_z();
        lab.world.entity_mut(carriage).insert(axes);
        let bob = ball(&mut lab, 10.0, Vec3::new(0.2, 2.0, 0.0));
        let anchor = Vec3::new(0.2, 3.0, 0.0);
        let joint = lab.spawn(SphericalJoint::new(carriage, bob).with_anchor(anchor));
        let begin = *lab.world.get::<Transform>(carriage).unwrap();
        let mut gap = 0f32;
        for _ in 0..(3.0 / dt).round() as usize {
            lab.step();
            let now = *lab.world.get::<Transform>(carriage).unwrap();
            let bob = lab.world.get::<Transform>(bob).unwrap();
            gap = gap.max(
                (bob.translation + bob.rotation * Vec3::Y).distance(now * Vec3::new(0.2, 0.0, 0.0)),
            );
            assert_eq!(now.translation.y, begin.translation.y);
            assert_eq!(now.rotation.z, 0.0);
        }
        assert!(gap < 1e-4, "{dt}: {gap}");
        assert_near(
            forces(&lab, joint).force.y,
            10.0 * G,
            1e-3,
            "the carriage bears the bob",
        );
        // It slides along, and the centre of both stays.
        let shove = Vec3::X * 1.0;
        lab.set_velocity(bob, shove, Vec3::ZERO);
        let center =
            |lab: &Lab| (2.0 * lab.position(carriage).x + 10.0 * lab.position(bob).x) / 12.0;
        let begin = center(&lab);
        for _ in 0..(1.2 / dt).round() as usize {
            lab.step();
            assert_eq!(lab.position(carriage).y, 3.0);
        }
        assert_near(center(&lab) - begin, 10.0 / 12.0 * 1.2, 0.01, "both go on");
    }
}
