//! Heaps of round and rough bodies come to rest, and sleep.

use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::body::RigidBody;
use drystone::body::Sleeping;
use drystone::collider::{Collider, CombineRule, RollingFriction};
use drystone::diagnosis::BodyProblem;
use drystone_lab::metrics;
use drystone_lab::overlap::{self, Placed};
use glam::{Quat, Vec3};
use std::f32::consts::FRAC_PI_2;
use support::*;

/// A bin of five static cuboids, so many metres wide, with its floor at y = 0; or of four and a half-space.
fn bin(lab: &mut Lab, wide: f32, boxes: bool) {
    let high = 20.0;
    let wall = |at: Vec3, size: Vec3| {
        (
            RigidBody::Static,
            Collider::cuboid(size.x, size.y, size.z),
            Transform::from_translation(at),
        )
    };
    if boxes {
        let floor = Vec3::new(wide + 2.0, 1.0, wide + 2.0);
        lab.spawn(wall(Vec3::NEG_Y * 0.5, floor));
    } else {
        lab.ground();
    }
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
    seed: u64,
    collider: impl Fn(usize, &mut fastrand::Rng) -> Collider,
) -> Vec<Entity> {
    bin(lab, 3.0, seed % 2 == 1);
    let mut rng = fastrand::Rng::with_seed(seed);
    (0..300)
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

/// The poses of bodies.
fn placed(lab: &Lab, bodies: &[Entity]) -> Vec<Placed> {
    let of = |&body: &Entity| {
        let shape = lab.world.get::<Collider>(body).expect("a body").shape();
        Placed::new(lab.pose(body), shape.clone())
    };
    bodies.iter().map(of).collect()
}

/// Pairs that are near enough to overlap.
fn near(all: &[Placed]) -> impl Iterator<Item = (&Placed, &Placed)> {
    let pairs = all.iter().enumerate();
    let pairs = pairs.flat_map(|(i, a)| all[..i].iter().map(move |b| (a, b)));
    pairs.filter(|(a, b)| a.position().distance(b.position()) < 1.0)
}

/// The deepest overlap of two hulls by their corners alone, m: manifolds say nothing of contacts that were not found.
fn overlap_of_hulls(lab: &Lab, bodies: &[Entity]) -> f64 {
    let all = placed(lab, bodies);
    let hulls = near(&all).filter(|(a, b)| a.is_hull() && b.is_hull());
    let depths = hulls.filter_map(|(a, b)| overlap::between_polyhedra(a, b));
    depths.fold(0.0, f64::max)
}

/// The deepest overlap of any two that are not both hulls, m, found in another way than their manifolds are.
fn overlap_of_pairs(lab: &Lab, bodies: &[Entity]) -> f32 {
    let all = placed(lab, bodies);
    let others = near(&all).filter(|(a, b)| !(a.is_hull() && b.is_hull()));
    let depths = others.map(|(a, b)| overlap::least_way(a, b));
    depths.fold(0.0, f32::max)
}

/// In a bin and on a half-space, in so many seconds, and nothing lies more than 5 mm inside another. How the parts of a pile jam is
/// luck: so says the median of three piles, and twice as much the worst of them.
#[track_caller]
fn sleeps(what: &str, seconds: f32, collider: impl Fn(usize, &mut fastrand::Rng) -> Collider) {
    sleeps_within(what, seconds, 0.005, collider);
}

/// The same with another limit, m, because round bodies wedge themselves in.
#[track_caller]
fn sleeps_within(
    what: &str,
    seconds: f32,
    most: f32,
    collider: impl Fn(usize, &mut fastrand::Rng) -> Collider,
) {
    let (overlaps, awake) = settle_piles(what, seconds, 1..=3, collider);
    assert!(awake.is_empty(), "{what}: {awake:?} m/s after {seconds} s");
    overlaps_are_small(what, most, overlaps);
}

/// The deepest overlap of each pile that sleeps in so many seconds, m, and the largest speed in each of the others, m/s.
fn settle_piles(
    what: &str,
    seconds: f32,
    seeds: std::ops::RangeInclusive<u64>,
    collider: impl Fn(usize, &mut fastrand::Rng) -> Collider,
) -> (Vec<f32>, Vec<f32>) {
    let (mut overlaps, mut awake) = (Vec::new(), Vec::new());
    for seed in seeds {
        let mut lab = Lab::new();
        let bodies = pile(&mut lab, seed, &collider);
        let (slept, fastest, overlap) = settle(&mut lab, &bodies, seconds);
        let by_corners = overlap_of_hulls(&lab, &bodies) as f32;
        let of_pairs = overlap_of_pairs(&lab, &bodies);
        println!(
            "{what}: asleep at {slept:?} s, fastest {fastest} m/s, overlap {overlap} m, of hulls {by_corners} m, of pairs {of_pairs} m"
        );
        assert_eq!(lab.errors(), []);
        overlaps.push(overlap.max(by_corners).max(of_pairs));
        awake.extend(slept.is_none().then_some(fastest));
    }
    (overlaps, awake)
}

#[track_caller]
fn overlaps_are_small(what: &str, most: f32, mut overlaps: Vec<f32>) {
    overlaps.sort_by(f32::total_cmp);
    let median = overlaps[overlaps.len() / 2];
    let worst = overlaps[overlaps.len() - 1];
    assert!(
        median < most && worst < 2.0 * most,
        "{what}: {overlaps:?} m"
    );
}

#[test]
fn a_pile_of_balls_sleeps() {
    sleeps("balls", 10.0, |_, _| Collider::ball(0.25));
}

#[test]
fn a_pile_of_capsules_sleeps() {
    sleeps("capsules", 10.0, |_, _| Collider::capsule(0.15, 0.25));
}

#[test]
fn a_pile_of_cylinders_sleeps() {
    sleeps_within("cylinders", 10.0, 0.006, |_, _| {
        Collider::cylinder(0.2, 0.4)
    });
}

fn cone(_: usize, _: &mut fastrand::Rng) -> Collider {
    Collider::cone(0.22, 0.4)
}

#[test]
fn a_pile_of_cones_sleeps() {
    sleeps_within("cones", 10.0, 0.0065, cone);
}

#[test]
#[ignore = "missed since normals are rounded: 6.3 mm; the median of 21 such piles is 6.0, and was 5.4, their mean 6.0, and was 5.9"]
fn a_pile_of_cones_overlaps_by_no_more_than_cylinders() {
    sleeps_within("cones", 10.0, 0.006, cone);
}

fn all(i: usize, _: &mut fastrand::Rng) -> Collider {
    match i % 4 {
        0 => Collider::ball(0.25),
        1 => Collider::capsule(0.15, 0.25),
        2 => Collider::cylinder(0.2, 0.4),
        _ => Collider::cuboid(0.4, 0.3, 0.35),
    }
}

/// Twenty-three of twenty-four such piles sleep within 10 s, the other one after 10.2 s.
#[test]
fn most_piles_of_all_sleep() {
    let (overlaps, awake) = settle_piles("all", 10.0, 1..=4, all);
    assert!(awake.len() < 2, "{awake:?} m/s");
    overlaps_are_small("all", 0.005, overlaps);
}

/// These five sleep after 3 to 9 s. In some piles a hull creeps faster and faster, until it has found a place.
#[test]
fn most_piles_of_hulls_sleep() {
    let hull = |_: usize, rng: &mut fastrand::Rng| {
        let mut one = || rng.f32() - 0.5;
        let corners: Vec<Vec3> = (0..12)
            .map(|_| 0.22 * Vec3::new(one(), one(), one()).normalize())
            .collect();
        Collider::convex_hull(&corners).expect("a hull")
    };
    let (overlaps, awake) = settle_piles("hulls", 12.0, 1..=5, hull);
    assert!(awake.len() < 2, "{awake:?} m/s");
    overlaps_are_small("hulls", 0.005, overlaps);
}

/// A hull of 8 to 20 corners; some are slabs and some are splinters.
fn rubble(_: usize, rng: &mut fastrand::Rng) -> Collider {
    let count = rng.usize(8..=20);
    let mut one = || rng.f32() - 0.5;
    let size = 0.3 * Vec3::new(1.3 + one(), 1.0 + one(), 1.0 + one());
    let corners: Vec<Vec3> = (0..count)
        .map(|_| 0.75 * size * Vec3::new(one(), one(), one()).normalize())
        .collect();
    Collider::convex_hull(&corners).expect("a hull")
}

#[test]
fn a_pile_of_rubble_sleeps() {
    sleeps("rubble", 15.0, rubble);
}

/// They sleep after 3 to 11 s.
#[test]
#[ignore = "long"]
fn thirty_piles_of_rubble_sleep() {
    let (_, awake) = settle_piles("rubble", 20.0, 1..=30, rubble);
    assert!(awake.is_empty(), "{awake:?} m/s");
}

/// Flat faces with right angles, which come to lie on each other all over.
#[test]
fn a_pile_of_bricks_given_as_hulls_sleeps() {
    sleeps("bricks", 20.0, |_, _| {
        let corners: Vec<Vec3> = (0..8)
            .map(|i| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32) - 0.5)
            .map(|corner| Vec3::new(0.4, 0.3, 0.35) * corner)
            .collect();
        Collider::convex_hull(&corners).expect("a hull")
    });
}

/// On a slope of 2°, with the default and with none.
#[test]
fn rolling_friction_holds_a_round_body_on_a_slope() {
    for (shape, collider) in [
        ("ball", Collider::ball(0.3)),
        ("capsule", Collider::capsule(0.3, 0.6)),
        ("cylinder", Collider::cylinder(0.3, 0.6)),
    ] {
        let angle = 2f32.to_radians();
        let way = |coefficient: f32| {
            let mut lab = Lab::new();
            lab.slope(angle, 0.5);
            let slope = Quat::from_rotation_z(-angle);
            let body = lab.spawn((
                RigidBody::Dynamic,
                collider.clone(),
                RollingFriction::new(coefficient).with_rule(CombineRule::Min),
                Transform::from_translation(slope * Vec3::Y * 0.3)
                    .with_rotation(slope * Quat::from_rotation_x(FRAC_PI_2)),
            ));
            let start = lab.position(body);
            lab.run(3.0);
            (lab.position(body) - start).length()
        };
        let (held, free) = (way(0.05), way(0.0));
        println!("{shape}: {held} m with, {free} m without");
        assert!(held < 1e-3, "{shape}: {held} m");
        assert!(free > 0.9, "{shape}: {free} m");
    }
}

#[test]
fn a_ball_that_spins_on_the_spot_stops() {
    let mut lab = Lab::new();
    lab.ground();
    let ball = lab.body(Collider::ball(0.3), Vec3::Y * 0.3);
    lab.set_velocity(ball, Vec3::ZERO, Vec3::Y * 5.0);
    lab.run(3.0);
    assert_eq!(lab.velocity(ball).angular, Vec3::ZERO);
}

#[test]
fn rolling_friction_is_checked() {
    for bad in [-1.0, f32::NAN, f32::INFINITY] {
        let mut lab = Lab::new();
        lab.spawn((
            RigidBody::Dynamic,
            Collider::ball(0.3),
            RollingFriction::new(bad),
        ));
        lab.step();
        let problems: Vec<_> = lab.errors().into_iter().map(|e| e.problem).collect();
        assert_eq!(problems, [BodyProblem::InvalidMaterial], "{bad}");
    }
}

/// One message each, parted without violence, and in steps that do not take for ever.
fn part_gently(collider: Collider, steps: usize, most: f32) -> f32 {
    let mut lab = Lab::new();
    lab.ground();
    let bodies: Vec<Entity> = (0..300)
        .map(|_| lab.body(collider.clone(), Vec3::Y))
        .collect();
    let (mut messages, mut crowds, mut fastest) = (0, 0, 0.0f32);
    let began = std::time::Instant::now();
    for _ in 0..steps {
        lab.step();
        for error in lab.errors() {
            match error.problem {
                BodyProblem::Crowded => crowds += 1,
                _ => messages += 1,
            }
        }
        let speed = |&b: &Entity| lab.velocity(b).linear.length();
        fastest = bodies.iter().map(speed).fold(fastest, f32::max);
    }
    let each = began.elapsed().as_secs_f32() / steps as f32;
    let overlap = metrics::gaps(&mut lab.world).penetration_max;
    println!(
        "{collider:?}: {messages} messages, {fastest} m/s, {each} s a step, overlap {overlap} m"
    );
    // The first of them is the one that the others are told of.
    assert_eq!((messages, crowds), (299, 1));
    assert!(fastest < most, "{fastest} m/s");
    overlap
}

#[test]
fn three_hundred_bodies_in_one_place_part_gently() {
    for collider in [Collider::cuboid(0.5, 0.5, 0.5), Collider::ball(0.25)] {
        part_gently(collider, 30, 5.0);
    }
}

#[test]
#[ignore = "long"]
fn three_hundred_bodies_in_one_place_part_in_ten_seconds() {
    for collider in [Collider::cuboid(0.5, 0.5, 0.5), Collider::ball(0.25)] {
        // From the top of the heap they make some fall two metres and more.
        let overlap = part_gently(collider, 600, 10.0);
        assert!(overlap < 0.01, "{overlap} m");
    }
}
