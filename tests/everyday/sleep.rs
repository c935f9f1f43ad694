//! Slow is not at rest: what goes on does not fall asleep, and what rests does.

use super::*;
use std::f32::consts::PI;

mod reasons;
mod wakes;

fn is_asleep(world: &World, body: Entity) -> bool {
    world.get::<Sleeping>(body).unwrap().asleep
}

fn floor(world: &mut World) -> Entity {
    world
        .spawn((RigidBody::Static, Collider::half_space(Vec3::Y)))
        .id()
}

/// Seconds after which a corbel of six bricks, whose centre is `beyond` the edge, has fallen, where bodies may sleep or not.
fn corbel(beyond: f32, rate: f32, turn: f32, from: Vec3, may_sleep: bool) -> Option<f32> {
    let mut app = app();
    let world = app.world_mut();
    world.resource_mut::<SleepSettings>().enabled = may_sleep;
    let turn = Quat::from_rotation_y(turn);
    let put = |x: f32, y: f32| {
        Transform::from_translation(from + turn * Vec3::new(x, y, 0.0)).with_rotation(turn)
    };
    world.spawn((
        RigidBody::Static,
        Collider::cuboid(10.0, 1.0, 4.0),
        put(5.0, -0.5),
    ));
    let xs = [0.8525f32, 0.6525, 0.4025, 0.0695, -0.4305, -1.3305];
    let shift = -beyond - xs.iter().sum::<f32>() / 6.0;
    let mut top = Entity::PLACEHOLDER;
    for (i, x) in (0..).zip(xs) {
        let brick = (
            RigidBody::Dynamic,
            Collider::cuboid(2.0, 0.5, 1.0),
            put(x + shift, 0.25 + 0.5 * i as f32),
        );
        top = world.spawn(brick).id();
    }
    for i in 0..(20.0 * rate) as usize {
        steps_of(world, 1, 1.0 / rate);
        if position(world, top).y < from.y + 1.0 {
            return Some(i as f32 / rate);
        }
    }
    None
}

#[test]
fn a_corbel_that_tips_slowly_falls_as_it_does_awake() {
    let places = [
        (0.0, Vec3::ZERO),
        (0.7, Vec3::ZERO),
        (0.3, Vec3::new(1000.0, 0.0, -1000.0)),
    ];
    for rate in [10.0, 60.0, 240.0] {
        for (turn, from) in places {
            for beyond in [0.0005, 0.0015, 0.006] {
                // Half a millimetre is a few roundings there.
                if from != Vec3::ZERO && beyond < 0.001 {
                    continue;
                }
                let [awake, asleep] =
                    [false, true].map(|sleep| corbel(beyond, rate, turn, from, sleep));
                println!(
                    "{rate} Hz, {turn} rad, {from}, {beyond} m: falls after {awake:?} s awake, {asleep:?}"
                );
                assert_eq!(awake.is_some(), asleep.is_some());
                if rate == 60.0 && from == Vec3::ZERO && beyond > 0.001 {
                    assert!(asleep.is_some());
                }
            }
        }
    }
}

/// Takes steps for ten seconds, and returns how much a body has moved in the last eight, m, and by how much it has turned, rad.
fn goes(world: &mut World, body: Entity, rate: f32) -> (f32, f32) {
    steps_of(world, (2.0 * rate) as usize, 1.0 / rate);
    let before = *world.get::<Transform>(body).unwrap();
    steps_of(world, (8.0 * rate) as usize, 1.0 / rate);
    let after = *world.get::<Transform>(body).unwrap();
    let turned = (after.rotation * before.rotation.inverse())
        .to_axis_angle()
        .1;
    (
        before.translation.distance(after.translation),
        turned.min(2.0 * PI - turned),
    )
}

const RATES: [f32; 3] = [10.0, 60.0, 240.0];

#[test]
fn a_motor_of_5_mm_per_second_goes_on() {
    for rate in RATES {
        let mut app = app();
        let world = app.world_mut();
        floor(world);
        let crate_ = world
            .spawn((RigidBody::Dynamic, cube(1.0), at(0.0, 0.5, 0.0)))
            .id();
        // It pushes another one along.
        let other = world
            .spawn((RigidBody::Dynamic, cube(1.0), at(1.0, 0.5, 0.0)))
            .id();
        let slider = PrismaticJoint::new(None, crate_).with_slider_axis(Vec3::X);
        world.spawn(slider.with_motor(JointMotor::velocity(0.005, 1e5)));
        let (way, _) = goes(world, other, rate);
        println!("{rate} Hz: {way} m");
        assert!((way - 0.04).abs() < 0.001);
    }
}

#[test]
fn a_clock_hand_of_a_hundredth_of_a_radian_per_second_turns() {
    for rate in RATES {
        let mut app = app();
        let world = app.world_mut();
        let hand = world
            .spawn((
                RigidBody::Dynamic,
                Collider::cuboid(1.0, 0.1, 0.1),
                at(0.5, 2.0, 0.0),
            ))
            .id();
        let hinge = RevoluteJoint::new(None, hand).with_anchor(Vec3::new(0.0, 2.0, 0.0));
        world.spawn(hinge.with_motor(JointMotor::velocity(0.01, 1e4)));
        let (_, turned) = goes(world, hand, rate);
        println!("{rate} Hz: {turned} rad");
        assert!((turned - 0.08).abs() < 0.002);
    }
}

#[test]
fn a_slow_conveyor_goes_on_and_what_is_stopped_on_it_sleeps() {
    for rate in RATES {
        let mut app = app();
        let world = app.world_mut();
        let belt = SurfaceVelocity(Vec3::X * 0.004);
        world.spawn((
            RigidBody::Static,
            Collider::cuboid(9.0, 1.0, 9.0),
            belt,
            at(0.0, -0.5, 0.0),
        ));
        let parcels = [0.0, 1.0].map(|y| {
            world
                .spawn((RigidBody::Dynamic, cube(1.0), at(0.0, 0.5 + y, 0.0)))
                .id()
        });
        world.spawn((RigidBody::Static, cube(1.0), at(1.0, 0.5, 3.0)));
        let stopped = world
            .spawn((RigidBody::Dynamic, cube(1.0), at(0.0, 0.5, 3.0)))
            .id();
        let (way, _) = goes(world, parcels[1], rate);
        println!("{rate} Hz: {way} m");
        assert!((way - 0.032).abs() < 0.001);
        assert!(is_asleep(world, stopped));
    }
}

#[test]
fn a_body_that_may_only_move_slowly_falls_on() {
    for rate in RATES {
        let mut app = app();
        let world = app.world_mut();
        let slow = world
            .spawn((
                RigidBody::Dynamic,
                cube(1.0),
                at(0.0, 5.0, 0.0),
                MaxLinearSpeed(0.005),
            ))
            .id();
        let damped = world
            .spawn((
                RigidBody::Dynamic,
                cube(1.0),
                at(5.0, 5.0, 0.0),
                Damping {
                    linear: 1e4,
                    angular: 1e4,
                },
            ))
            .id();
        let turning = (
            RigidBody::Dynamic,
            cube(1.0),
            at(9.0, 5.0, 0.0),
            GravityScale(0.0),
            Velocity {
                linear: Vec3::ZERO,
                angular: Vec3::Y * 0.01,
            },
        );
        let turning = world.spawn(turning).id();
        steps_of(world, (10.0 * rate) as usize, 1.0 / rate);
        let fallen = [slow, damped].map(|body| 5.0 - position(world, body).y);
        let turned = 2.0 * world.get::<Transform>(turning).unwrap().rotation.y;
        println!("{rate} Hz: {fallen:?} m, {turned} rad");
        assert!((fallen[0] - 0.05).abs() < 1e-3 && (fallen[1] - 0.00981).abs() < 6e-4);
        assert!((turned - 0.1).abs() < 1e-3);
    }
}

#[test]
fn slow_bodies_drift_on_in_zero_gravity() {
    for (rate, speed) in [(10.0, 0.005), (60.0, 0.005), (60.0, 0.0003), (240.0, 0.002)] {
        let mut app = app();
        let world = app.world_mut();
        world.resource_mut::<Gravity>().0 = Vec3::ZERO;
        // One that touches another and takes it along.
        let drift = Velocity::linear(Vec3::X * speed);
        let bodies = [0.0, 1.0].map(|x| {
            world
                .spawn((RigidBody::Dynamic, cube(1.0), at(x, 0.0, 0.0), drift))
                .id()
        });
        let (way, _) = goes(world, bodies[1], rate);
        println!("{rate} Hz, {speed} m/s: {way} m");
        assert!((way / (8.0 * speed) - 1.0).abs() < 0.02);
    }
}

#[test]
fn riders_of_a_slow_lift_go_up_with_it() {
    for rate in RATES {
        for by_transform in [false, true] {
            let mut app = app();
            let world = app.world_mut();
            let lift = world
                .spawn((
                    RigidBody::Kinematic,
                    Collider::cuboid(4.0, 0.2, 4.0),
                    at(0.0, -0.1, 0.0),
                ))
                .id();
            let riders = [0.5, 1.5].map(|y| {
                world
                    .spawn((RigidBody::Dynamic, cube(1.0), at(0.0, y, 0.0)))
                    .id()
            });
            steps_of(world, (2.0 * rate) as usize, 1.0 / rate);
            for _ in 0..(10.0 * rate) as usize {
                match by_transform {
                    true => world.get_mut::<Transform>(lift).unwrap().translation.y += 0.002 / rate,
                    false => {
                        *world.get_mut::<Velocity>(lift).unwrap() =
                            Velocity::linear(Vec3::Y * 0.002)
                    }
                }
                steps_of(world, 1, 1.0 / rate);
            }
            let up = position(world, riders[1]).y - 1.5;
            println!("{rate} Hz, by transform {by_transform}: {up} m");
            assert!((up - 0.02).abs() < 5e-4);
        }
    }
}

/// A ball rolls on and a crate slides on ice: dry friction does not hold them.
#[test]
fn bodies_that_nothing_stops_roll_and_slide_on() {
    for rate in RATES {
        let [awake, ways] = [false, true].map(|may_sleep| {
            let mut app = app();
            let world = app.world_mut();
            world.resource_mut::<SleepSettings>().enabled = may_sleep;
            floor(world);
            let drift = Velocity {
                linear: Vec3::X * 0.005,
                angular: Vec3::NEG_Z * 0.01,
            };
            let ball = (RigidBody::Dynamic, Collider::ball(0.5), at(0.0, 0.5, 0.0));
            let block = (RigidBody::Dynamic, cube(1.0), ice(), at(0.0, 0.5, 5.0));
            let ball = world.spawn((ball, drift)).id();
            let block = world.spawn((block, Velocity::linear(drift.linear))).id();
            steps_of(world, (10.0 * rate) as usize, 1.0 / rate);
            [ball, block].map(|body| position(world, body).x)
        });
        println!("{rate} Hz: {awake:?} m awake, {ways:?} m");
        assert!((ways[1] - 0.05).abs() < 1e-3);
        let off = (0..2).map(|i| (ways[i] - awake[i]).abs());
        assert!(off.fold(0.0, f32::max) < 1e-3);
    }
}

/// The time that bodies which are put down take to fall asleep.
#[test]
fn bodies_at_rest_sleep_after_half_a_second() {
    for rate in RATES {
        for from in [Vec3::ZERO, Vec3::new(1000.0, 0.0, 1000.0)] {
            let mut app = app();
            let world = app.world_mut();
            floor(world);
            let put = |x: f32, y: f32| {
                Transform::from_translation(from + Vec3::new(x, y, 0.0))
                    .with_rotation(Quat::from_rotation_y(0.4))
            };
            let mut bodies = vec![
                world
                    .spawn((RigidBody::Dynamic, Collider::ball(0.5), put(5.0, 0.5)))
                    .id(),
            ];
            for i in 0..5 {
                bodies.push(
                    world
                        .spawn((RigidBody::Dynamic, cube(1.0), put(0.0, 0.5 + i as f32)))
                        .id(),
                );
            }
            let mut times = vec![f32::NAN; bodies.len()];
            for i in 0..(3.0 * rate) as usize {
                steps_of(world, 1, 1.0 / rate);
                for (time, &body) in times.iter_mut().zip(&bodies) {
                    if time.is_nan() && is_asleep(world, body) {
                        *time = (i + 1) as f32 / rate;
                    }
                }
            }
            println!("{rate} Hz, {from}: asleep after {times:?} s");
            // Rounding makes stacks tremble there.
            let most = if from == Vec3::ZERO { 0.65 } else { 1.0 };
            assert!(times.iter().all(|&time| time <= most));
        }
    }
}
