//! What is round or rough, in heaps: it comes to rest, and sleeps.

mod support;

use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::body::RigidBody;
use drystone::collider::Collider;
use drystone::metrics;
use drystone::sleeping::Sleeping;
use glam::{Quat, Vec3};
use support::*;

/// A bin of five static cuboids, so many metres wide, with its floor at y = 0.
fn bin(lab: &mut Lab, wide: f32) {
    let high = 20.0;
    let wall = |at: Vec3, size: Vec3| {
        (
            RigidBody::Static,
            Collider::cuboid(size.x, size.y, size.z),
            Transform::from_translation(at),
        )
    };
    lab.spawn(wall(
        Vec3::NEG_Y * 0.5,
        Vec3::new(wide + 2.0, 1.0, wide + 2.0),
    ));
    for side in [-1.0, 1.0] {
        let off = side * 0.5 * (wide + 1.0);
        lab.spawn(wall(
            Vec3::new(off, 0.5 * high, 0.0),
            Vec3::new(1.0, high, wide + 2.0),
        ));
        lab.spawn(wall(
            Vec3::new(0.0, 0.5 * high, off),
            Vec3::new(wide, high, 1.0),
        ));
    }
}

/// Three hundred bodies, dropped in layers.
fn pile(
    lab: &mut Lab,
    n: usize,
    collider: impl Fn(usize, &mut fastrand::Rng) -> Collider,
) -> Vec<Entity> {
    bin(lab, 3.0);
    let mut rng = fastrand::Rng::with_seed(11);
    (0..n)
        .map(|i| {
            let (x, z, y) = (i % 5, i / 5 % 5, i / 25);
            let mut one = || rng.f32() - 0.5;
            let shift = 0.1 * Vec3::new(one(), one(), one());
            let turn = Quat::from_scaled_axis(3.0 * Vec3::new(one(), one(), one()));
            let at = 0.58 * Vec3::new(x as f32 - 2.0, y as f32 + 0.8, z as f32 - 2.0) + shift;
            let shape = collider(i, &mut rng);
            lab.spawn((
                RigidBody::Dynamic,
                shape,
                Transform::from_translation(at).with_rotation(turn),
            ))
        })
        .collect()
}

/// When all sleep, s; the fastest then or in the end, m/s; and the deepest overlap, m.
fn settle(lab: &mut Lab, bodies: &[Entity], seconds: f32) -> (Option<f32>, f32, f32) {
    let mut slept = None;
    for step in 0..(seconds / lab.dt) as usize {
        lab.step();
        let asleep = |&b: &Entity| lab.world.get::<Sleeping>(b).unwrap().asleep;
        if bodies.iter().all(asleep) {
            slept = Some(step as f32 * lab.dt);
            break;
        }
    }
    let speed = |&b: &Entity| lab.velocity(b).linear.length();
    let fastest = bodies.iter().map(speed).fold(0.0, f32::max);
    (
        slept,
        fastest,
        metrics::gaps(&mut lab.world).penetration_max,
    )
}

#[track_caller]
fn sleeps(what: &str, collider: impl Fn(usize, &mut fastrand::Rng) -> Collider) {
    let mut lab = Lab::new();
    let bodies = pile(&mut lab, 300, collider);
    let (slept, fastest, overlap) = settle(&mut lab, &bodies, 20.0);
    println!("{what}: asleep at {slept:?} s, fastest {fastest} m/s, overlap {overlap} m");
    assert_eq!(lab.errors(), []);
}

#[test]
fn a_pile_of_balls_sleeps() {
    sleeps("balls", |_, _| Collider::ball(0.25));
}

#[test]
fn a_pile_of_capsules_sleeps() {
    sleeps("capsules", |_, _| Collider::capsule(0.15, 0.25));
}

#[test]
fn a_pile_of_cylinders_sleeps() {
    sleeps("cylinders", |_, _| Collider::cylinder(0.2, 0.4));
}

#[test]
fn a_pile_of_all_sleeps() {
    sleeps("all", |i, _| match i % 4 {
        0 => Collider::ball(0.25),
        1 => Collider::capsule(0.15, 0.25),
        2 => Collider::cylinder(0.2, 0.4),
        _ => Collider::cuboid(0.4, 0.3, 0.35),
    });
}

#[test]
fn a_pile_of_hulls_sleeps() {
    sleeps("hulls", |_, rng| {
        let mut one = || rng.f32() - 0.5;
        let corners: Vec<Vec3> = (0..12)
            .map(|_| 0.22 * Vec3::new(one(), one(), one()).normalize())
            .collect();
        Collider::convex_hull(&corners).expect("a hull")
    });
}
