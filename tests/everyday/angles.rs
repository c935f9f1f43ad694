//! Angles of joints count turns.

use super::*;
use drystone::recording::{Recorder, RecorderSettings, Recording, Replay};
use drystone::snapshot::Snapshot;
use drystone::solver::Pgs;
use std::f32::consts::{PI, TAU};

/// Where and how a joint is set up.
#[derive(Clone, Copy, Debug)]
struct Variant {
    hz: f32,
    /// Where the anchor is, m.
    origin: Vec3,
    /// How everything is turned.
    turn: Quat,
    /// The arm is body 1, and not body 2.
    swapped: bool,
    /// Body 1 is the world, and not a heavy body that is free.
    fixed: bool,
}

const PLAIN: Variant = Variant {
    hz: 60.0,
    origin: Vec3::ZERO,
    turn: Quat::IDENTITY,
    swapped: false,
    fixed: true,
};

fn variants() -> Vec<Variant> {
    let odd = Quat::from_scaled_axis(Vec3::new(0.7, -1.9, 0.4));
    let far = Vec3::new(800.0, -300.0, 520.0);
    vec![
        PLAIN,
        Variant {
            hz: 10.0,
            swapped: true,
            ..PLAIN
        },
        Variant {
            hz: 240.0,
            turn: odd,
            ..PLAIN
        },
        Variant {
            origin: far,
            turn: odd,
            swapped: true,
            ..PLAIN
        },
        Variant {
            hz: 10.0,
            turn: odd,
            fixed: false,
            ..PLAIN
        },
    ]
}

/// An arm of 2 kg and 1 m that turns about the z axis of its frame at one end, without gravity.
struct Arm {
    app: App,
    arm: Entity,
    other: Option<Entity>,
    joint: Entity,
    variant: Variant,
}

impl Arm {
    /// `joint` makes the joint for body 1 and body 2 with the anchor and the basis.
    fn new<J: Component>(
        variant: Variant,
        joint: impl Fn(Option<Entity>, Option<Entity>, Vec3, Quat) -> J,
    ) -> Self {
        Self::at_angle(variant, 0.0, joint)
    }

    /// Begins at this angle to body 1; the joint's frames agree where it is zero.
    fn at_angle<J: Component>(
        variant: Variant,
        angle: f32,
        joint: impl Fn(Option<Entity>, Option<Entity>, Vec3, Quat) -> J,
    ) -> Self {
        let mut app = app();
        let world = app.world_mut();
        world.resource_mut::<Gravity>().0 = Vec3::ZERO;
        let Variant {
            origin,
            turn,
            swapped,
            fixed,
            ..
        } = variant;
        let spin = turn * Quat::from_rotation_z(angle);
        let pose = Transform::from_translation(origin + spin * (0.5 * Vec3::X)).with_rotation(spin);
        let arm = world
            .spawn((
                RigidBody::Dynamic,
                Collider::cuboid(1.0, 0.1, 0.1),
                Mass(2.0),
                pose,
            ))
            .id();
        let other = (!fixed).then(|| {
            let pose = Transform::from_translation(origin).with_rotation(turn);
            world
                .spawn((RigidBody::Dynamic, cube(1.0), Mass(1e4), pose))
                .id()
        });
        let ends = if swapped {
            [Some(arm), other]
        } else {
            [other, Some(arm)]
        };
        let joint = world.spawn(joint(ends[0], ends[1], origin, turn)).id();
        Self {
            app,
            arm,
            other,
            joint,
            variant,
        }
    }

    fn world(&mut self) -> &mut World {
        self.app.world_mut()
    }

    /// Pushes about the axis of the joint, N·m.
    fn push(&mut self, torque: f32) {
        let torque = self.sign() * torque * (self.variant.turn * Vec3::Z);
        let arm = self.arm;
        self.world().entity_mut(arm).insert(ExternalForce {
            torque,
            ..Default::default()
        });
    }

    /// The angle of a joint grows as its second body turns.
    fn sign(&self) -> f32 {
        if self.variant.swapped { -1.0 } else { 1.0 }
    }

    fn run(&mut self, seconds: f32) {
        let hz = self.variant.hz;
        steps_of(self.world(), (seconds * hz) as usize, 1.0 / hz);
    }

    /// The angle that drystone tells, rad.
    fn told(&mut self) -> f32 {
        let joint = self.joint;
        self.world()
            .get::<JointForces>(joint)
            .unwrap()
            .angles()
            .unwrap()
            .dot(Vec3::ONE)
    }

    /// The angle but for whole turns, from where the bodies point.
    fn seen(&mut self) -> f32 {
        let (arm, other, turn, sign) = (self.arm, self.other, self.variant.turn, self.sign());
        let rotation = |body: Entity| self.app.world().get::<Transform>(body).unwrap().rotation;
        let along = other.map_or(turn, rotation).inverse() * (rotation(arm) * Vec3::X);
        sign * along.y.atan2(along.x)
    }

    /// Between the bodies, rad/s.
    fn spin(&mut self) -> f32 {
        let spin = |body: Entity| velocity(self.app.world(), body).angular;
        (spin(self.arm) - self.other.map_or(Vec3::ZERO, spin)).length()
    }

    /// Checks that it is at rest at an angle.
    fn rests_at(&mut self, angle: f32, what: &str) {
        let (told, seen, spin) = (self.told(), self.seen(), self.spin());
        let off = (seen - told + PI).rem_euclid(TAU) - PI;
        assert!(
            off.abs() < 2e-3,
            "{what}, {:?}: tells {told}, and is at {seen}",
            self.variant
        );
        assert!(
            (told - angle).abs() < 0.01 && spin < 0.01,
            "{what}, {:?}: {told} instead of {angle}, {spin} rad/s",
            self.variant
        );
    }
}

fn hinge(
    change: impl Fn(RevoluteJoint) -> RevoluteJoint,
) -> impl Fn(Option<Entity>, Option<Entity>, Vec3, Quat) -> RevoluteJoint {
    move |one, other, anchor, basis| {
        change(
            RevoluteJoint::new(one, other)
                .with_anchor(anchor)
                .with_local_basis1(basis)
                .with_local_basis2(basis),
        )
    }
}

/// A hinge whose frames are those of the world at angle 0. Body 1 or 2 is the arm, which is turned by `basis` at first.
fn hinge_at_start(
    change: impl Fn(RevoluteJoint) -> RevoluteJoint,
) -> impl Fn(Option<Entity>, Option<Entity>, Vec3, Quat) -> RevoluteJoint {
    move |one, other, anchor, basis| {
        change(
            RevoluteJoint::new(one, other)
                .with_anchor(anchor)
                .with_basis(basis),
        )
    }
}

#[test]
fn a_hinge_stays_at_its_limit() {
    for variant in variants() {
        for limit in [0.5, PI, 1.5 * PI, 7.0, 20.0 * PI] {
            for sign in [-1.0, 1.0] {
                let [min, max] = if sign > 0.0 {
                    [0.0, limit]
                } else {
                    [-limit, 0.0]
                };
                let mut arm = Arm::new(
                    variant,
                    hinge_at_start(|joint| joint.with_angle_limits(min, max)),
                );
                arm.push(sign * 20.0);
                arm.run(6.0);
                arm.rests_at(sign * limit, "limit");
            }
        }
    }
}

#[test]
fn a_fast_hinge_stays_within_its_limits() {
    for variant in variants() {
        let mut arm = Arm::new(
            variant,
            hinge_at_start(|joint| joint.with_angle_limits(-PI, PI)),
        );
        let spin = variant.turn * Vec3::Z * 25.0;
        let id = arm.arm;
        let velocity = Velocity {
            linear: spin.cross(variant.turn * (0.5 * Vec3::X)),
            angular: spin,
        };
        arm.world().entity_mut(id).insert(velocity);
        for _ in 0..(2.0 * variant.hz) as usize {
            arm.run(1.5 / variant.hz);
            let told = arm.told();
            assert!(told.abs() < PI + 0.2, "{variant:?}: {told}");
        }
    }
}

#[test]
fn a_servo_reaches_any_angle() {
    for variant in variants() {
        for degrees in [
            90.0f32, 135.0, -180.0, 200.0, -300.0, 360.0, 1000.0, -3600.0,
        ] {
            let target = degrees.to_radians();
            let mut arm = Arm::new(
                variant,
                hinge_at_start(|joint| joint.with_motor(JointMotor::servo(target, 1e3))),
            );
            arm.run(6.0);
            arm.rests_at(target, "servo");
        }
    }
}

#[test]
fn a_spring_pulls_to_any_angle() {
    for variant in variants() {
        for degrees in [135.0f32, -180.0, 270.0, 3600.0] {
            let target = degrees.to_radians();
            let mut arm = Arm::new(
                variant,
                hinge_at_start(|joint| joint.with_motor(JointMotor::position(target, 20.0, 5.0))),
            );
            arm.run(8.0);
            arm.rests_at(target, "spring");
        }
    }
}

#[test]
fn a_winch_winds_ten_turns_and_back() {
    for hz in [10.0, 60.0, 240.0] {
        let winch = |speed| JointMotor::velocity(speed, 100.0);
        let mut arm = Arm::new(
            Variant { hz, ..PLAIN },
            hinge_at_start(|joint| {
                joint
                    .with_angle_limits(0.0, 10.0 * TAU)
                    .with_motor(winch(15.0))
            }),
        );
        arm.run(6.0);
        arm.rests_at(10.0 * TAU, "wound");
        let joint = arm.joint;
        arm.world().get_mut::<RevoluteJoint>(joint).unwrap().motor = Some(winch(-15.0));
        arm.run(6.0);
        arm.rests_at(0.0, "unwound");
    }
}

#[test]
fn a_wheel_that_turns_fast_counts_its_turns() {
    for hz in [10.0, 60.0] {
        for settings in [
            SolverSettings::default(),
            SolverSettings::new(Pgs::default()),
        ] {
            let mut arm = Arm::new(
                Variant { hz, ..PLAIN },
                |one, other: Option<Entity>, _, _| {
                    // About the middle of the body.
                    RevoluteJoint::new(one, other).with_hinge_axis(Vec3::X)
                },
            );
            arm.world().insert_resource(settings);
            let id = arm.arm;
            arm.world().entity_mut(id).insert(Velocity {
                linear: Vec3::ZERO,
                angular: Vec3::X * 70.0,
            });
            arm.run(2.0);
            let told = arm.told();
            assert!((told - 140.0).abs() < 0.5, "{hz} Hz: {told}");
        }
    }
}

#[test]
fn a_twist_counts_turns() {
    for variant in variants() {
        for cone in [false, true] {
            for limit in [3.0, 2.5 * TAU] {
                let mut arm = Arm::new(variant, |one, other, anchor, basis| {
                    let joint = SphericalJoint::new(one, other)
                        .with_anchor(anchor)
                        .with_basis(basis)
                        .with_twist_axis(Vec3::Z);
                    let joint = joint.with_twist_limits(-limit, limit);
                    // Without a bound of the swing, no torque about a fixed axis is in a stable balance with the limit.
                    if cone {
                        joint.with_swing_cone(0.3)
                    } else {
                        joint.with_swing_limits(-0.1, 0.1)
                    }
                });
                arm.push(20.0);
                arm.run(6.0);
                let told = arm.told();
                assert!(
                    (limit - 0.2..limit + 0.02).contains(&told),
                    "{variant:?}, {cone}: {told} instead of {limit}"
                );
            }
        }
    }
}

#[test]
fn axes_of_a_generic_joint_count_turns() {
    for variant in variants() {
        for degrees in [135.0f32, -270.0, 1234.0] {
            let target = degrees.to_radians();
            let mut arm = Arm::new(variant, |one, other, anchor, basis| {
                let joint = GenericJoint::new(one, other)
                    .with_anchor(anchor)
                    .with_basis(basis)
                    .with_locked_axes(JointAxes::LINEAR);
                joint
                    .with_motor(
                        JointAxes::ANG_X | JointAxes::ANG_Y,
                        JointMotor::position(0.0, 200.0, 20.0),
                    )
                    .with_motor(JointAxes::ANG_Z, JointMotor::position(target, 20.0, 5.0))
            });
            arm.run(8.0);
            arm.rests_at(target, "generic");
        }
    }
}

/// A rotation vector goes on beyond a half turn, where several axes have limits.
#[test]
fn limits_about_several_axes_hold_beyond_a_half_turn() {
    for variant in variants() {
        let mut arm = Arm::new(variant, |one, other, anchor, basis| {
            let joint = GenericJoint::new(one, other)
                .with_anchor(anchor)
                .with_basis(basis)
                .with_locked_axes(JointAxes::LINEAR);
            joint
                .with_limits(JointAxes::ANG_X | JointAxes::ANG_Y, -0.1, 0.1)
                .with_limits(JointAxes::ANG_Z, -1.5, 1.5)
        });
        arm.push(30.0);
        arm.run(6.0);
        let seen = arm.seen();
        assert!((seen - 1.5).abs() < 0.02, "{variant:?}: {seen}");
        let mut arm = Arm::new(variant, |one, other, anchor, basis| {
            let joint = GenericJoint::new(one, other)
                .with_anchor(anchor)
                .with_basis(basis)
                .with_locked_axes(JointAxes::LINEAR);
            let stiff = JointMotor::position(0.0, 200.0, 20.0);
            joint
                .with_motor(JointAxes::ANG_X | JointAxes::ANG_Y, stiff)
                .with_limits(JointAxes::ANGULAR, -3.1, 3.1)
        });
        arm.push(30.0);
        arm.run(6.0);
        let seen = arm.seen();
        assert!((seen - 3.1).abs() < 0.02, "{variant:?}: {seen}");
    }
}

/// A drawbridge that is spawned where it lies over begins within its range, and one that is spawned a little beyond its limit does not
/// begin a turn further on.
#[test]
fn the_first_angle_is_one_in_the_limits() {
    for variant in variants() {
        let joint = |min: f32, max: f32| {
            let fixed = variant.fixed;
            hinge(move |joint| {
                let joint = joint.with_angle_limits(min, max);
                // Frames of the world agree with its axes, those of a body with the axes of the body.
                match (fixed, joint.body1.is_none()) {
                    (false, _) => joint
                        .with_local_basis1(Quat::IDENTITY)
                        .with_local_basis2(Quat::IDENTITY),
                    (true, true) => joint.with_local_basis2(Quat::IDENTITY),
                    (true, false) => joint.with_local_basis1(Quat::IDENTITY),
                }
            })
        };
        let start = 200f32.to_radians() * if variant.swapped { -1.0 } else { 1.0 };
        let mut arm = Arm::at_angle(variant, start, joint(0.5 * PI, 1.5 * PI));
        arm.run(0.5);
        arm.rests_at(200f32.to_radians(), "over");
        let start = -0.01 * if variant.swapped { -1.0 } else { 1.0 };
        let mut arm = Arm::at_angle(variant, start, joint(0.0, 3.0 * TAU));
        arm.run(0.5);
        let told = arm.told();
        assert!(told.abs() < 0.5, "{variant:?}: {told}");
    }
}

/// A servo of five turns on its way.
fn on_its_way() -> Arm {
    let mut arm = Arm::new(
        PLAIN,
        hinge_at_start(|joint| joint.with_motor(JointMotor::position(5.0 * TAU, 4.0, 3.0))),
    );
    arm.run(1.5);
    assert!(arm.told() > TAU);
    arm
}

fn bits(world: &World, id: Entity) -> [u32; 7] {
    let pose = world.get::<Transform>(id).unwrap();
    let [x, y, z] = pose.translation.to_array();
    let [a, b, c, d] = pose.rotation.to_array();
    [x, y, z, a, b, c, d].map(f32::to_bits)
}

#[test]
fn turns_are_kept_by_snapshots() {
    let mut arm = on_its_way();
    let id = arm.arm;
    let snapshot = Snapshot::take(arm.world());
    let bytes = snapshot.to_bytes().unwrap();
    arm.run(2.0);
    let wanted = bits(arm.world(), id);
    snapshot.restore(arm.world()).unwrap();
    arm.run(2.0);
    assert_eq!(bits(arm.world(), id), wanted);
    let mut other = app();
    let world = other.world_mut();
    let ids = Snapshot::from_bytes(&bytes)
        .unwrap()
        .restore(world)
        .unwrap();
    steps(world, 120);
    assert_eq!(bits(world, ids[&id]), wanted);
}

#[test]
fn turns_are_kept_by_recordings() {
    let mut arm = on_its_way();
    let joint = arm.joint;
    Recorder::start(arm.world(), RecorderSettings::default()).unwrap();
    arm.run(1.0);
    // A change from outside, many turns from where it began.
    let motor = JointMotor::position(-2.0 * TAU, 40.0, 9.0);
    arm.world().get_mut::<RevoluteJoint>(joint).unwrap().motor = Some(motor);
    arm.run(6.0);
    arm.rests_at(-2.0 * TAU, "recorded");
    let bytes = Recorder::stop(arm.world()).unwrap();
    let recording = Recording::from_bytes(&bytes).unwrap();
    let mut other = app();
    let mut replay = Replay::start(&recording, other.world_mut()).unwrap();
    while replay.step(other.world_mut()).unwrap() {}
    assert_eq!(replay.divergence(), None);
    let there = replay.entity(joint).unwrap();
    let told = other.world().get::<JointForces>(there).unwrap().angle();
    assert_eq!(told, Some(arm.told()));
}

#[test]
fn turns_are_kept_while_the_joint_or_its_body_is_out() {
    for out in 0..2 {
        let mut arm = on_its_way();
        let (id, joint) = (arm.arm, arm.joint);
        let before = arm.told();
        let world = arm.world();
        world.entity_mut(id).insert(Velocity::default());
        match out {
            0 => {
                world.entity_mut(joint).insert(JointDisabled);
                steps(world, 5);
                world.entity_mut(joint).remove::<JointDisabled>();
            }
            _ => {
                world.entity_mut(id).insert(RigidBodyDisabled);
                steps(world, 5);
                world.entity_mut(id).remove::<RigidBodyDisabled>();
            }
        }
        arm.run(1.0 / 60.0);
        let after = arm.told();
        assert!((after - before).abs() < 1.0, "{out}: {before} {after}");
        arm.run(12.0);
        arm.rests_at(5.0 * TAU, "after a pause");
    }
}
