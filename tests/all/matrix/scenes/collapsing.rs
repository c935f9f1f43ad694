//! Structures that are watched and collapse.

use super::*;
use drystone::collapse::CollapseSettings;

/// A wall that is watched, asleep from the beginning or not.
fn watched(world: &mut World, is_asleep: bool) -> Vec<Entity> {
    let bricks = build(world, "wall:6x5");
    for &brick in &bricks {
        let asks = ContactForceEvents {
            threshold: 30_000.0,
        };
        let mut brick = world.entity_mut(brick);
        brick.insert((Watch::default(), Load::default(), asks));
        brick.get_mut::<Sleeping>().unwrap().asleep = is_asleep;
    }
    bricks
}

fn counts(shown: &[Shown]) -> [usize; 2] {
    ["collapse", "collapse ended"].map(|report| count(shown, report))
}

/// In the middle two bricks were taken since the last step.
pub fn collapse() -> Scene {
    Scene {
        start: |world| {
            let bricks = watched(world, false);
            world.resource_mut::<CollapseSettings>().max_time = 1.5;
            steps(world, 60);
            for &corner in &bricks[..2] {
                world.despawn(corner);
            }
            Vec::new()
        },
        steps: 120,
        shows: |shown| assert_eq!(counts(shown), [1, 1]),
        ..Scene::default()
    }
}

/// In the middle the collapse was reported, and its end was not.
pub fn end_of_a_collapse() -> Scene {
    Scene {
        start: |world| {
            let bricks = watched(world, false);
            steps(world, 60);
            world.despawn(bricks[0]);
            steps(world, 25);
            Vec::new()
        },
        steps: 120,
        shows: |shown| assert_eq!(counts(shown), [0, 1]),
        ..Scene::default()
    }
}

/// A wall that is spawned asleep stands as soon as it is at rest.
pub fn collapse_of_a_wall_spawned_asleep() -> Scene {
    Scene {
        start: |world| {
            let bricks = watched(world, true);
            steps(world, 10);
            assert!(inactive(world) > 3);
            world.despawn(bricks[0]);
            Vec::new()
        },
        steps: 120,
        shows: |shown| assert_eq!(counts(shown)[0], 1),
        ..Scene::default()
    }
}

pub fn wall_spawned_asleep_that_has_collapsed() -> Scene {
    Scene {
        middles: &[40],
        shows: |shown| assert_eq!(counts(shown)[0], 0),
        ..collapse_of_a_wall_spawned_asleep()
    }
}
