//! Bodies that sleep, fall asleep and wake, and walls that keep still.

use super::*;
use drystone::streaming::spawn_asleep;

/// Bodies and pairs at rest wake when a brick is taken out, and their contacts have what they carried.
pub fn wall_that_is_undermined() -> Scene {
    Scene {
        start: |world| {
            let bricks = build(world, "wall:8x6");
            steps(world, 180);
            assert!(inactive(world) > 40);
            bricks
        },
        edit: |world, bricks, step| match step {
            5 => _ = world.despawn(bricks[3]),
            // A value that it has already: it sleeps on.
            20 => *world.get_mut::<Friction>(bricks[20]).unwrap() = *world.get(bricks[20]).unwrap(),
            60 => world.get_mut::<Velocity>(bricks[30]).unwrap().linear.z = 2.0,
            _ => (),
        },
        steps: 120,
        ..Scene::default()
    }
}

/// The middle is in each of the steps in which the bodies fall asleep, so some sleeping bodies are still active.
pub fn wall_that_falls_asleep() -> Scene {
    Scene {
        start: |world| build(world, "wall:5x4"),
        middles: &[25, 28, 29, 30, 31, 32, 33],
        ..Scene::default()
    }
}

/// Weights of less than wakes a sleeping cube are laid on it one by one. The forces with which it fell asleep are part of the state.
pub fn weights_on_a_sleeping_cube() -> Scene {
    fn lay(world: &mut World, weight: Entity, i: usize) {
        let place = Transform::from_xyz(0.1 * (i % 4) as f32 - 0.15, 1.025, 0.1 * (i / 4) as f32);
        *world.get_mut::<Transform>(weight).unwrap() = place;
    }
    Scene {
        start: |world| {
            floor(world);
            let cube = cube(world, at(0.0, 0.5));
            let weight = Collider::cuboid(0.05, 0.05, 0.05);
            let weights = (0..11).map(|i| {
                let beside = at(2.0 + 0.2 * i as f32, 0.025);
                body(world, weight.clone(), beside, Mass(5.0))
            });
            let mut named: Vec<Entity> = weights.collect();
            steps(world, 180);
            for step in 0..45 {
                if step % 15 == 0 {
                    lay(world, named[step / 15], step / 15);
                }
                steps(world, 1);
            }
            assert!(world.get::<Sleeping>(cube).unwrap().asleep);
            named.push(cube);
            named
        },
        edit: |world, named, step| {
            if step % 15 == 0 {
                let next = 3 + step / 15;
                lay(world, named[next], next);
            }
            // It has woken by then.
            let cube = world.get::<Sleeping>(named[11]).unwrap();
            assert!(step < 119 || !cube.asleep);
        },
        steps: 120,
        ..Scene::default()
    }
}

fn in_a_stack(number: usize, x: f32) -> (RigidBody, Collider, Transform) {
    let place = at(x, 0.25 + 0.5 * number as f32);
    (RigidBody::Dynamic, Collider::cuboid(1.0, 0.5, 0.5), place)
}

/// Bodies fall asleep, and others are spawned asleep.
pub fn bodies_spawned_asleep() -> Scene {
    Scene {
        start: |world| {
            build(world, "wall:5x4");
            steps(world, 10);
            spawn_asleep(world, (0..5).map(|number| in_a_stack(number, 20.0)))
        },
        edit: |world, stack, step| match step {
            20 => _ = spawn_asleep(world, (0..5).map(|number| in_a_stack(number, 30.0))),
            30 => {
                let asleep = Sleeping {
                    asleep: true,
                    ..Sleeping::default()
                };
                world.spawn((in_a_stack(0, 40.0), asleep));
            }
            45 => _ = world.despawn(stack[0]),
            _ => (),
        },
        steps: 90,
        ..Scene::default()
    }
}

/// Stacks that sleep, and bricks that fall beside them.
pub fn sleepers_beside_falling_bodies() -> Scene {
    Scene {
        start: |world| {
            floor(world);
            let asleep = Sleeping {
                asleep: true,
                ..Sleeping::default()
            };
            for number in 0..12 {
                world.spawn((
                    in_a_stack(number % 4, 30.0 + 3.0 * (number / 4) as f32),
                    asleep,
                ));
            }
            for number in 0..15 {
                world.spawn(in_a_stack(number % 5, 3.0 * (number / 5) as f32));
            }
            let mut rng = fastrand::Rng::with_seed(5);
            for i in 0..40 {
                let place = Vec3::new(rng.f32() * 4.0, 4.0 + 0.3 * i as f32, rng.f32() * 2.0 - 1.0);
                let place = Transform::from_translation(place);
                body(world, Collider::cuboid(1.0, 0.5, 0.5), place, ());
            }
            cube(world, at(-10.0, 0.5));
            steps(world, 10);
            assert!(inactive(world) >= 12);
            Vec::new()
        },
        steps: 120,
        ..Scene::default()
    }
}

fn awake(world: &mut World, name: &str) -> Vec<Entity> {
    world.resource_mut::<SleepSettings>().enabled = false;
    build_off(world, name)
}

pub fn wall_of_20_by_15() -> Scene {
    Scene {
        start: |world| awake(world, "wall:20x15"),
        ..Scene::default()
    }
}

/// So large that its sweeps follow each other.
pub fn wall_of_100_by_50() -> Scene {
    Scene {
        start: |world| awake(world, "wall:100x50"),
        steps: 6,
        ..Scene::default()
    }
}

/// So tall that some of its sweeps go down.
pub fn wall_of_80_by_60() -> Scene {
    Scene {
        start: |world| awake(world, "wall:80x60"),
        steps: 3,
        ..Scene::default()
    }
}
