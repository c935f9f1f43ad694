//! Bodies that are dropped on standing structures.

use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::body::RigidBody;
use drystone::collider::{Collider, Restitution};
use drystone_lab::scenes::{Scene, SceneOptions};
use glam::Vec3;
use support::*;

/// Half a brick's height, m.
const HALF: f32 = 0.25;

/// Drops a brick of restitution e from 0.5 m on something at this height; how high it bounces, m.
fn bounce(lab: &mut Lab, top: f32, restitution: f32) -> f32 {
    let brick = lab.spawn((
        RigidBody::Dynamic,
        Collider::cuboid(1.0, 0.5, 0.5),
        Restitution::new(restitution),
        Transform::from_xyz(0.0, top + HALF + 0.5, 0.0),
    ));
    let (mut landed, mut highest) = (false, 0f32);
    for _ in 0..(2.0 / lab.dt) as usize {
        lab.step();
        let [at, v] = [
            lab.position(brick).y - top - HALF,
            lab.velocity(brick).linear.y,
        ];
        landed |= v > -0.01;
        if landed {
            highest = highest.max(at);
        }
    }
    highest
}

/// Drops a brick on the floor and on the top of a wall of 6 × 6, whose bricks bounce like it; how high it bounces on either, and how far
/// the wall's bricks are moved, m.
fn on_floor_and_wall(dt: f32, restitution: f32) -> [f32; 3] {
    let mut lab = Lab::shipped(dt);
    let floor = lab.ground();
    lab.world
        .entity_mut(floor)
        .insert(Restitution::new(restitution));
    let on_floor = bounce(&mut lab, 0.0, restitution);

    let mut lab = Lab::shipped(dt);
    let scene = Scene::Wall(6, 6);
    let bricks = scene.build(&mut lab.world, &SceneOptions::default()).bodies;
    for &brick in &bricks {
        lab.world
            .entity_mut(brick)
            .insert(Restitution::new(restitution));
    }
    lab.run(5.0);
    let start: Vec<Vec3> = bricks.iter().map(|&b| lab.position(b)).collect();
    let on_wall = bounce(&mut lab, 3.0, restitution);
    let moved = bricks
        .iter()
        .zip(&start)
        .map(|(&brick, start)| lab.position(brick).distance(*start));
    [on_floor, on_wall, moved.fold(0.0, f32::max)]
}

/// Asserts that a wall throws nothing higher than the floor does, and is not moved by more than a millimetre.
#[track_caller]
fn wall_is_like_floor(dt: f32) {
    let mut missed = Vec::new();
    for restitution in [0.0, 0.3, 0.6] {
        let mm = on_floor_and_wall(dt, restitution).map(|m| 1e3 * m);
        let [on_floor, on_wall, moved] = mm;
        let found = format!(
            "Δt {dt:.4}, e {restitution}: bounces {on_floor:.1} mm on the floor, {on_wall:.1} on the wall, which moves {moved:.2} mm"
        );
        println!("{found}");
        if on_wall > on_floor + 1.0 || moved > 1.0 {
            missed.push(found);
        }
    }
    assert!(missed.is_empty(), "{missed:#?}");
}

#[test]
fn a_brick_dropped_on_a_wall_bounces_no_higher_than_on_the_floor() {
    wall_is_like_floor(1.0 / 60.0);
}

#[test]
fn a_brick_dropped_on_a_wall_bounces_no_higher_than_on_the_floor_at_large_steps() {
    wall_is_like_floor(0.1);
}

/// How many cubes stand when each half second one is dropped from 0.3 m above the top, up to 2 cm beside, until 30 are there: as many as
/// were dropped before something fell, and 29 if it falls in the ten seconds after.
fn tower(dt: f32, seed: u64) -> usize {
    let mut rng = fastrand::Rng::with_seed(seed);
    let mut lab = Lab::shipped(dt);
    lab.ground();
    let mut cubes: Vec<Entity> = Vec::new();
    let fallen = |lab: &Lab, cubes: &[Entity]| {
        let place = |i: usize| Vec3::Y * (i as f32 + 0.5);
        let mut places = cubes.iter().enumerate();
        places.any(|(i, &cube)| lab.position(cube).distance(place(i)) > 0.5)
    };
    for i in 0..30 {
        let mut beside = || 0.02 * (2.0 * rng.f32() - 1.0);
        let position = Vec3::new(beside(), i as f32 + 0.8, beside());
        cubes.push(lab.cube(position));
        lab.run(0.5);
        if fallen(&lab, &cubes) {
            return i;
        }
    }
    lab.run(10.0);
    if fallen(&lab, &cubes) { 29 } else { 30 }
}

/// Asserts that towers of 30 stand.
#[track_caller]
fn towers_stand(dt: f32) {
    let stand = [1, 2, 3].map(|seed| tower(dt, seed));
    println!("Δt {dt:.4}: {stand:?} of 30 cubes stand");
    assert_eq!(stand, [30; 3]);
}

#[test]
fn a_tower_of_thirty_dropped_cubes_stands() {
    towers_stand(1.0 / 60.0);
}

#[test]
fn a_tower_of_thirty_dropped_cubes_stands_at_large_steps() {
    towers_stand(0.1);
}

#[test]
fn a_stack_of_thirty_stands_a_minute_at_large_steps() {
    let mut lab = Lab::shipped(0.1);
    let scene = Scene::Stack(30);
    let cubes = scene.build(&mut lab.world, &SceneOptions::default()).bodies;
    lab.run(60.0);
    let places = (0..30).map(|i| Vec3::Y * (i as f32 + 0.5));
    let moved = cubes
        .iter()
        .zip(places)
        .map(|(&cube, place)| lab.position(cube).distance(place))
        .fold(0.0, f32::max);
    println!("moved {:.1} mm", 1e3 * moved);
    assert!(moved < 0.001, "moved {moved} m");
}
