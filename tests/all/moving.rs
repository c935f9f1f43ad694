//! Motion without contact: kinematic bodies, moved by `Velocity` and by `Transform`, and bodies without a shape.

use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::body::{RigidBody, Teleport, Velocity};
use drystone::collider::Collider;
use drystone::settings::{SleepSettings, SolverSettings};
use glam::{Quat, Vec3};
use support::*;

/// How a kinematic body is told to move.
#[derive(Clone, Copy, Debug, PartialEq)]
enum By {
    Velocity,
    Transform,
}

/// Moves a kinematic platform, whose top is at y = 0, along `way`, with the bodies on it. Returns the largest slip of a body on the
/// platform at the end, m.
fn carry(
    by: By,
    substeps: usize,
    seconds: f32,
    cargo: impl Fn(&mut Lab) -> Vec<Entity>,
    way: impl Fn(f32) -> (Vec3, Quat),
) -> f32 {
    let mut lab = Lab::new();
    lab.world.resource_mut::<SleepSettings>().enabled = false;
    lab.world.resource_mut::<SolverSettings>().outer_substeps = substeps;
    let platform = lab.spawn((
        RigidBody::Kinematic,
        Collider::cuboid(12.0, 1.0, 4.0),
        Transform::from_xyz(0.0, -0.5, 0.0),
    ));
    let cargo = cargo(&mut lab);
    let pose = |t: f32| {
        let (shift, turn) = way(t);
        Transform::from_translation(shift + turn * Vec3::NEG_Y * 0.5).with_rotation(turn)
    };
    let local = |lab: &Lab, body: Entity| {
        let platform = lab.pose(platform);
        platform.inverse_transform_point(lab.position(body))
    };
    lab.run(1.0);
    let start: Vec<Vec3> = cargo.iter().map(|&body| local(&lab, body)).collect();
    for i in 0..(seconds / lab.dt).round() as usize {
        let (t, next) = (i as f32 * lab.dt, (i + 1) as f32 * lab.dt);
        match by {
            By::Transform => *lab.world.get_mut::<Transform>(platform).unwrap() = pose(next),
            By::Velocity => {
                let (now, then) = (pose(t), pose(next));
                let linear = (then.translation - now.translation) / lab.dt;
                let turn = then.rotation * now.rotation.inverse();
                lab.set_velocity(platform, linear, turn.to_scaled_axis() / lab.dt);
            }
        }
        lab.step();
    }
    assert_eq!(lab.errors(), []);
    let slipped = |(&body, start): (&Entity, &Vec3)| (local(&lab, body) - *start).length();
    cargo.iter().zip(&start).map(slipped).fold(0.0, f32::max)
}

/// Goes up to a speed within two seconds, smoothly enough for friction 0.5, and on: the way after `t` s.
fn ramp(speed: f32, t: f32) -> f32 {
    if t < 2.0 {
        0.25 * speed * t * t
    } else {
        speed * (t - 1.0)
    }
}

fn boxes(lab: &mut Lab) -> Vec<Entity> {
    vec![lab.cube(Vec3::Y * 0.5)]
}

/// Four courses of six, close together.
fn load(lab: &mut Lab) -> Vec<Entity> {
    (0..24)
        .map(|i| {
            let at = Vec3::new((i % 6) as f32 - 2.5, 0.25 + 0.5 * (i / 6) as f32, 0.0);
            lab.body(Collider::cuboid(1.0, 0.5, 0.5), at)
        })
        .collect()
}

#[test]
fn a_box_stays_on_a_platform_that_is_moved_by_its_transform() {
    for direction in [Vec3::X, Vec3::Y, Vec3::NEG_Y, Vec3::new(0.6, 0.8, 0.0)] {
        for speed in [0.02, 0.05, 0.3, 1.0, 2.0] {
            for substeps in [1, 3] {
                let way = |t: f32| (direction * ramp(speed, t), Quat::IDENTITY);
                let [v, t] =
                    [By::Velocity, By::Transform].map(|by| carry(by, substeps, 3.0, boxes, way));
                println!(
                    "{direction} at {speed} m/s, {substeps}: by velocity {v}, by transform {t} m"
                );
                assert!(
                    t < 1e-3,
                    "{direction} at {speed} m/s: slipped {t} m, by velocity {v} m"
                );
            }
        }
    }
}

#[test]
fn a_lorry_takes_its_boxes_along() {
    let way = |t: f32| (Vec3::X * ramp(2.0, t), Quat::IDENTITY);
    let [v, t] = [By::Velocity, By::Transform].map(|by| carry(by, 1, 4.0, load, way));
    println!("by velocity {v}, by transform {t} m");
    assert!(t < v + 1e-3, "slipped {t} m, by velocity {v} m");
}

#[test]
fn a_lift_does_not_throw_its_box() {
    // Starts at once, and stops within half a second.
    let way = |t: f32| {
        let up = if t < 2.0 {
            2.0 * t
        } else {
            4.5 - 2.0 * (2.5 - t.min(2.5)).powi(2)
        };
        (Vec3::Y * up, Quat::IDENTITY)
    };
    let [v, t] = [By::Velocity, By::Transform].map(|by| carry(by, 1, 4.0, boxes, way));
    println!("by velocity {v}, by transform {t} m");
    assert!((t - v).abs() < 1e-3, "{t} m, by velocity {v} m");
}

#[test]
fn a_table_tips_by_its_transform_as_by_its_velocity() {
    let tip = |t: f32| {
        let angle = 25f32.to_radians() * (t / 5.0).min(1.0);
        (Vec3::ZERO, Quat::from_rotation_z(-angle))
    };
    let slab = |lab: &mut Lab| {
        (0..3)
            .map(|i| {
                lab.body(
                    Collider::cuboid(1.0, 0.25, 1.0),
                    Vec3::new(2.0 * i as f32 - 2.0, 0.125, 0.0),
                )
            })
            .collect()
    };
    let [v, t] = [By::Velocity, By::Transform].map(|by| carry(by, 1, 8.0, slab, tip));
    println!("by velocity {v}, by transform {t} m");
    assert!((t - v).abs() < 1e-3, "{t} m, by velocity {v} m");
}

#[test]
fn bodies_no_longer_moved_by_their_transform_stand_still() {
    let mut lab = Lab::new();
    let platform = lab.spawn((
        RigidBody::Kinematic,
        Collider::cuboid(2.0, 1.0, 2.0),
        Transform::IDENTITY,
    ));
    lab.step();
    for i in 1..=10 {
        lab.world
            .get_mut::<Transform>(platform)
            .unwrap()
            .translation
            .x = 0.1 * i as f32;
        lab.step();
        assert!((lab.position(platform).x - 0.1 * i as f32).abs() < 1e-6);
        let speed = lab.velocity(platform).linear.x;
        assert!(
            (speed - 6.0).abs() < 1e-3,
            "its velocity is what its pose did: {speed}"
        );
    }
    lab.run(1.0);
    assert_eq!(lab.position(platform), Vec3::X);
    assert_eq!(lab.velocity(platform), Velocity::default());
    // And by its velocity as ever.
    lab.set_velocity(platform, Vec3::Y, Vec3::ZERO);
    lab.run(1.0);
    assert!((lab.position(platform) - Vec3::new(1.0, 1.0, 0.0)).length() < 1e-3);
}

/// Put elsewhere, it was not on the way: nothing is carried along, and nothing is hit.
#[test]
fn a_teleport_carries_nothing() {
    let mut lab = Lab::new();
    let platform = lab.spawn((
        RigidBody::Kinematic,
        Collider::cuboid(4.0, 1.0, 4.0),
        Transform::from_xyz(0.0, -0.5, 0.0),
    ));
    let cube = lab.cube(Vec3::Y * 0.5);
    lab.run(1.0);
    let there = Transform::from_xyz(1.0, -0.5, 0.0);
    lab.world.entity_mut(platform).insert((there, Teleport));
    lab.step();
    assert_eq!(lab.position(platform), there.translation);
    assert_eq!(lab.velocity(platform), Velocity::default());
    assert!(lab.world.get::<Teleport>(platform).is_none(), "used up");
    lab.run(1.0);
    assert!((lab.position(cube) - Vec3::Y * 0.5).length() < 1e-3);
    // Farther than a body may go in a step it cannot be but put.
    let far = Transform::from_xyz(900.0, -0.5, 0.0);
    lab.world.entity_mut(platform).insert(far);
    lab.step();
    assert_eq!(lab.position(platform), far.translation);
    assert_eq!(lab.velocity(platform), Velocity::default());
    lab.run(0.5);
    assert!(lab.position(cube).x.abs() < 1e-3 && lab.position(cube).y < 0.0);
}

// 6: bodies without a shape

#[test]
fn a_body_without_a_collider_flies_freely() {
    let mut lab = Lab::new();
    lab.ground();
    let body = lab.spawn((RigidBody::Dynamic, Transform::from_xyz(0.0, 10.0, 0.0)));
    lab.set_velocity(body, Vec3::X * 3.0, Vec3::Y);
    lab.run(1.0);
    let at = lab.position(body);
    assert!(
        (at.x - 3.0).abs() < 0.01 && (at.y - (10.0 - 0.5 * G)).abs() < 0.1,
        "{at}"
    );
    assert!(
        lab.pose(body)
            .rotation
            .angle_between(Quat::from_rotation_y(1.0))
            < 0.01
    );
    assert_eq!(lab.errors(), []);
    lab.run(2.0);
    assert!(lab.position(body).y < -10.0, "nothing holds it");
}
