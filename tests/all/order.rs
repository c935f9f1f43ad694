//! The order in which contacts are swept follows from which body stands on which, and not from the order of spawning or the `Entity`.

use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::body::{BodyIndex, Pose, RigidBody, SpawnOrder};
use drystone::collider::Collider;
use drystone::graph::Islands;
use drystone::settings::SleepSettings;
use drystone_lab::metrics::Displacement;
use drystone_lab::scenes::{Scene, SceneOptions};
use glam::Vec3;
use support::*;

/// A wall with noise, spawned in a permutation of its order; drift and sag after some seconds, mm: the mean of three walls.
fn stands(
    scene: &str,
    seconds: f32,
    permute: impl Fn(&mut Vec<(Collider, Transform)>),
) -> [f32; 2] {
    let mut mean = [0.0; 2];
    for seed in 1..=3 {
        for (mean, found) in mean
            .iter_mut()
            .zip(stands_once(scene, seed, seconds, &permute))
        {
            *mean += found / 3.0;
        }
    }
    mean
}

fn stands_once(
    scene: &str,
    seed: u64,
    seconds: f32,
    permute: impl Fn(&mut Vec<(Collider, Transform)>),
) -> [f32; 2] {
    // Built once to see where everything goes.
    let mut plan = Lab::new();
    let scene: Scene = scene.parse().unwrap();
    let options = SceneOptions {
        noise_position: 0.002,
        noise_angle: 0.01,
        lateral_gap: 0.036,
        seed,
        ..Default::default()
    };
    let built = scene.build(&mut plan.world, &options);
    let mut bodies: Vec<(Collider, Transform)> = built
        .bodies
        .iter()
        .map(|&b| {
            let body = plan.world.entity(b);
            (
                body.get::<Collider>().unwrap().clone(),
                *body.get::<Transform>().unwrap(),
            )
        })
        .collect();
    permute(&mut bodies);
    let mut lab = Lab::shipped(1.0 / 60.0);
    lab.ground();
    let bodies: Vec<Entity> = bodies
        .into_iter()
        .map(|(collider, transform)| lab.spawn((RigidBody::Dynamic, collider, transform)))
        .collect();
    let poses = |lab: &Lab| -> Vec<Pose> { bodies.iter().map(|&b| lab.pose(b)).collect() };
    let start = poses(&lab);
    lab.run(seconds);
    let moved = Displacement::between(&start, &poses(&lab));
    [1e3 * moved.drift, 1e3 * moved.sag]
}

/// Asserts that in most orders a structure drifts and sags by as much as in all of them on average, within a factor of 1.5; in all, of 2.
#[track_caller]
fn alike(scene: &str, seconds: f32) {
    let shuffled = |seed| {
        stands(scene, seconds, |bodies| {
            fastrand::Rng::with_seed(seed).shuffle(bodies);
        })
    };
    let mut found = vec![
        ("in order".to_owned(), stands(scene, seconds, |_| ())),
        (
            "reversed".to_owned(),
            stands(scene, seconds, |bodies| bodies.reverse()),
        ),
    ];
    found.extend((1..=6).map(|seed| (format!("shuffled {seed}"), shuffled(seed))));
    let mean = |i: usize| found.iter().map(|(_, moved)| moved[i]).sum::<f32>() / found.len() as f32;
    let means = [mean(0), mean(1)];
    println!("{scene}: {means:?} mm on average");
    let ratio = |moved: &[f32; 2]| {
        let of = |i: usize| {
            // A hundredth of a millimetre is nothing to compare.
            let ratio = (moved[i] + 0.01) / (means[i] + 0.01);
            ratio.max(1.0 / ratio)
        };
        of(0).max(of(1))
    };
    for (what, moved) in &found {
        let ratio = ratio(moved);
        println!("{scene} {what}: {moved:?} mm, {ratio:.2} times");
        assert!(ratio < 2.0, "{what}: {moved:?} mm, on average {means:?} mm");
    }
    // The bricks land, and rounding decides how.
    let alike = found.iter().filter(|(_, moved)| ratio(moved) < 1.5);
    assert!(4 * alike.count() >= 3 * found.len());
}

#[test]
fn a_wall_of_10_by_10_stands_alike_in_whatever_order_it_is_spawned() {
    alike("wall:10x10", 10.0);
}

#[test]
#[ignore = "long"]
fn a_wall_of_40_by_25_stands_alike_in_whatever_order_it_is_spawned() {
    alike("wall:40x25", 5.0);
}

/// Despawned and spawned again: `Entity`s are handed out last in, first out.
#[test]
fn a_wall_spawned_again_stands() {
    let mut lab = Lab::shipped(1.0 / 60.0);
    let scene = Scene::Wall(10, 10);
    let built = scene.build(&mut lab.world, &SceneOptions::default());
    lab.run(0.5);
    let mut all = lab.world.query_filtered::<Entity, With<RigidBody>>();
    let all: Vec<Entity> = all.iter(&lab.world).collect();
    for body in all {
        lab.world.despawn(body);
    }
    let again = scene.build(&mut lab.world, &SceneOptions::default());
    assert_eq!(built.bodies.len(), again.bodies.len());
    let start: Vec<Vec3> = again.bodies.iter().map(|&b| lab.position(b)).collect();
    lab.run(5.0);
    for (&body, start) in again.bodies.iter().zip(&start) {
        let moved = (lab.position(body) - *start).length();
        assert!(moved < 2e-3, "{moved}");
    }
}

/// A server and its clients hear of bodies in different orders.
#[test]
fn the_same_bits_in_any_order_of_spawning_with_ages_by_hand() {
    let run = |permute: fn(&mut Vec<u64>)| {
        let mut lab = Lab::new();
        lab.world.resource_mut::<SleepSettings>().enabled = false;
        let mut spawn_orders: Vec<u64> = (0..40).collect();
        permute(&mut spawn_orders);
        for spawn_order in spawn_orders {
            let body = match spawn_order {
                0 => lab.ground(),
                // A slab, so that something stands on two bodies that stand still.
                1 => lab.spawn((
                    RigidBody::Static,
                    Collider::cuboid(3.0, 0.1, 3.0),
                    Transform::from_xyz(0.5, 0.05, 0.5),
                )),
                _ => {
                    let (x, y) = ((spawn_order % 3) as f32, (spawn_order / 3) as f32);
                    lab.cube(Vec3::new(0.3 * x + 0.1 * y, 0.6 + 1.1 * y, 0.4 * x))
                }
            };
            // The numbers may be large: a server may use the time.
            lab.world
                .entity_mut(body)
                .insert(SpawnOrder(spawn_order << 40));
        }
        lab.run(2.0);
        lab.bits()
    };
    let plain = run(|_| ());
    assert_eq!(plain, run(|spawn_orders| spawn_orders.reverse()));
    assert_eq!(
        plain,
        run(|spawn_orders| fastrand::Rng::with_seed(7).shuffle(spawn_orders))
    );
}

#[test]
fn a_body_knows_how_far_above_the_ground_it_stands() {
    let mut lab = Lab::new();
    let falling = lab.cube(Vec3::Y * 20.0);
    let cubes = [3.5, 1.5, 0.5, 2.5].map(|y| lab.cube(Vec3::Y * y));
    lab.ground();
    lab.step();
    let level = |body: Entity| {
        let slot = lab.world.get::<BodyIndex>(body).unwrap().0;
        lab.world.resource::<Islands>().level(slot)
    };
    assert_eq!(cubes.map(level), [Some(4), Some(2), Some(1), Some(3)]);
    assert_eq!(level(falling), None, "nothing carries it");
}
