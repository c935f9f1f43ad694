//! Sensors detect bodies that arrive asleep or inactive.

use super::*;
use bevy_ecs::message::Messages;
use drystone::streaming::{put_back, spawn_asleep, take_out};

const COUNT: usize = 10;

/// A zone of 20 m about the origin, above a floor. `moves`: it is kinematic and turns.
fn site(moves: bool) -> (App, Entity) {
    let mut app = app();
    let world = app.world_mut();
    let floor = (RigidBody::Static, Collider::half_space(Vec3::Y));
    let floor = world.spawn(floor).id();
    let zone = match moves {
        false => world.spawn((RigidBody::Static, Sensor, cube(20.0))).id(),
        true => {
            let spin = Velocity {
                angular: Vec3::Y * 0.1,
                ..Default::default()
            };
            let zone = (RigidBody::Kinematic, Sensor, Collider::cylinder(10.0, 20.0));
            let spared = CollisionExceptions([floor].into_iter().collect());
            world.spawn((zone, spin, spared)).id()
        }
    };
    (app, zone)
}

fn row() -> impl Iterator<Item = (RigidBody, Collider, Transform)> {
    (0..COUNT).map(|i| (RigidBody::Dynamic, cube(0.5), at(i as f32 - 5.0, 0.25, 0.0)))
}

fn inside(world: &World, zone: Entity) -> usize {
    world.get::<SensorOverlaps>(zone).unwrap().bodies().count()
}

/// Takes steps, and returns how many bodies came in and how many left.
fn events(world: &mut World, count: usize) -> [usize; 2] {
    let mut sum = [0; 2];
    for _ in 0..count {
        steps(world, 1);
        sum[0] += world
            .resource_mut::<Messages<SensorEntered>>()
            .drain()
            .count();
        sum[1] += world
            .resource_mut::<Messages<SensorExited>>()
            .drain()
            .count();
    }
    sum
}

#[test]
fn bodies_that_are_put_back_asleep_are_detected_once() {
    for moves in [false, true] {
        for (out, wakes) in [(10, false), (10, true), (0, false), (0, true)] {
            let (mut app, zone) = site(moves);
            let world = app.world_mut();
            let bodies: Vec<Entity> = row().map(|body| world.spawn(body).id()).collect();
            assert_eq!(events(world, 180), [COUNT, 0]);
            let region = take_out(world, bodies.iter().copied()).unwrap();
            let left = if out > 0 { COUNT } else { 0 };
            assert_eq!(events(world, out), [0, left]);
            assert!(put_back(world, region).is_empty());
            assert_eq!(
                events(world, 5),
                [left, 0],
                "moves {moves}, out for {out} steps"
            );
            assert_eq!(inside(world, zone), COUNT);
            if wakes {
                for &body in &bodies {
                    world.get_mut::<Sleeping>(body).unwrap().wake();
                }
            }
            assert_eq!(events(world, 60), [0, 0]);
            world.despawn(bodies[0]);
            assert_eq!(events(world, 2), [0, 1]);
            world.get_mut::<Transform>(bodies[1]).unwrap().translation.x += 30.0;
            assert_eq!(events(world, 2), [0, 1]);
        }
    }
}

/// They get other slots, because others have taken theirs meanwhile.
#[test]
fn bodies_that_are_put_back_into_other_slots_are_detected_once() {
    let (mut app, zone) = site(false);
    let world = app.world_mut();
    let bodies: Vec<Entity> = row().map(|body| world.spawn(body).id()).collect();
    steps(world, 180);
    let region = take_out(world, bodies[..5].iter().copied()).unwrap();
    let other = take_out(world, bodies[5..].iter().copied()).unwrap();
    put_back(world, other);
    put_back(world, region);
    assert_eq!(events(world, 5), [0, 0]);
    assert_eq!(inside(world, zone), COUNT);
}

#[test]
fn bodies_that_are_spawned_asleep_are_detected_once() {
    for moves in [false, true] {
        let (mut app, zone) = site(moves);
        let world = app.world_mut();
        steps(world, 5);
        let bodies = spawn_asleep(world, row());
        assert_eq!(events(world, 5), [COUNT, 0]);
        assert_eq!(inside(world, zone), COUNT);
        for &body in &bodies {
            world.get_mut::<Sleeping>(body).unwrap().wake();
        }
        assert_eq!(events(world, 60), [0, 0]);
        world.despawn(bodies[0]);
        assert_eq!(events(world, 2), [0, 1]);
    }
}

/// The zone is a part of a body that comes and goes, and static bodies arrive beside it.
#[test]
fn a_dynamic_body_with_a_foot_detects_static_bodies_that_are_put_back() {
    let mut app = app();
    let world = app.world_mut();
    world.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
    let block = (RigidBody::Static, cube(1.0), at(1.5, 0.5, 0.0));
    let block = world.spawn(block).id();
    let body = (RigidBody::Dynamic, cube(1.0), at(0.0, 0.5, 0.0));
    let body = world.spawn(body).id();
    let arm = (Sensor, cube(1.0), at(1.0, 0.1, 0.0), ChildOf(body));
    let arm = world.spawn(arm).id();
    steps(world, 180);
    assert_eq!(inside(world, arm), 1);
    for which in [block, body] {
        let region = take_out(world, [which]).unwrap();
        steps(world, 5);
        put_back(world, region);
        steps(world, 5);
        assert_eq!(inside(world, arm), 1);
    }
}

#[test]
fn loads_and_lists_of_who_touches_hold_for_bodies_that_arrive_asleep() {
    let mut app = app();
    let world = app.world_mut();
    world.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
    let stack = |x: f32| {
        (0..3).map(move |i| {
            let place = at(x, 0.5 + i as f32, 0.0);
            let told = (Load::default(), CollidingEntities::default());
            (RigidBody::Dynamic, cube(1.0), place, told)
        })
    };
    let bodies: Vec<Entity> = stack(0.0).map(|body| world.spawn(body).id()).collect();
    let others = spawn_asleep(world, stack(5.0));
    steps(world, 180);
    let told = |world: &World, body: Entity| {
        let touching = world.get::<CollidingEntities>(body).unwrap().len();
        (world.get::<Load>(body).unwrap().supported_weight, touching)
    };
    let before: Vec<_> = bodies.iter().map(|&body| told(world, body)).collect();
    for (&body, before) in others.iter().zip(&before) {
        let (weight, touching) = told(world, body);
        assert!((weight - before.0).abs() < 1e-3 * before.0.max(1.0));
        assert_eq!(touching, before.1);
    }
    let region = take_out(world, bodies.iter().copied()).unwrap();
    steps(world, 5);
    put_back(world, region);
    steps(world, 5);
    let after: Vec<_> = bodies.iter().map(|&body| told(world, body)).collect();
    assert_eq!(before, after);
}

/// A thin gate that stands or comes towards bodies, alone or as a part of a body.
fn gate(world: &mut World, speed: f32, is_child: bool) {
    let kind = match speed == 0.0 {
        true => RigidBody::Static,
        false => RigidBody::Kinematic,
    };
    let moves = Velocity::linear(Vec3::X * speed);
    let gate = (Collider::cuboid(0.02, 2.0, 2.0), Sensor);
    if is_child {
        let post = (kind, cube(0.1), at(0.0, 5.0, 0.0), moves);
        let post = world.spawn(post).id();
        world.spawn((gate, ChildOf(post), at(0.0, -5.0, 0.0)));
    } else {
        world.spawn((gate, kind, at(0.0, 0.0, 0.0), moves));
    }
}

/// Bodies fly through the gate in all phases of a step, or past it.
#[test]
fn bodies_that_fly_through_a_gate_are_detected_once() {
    let two = [Vec3::ZERO, Vec3::X * 0.2].map(|at| (at, Quat::IDENTITY, cube(0.1)));
    let bodies = [
        Collider::ball(0.05),
        cube(0.2),
        Collider::capsule(0.05, 0.2),
        Collider::compound(two.into()).unwrap(),
    ];
    let speeds = [
        (20.0, 0.0),
        (60.0, 0.0),
        (300.0, 0.0),
        (0.0, -150.0),
        (40.0, -40.0),
    ];
    for (speed, gate_speed) in speeds {
        for k in 0..24 {
            for (aside, count) in [(0.4, 1), (1.5, 0)] {
                for body in &bodies {
                    let mut app = app();
                    let world = app.world_mut();
                    world.resource_mut::<Gravity>().0 = Vec3::ZERO;
                    gate(world, gate_speed, k % 2 == 0);
                    let far = 10.0 + 0.15 * k as f32;
                    let moves = Velocity::linear(Vec3::X * speed);
                    let start = at(-far, aside, 0.0);
                    world.spawn((RigidBody::Dynamic, body.clone(), moves, start));
                    let time = 2.0 * far / (speed - gate_speed);
                    let found = events(world, (time / DT) as usize + 3);
                    assert_eq!(
                        found, [count; 2],
                        "{speed}, {gate_speed} m/s, {aside} m, {k}"
                    );
                }
            }
        }
    }
}
