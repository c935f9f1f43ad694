//! Bodies that are spawned and despawned leave no memory behind.

use crate::MEMORY;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::body::{Inactive, RigidBody, Sleeping, Velocity};
use drystone::collider::Collider;
use drystone::settings::PhysicsThreads;
use glam::Vec3;
use stats_alloc::Region;
use support::*;

/// Cubes that come asleep, each by itself.
const CUBES: usize = 500;

fn rests(lab: &Lab, body: Entity) -> bool {
    lab.world.get::<Inactive>(body).is_some()
}

fn spawn(lab: &mut Lab, cube: &Collider) -> Vec<Entity> {
    let cubes = (0..CUBES).map(|i| {
        let asleep = Sleeping {
            asleep: true,
            ..Default::default()
        };
        let at = Transform::from_xyz(2.0 * i as f32, 0.5, 0.0);
        lab.spawn((RigidBody::Dynamic, cube.clone(), asleep, at))
    });
    cubes.collect()
}

fn steps(lab: &mut Lab, count: usize) {
    for _ in 0..count {
        drystone::step(&mut lab.world, 1.0 / 60.0).unwrap();
    }
}

/// Bytes that so many rounds leave behind, for each island and round.
fn left_behind(lab: &mut Lab, rounds: usize, mut round: impl FnMut(&mut Lab)) -> f64 {
    for _ in 0..20 {
        round(lab);
    }
    let region = Region::new(MEMORY);
    for _ in 0..rounds {
        round(lab);
    }
    let change = region.change();
    let bytes = change.bytes_allocated as f64 - change.bytes_deallocated as f64;
    bytes / (rounds * CUBES) as f64
}

pub fn islands_that_cease_to_rest_leave_nothing_behind() {
    let rounds = std::env::var("ROUNDS").map_or(200, |rounds| rounds.parse().unwrap());
    let cube = Collider::cuboid(1.0, 1.0, 1.0);
    let mut lab = Lab::new();
    lab.world.insert_resource(PhysicsThreads::new(1).unwrap());
    lab.ground();
    let despawned = left_behind(&mut lab, rounds, |lab| {
        let cubes = spawn(lab, &cube);
        steps(lab, 3);
        assert!(cubes.iter().all(|&cube| rests(lab, cube)));
        for cube in cubes {
            lab.world.despawn(cube);
        }
        steps(lab, 1);
    });
    println!("despawned at rest: {despawned:.2} B an island");
    // A component of bodies at rest is written: they are checked, and stay at rest.
    let cubes = spawn(&mut lab, &cube);
    steps(&mut lab, 3);
    let written = left_behind(&mut lab, rounds, |lab| {
        for &cube in &cubes {
            *lab.world.get_mut::<Velocity>(cube).unwrap() = Velocity::linear(Vec3::ZERO);
        }
        steps(lab, 4);
        assert!(cubes.iter().all(|&cube| rests(lab, cube)));
    });
    println!("written to at rest: {written:.2} B an island");
    assert!(despawned < 1.0 && written < 1.0);
}
