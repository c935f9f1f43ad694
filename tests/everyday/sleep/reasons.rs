//! Who woke whom, and why: each reason, with the body that is named.

use super::*;
use drystone::graph::{WakeReason, Wakes};

/// Two cubes on a plate, and one beside them that never sleeps.
struct Site {
    plate: Entity,
    lower: Entity,
    upper: Entity,
    restless: Entity,
}

fn cube(x: f32, y: f32) -> impl Bundle {
    let place = Transform::from_xyz(x, y, 0.0);
    (RigidBody::Dynamic, Collider::cuboid(1.0, 1.0, 1.0), place)
}

fn asleep(world: &mut World, waking: Option<Waking>) -> Site {
    if let Some(waking) = waking {
        world.resource_mut::<SleepSettings>().waking = waking;
    }
    let plate = (RigidBody::Kinematic, Collider::cuboid(20.0, 1.0, 20.0));
    let plate = world.spawn((plate, Transform::from_xyz(0.0, -0.5, 0.0)));
    let plate = plate.id();
    let lower = world.spawn(cube(0.0, 0.5)).id();
    let upper = world.spawn(cube(0.0, 1.5)).id();
    let allowed = Sleeping {
        allowed: false,
        ..Default::default()
    };
    let restless = world.spawn((cube(5.0, 0.5), allowed)).id();
    for _ in 0..120 {
        drystone::step(world, 1.0 / 60.0).unwrap();
    }
    assert!(is_asleep(world, lower) && is_asleep(world, upper));
    assert!(!is_asleep(world, restless));
    world.resource_mut::<Wakes>().clear();
    Site {
        plate,
        lower,
        upper,
        restless,
    }
}

/// A change, with the body that it wakes first, the reason, and the body that is named.
type Change = fn(&mut World, &Site) -> (Entity, WakeReason, Option<Entity>);

fn check(name: &str, waking: Option<Waking>, change: Change) {
    let mut app = app();
    let world = app.world_mut();
    let site = asleep(world, waking);
    let (first, reason, by) = change(world, &site);
    for _ in 0..90 {
        drystone::step(world, 1.0 / 60.0).unwrap();
        let wakes = world.resource::<Wakes>();
        if let Some(wake) = wakes.recent().next() {
            assert_eq!(
                (wake.first, wake.reason, wake.by),
                (first, reason, by),
                "{name}"
            );
            assert_eq!(wake.run, wakes.runs(), "{name}");
            assert!((1..=2).contains(&wake.count), "{name}: {}", wake.count);
            return;
        }
    }
    panic!("{name}: nothing woke");
}

fn ball(world: &mut World, at: Vec3, velocity: Vec3) -> Entity {
    let ball = (RigidBody::Dynamic, Collider::ball(0.3), Density(4000.0));
    let place = Transform::from_translation(at);
    world.spawn((ball, place, Velocity::linear(velocity))).id()
}

#[test]
fn wakes_are_recorded_with_their_reason_and_with_the_body_that_woke() {
    check("a written component", None, |world, site| {
        world.entity_mut(site.upper).insert(GravityScale(0.5));
        (site.upper, WakeReason::Edited, None)
    });
    check("a support that is gone", None, |world, site| {
        world.despawn(site.lower);
        (site.upper, WakeReason::LostContact, None)
    });
    check("ground that moves", None, |world, site| {
        let moves = Velocity::linear(Vec3::X * 0.2);
        world.entity_mut(site.plate).insert(moves);
        (site.lower, WakeReason::GroundChanged, Some(site.plate))
    });
    check("a ball", None, |world, site| {
        let ball = ball(world, Vec3::new(0.0, 1.95, 3.0), Vec3::NEG_Z * 8.0);
        (site.upper, WakeReason::Hit, Some(ball))
    });
    check(
        "a ball, by islands",
        Some(Waking::Islands),
        |world, site| {
            let ball = ball(world, Vec3::new(0.0, 1.95, 3.0), Vec3::NEG_Z * 8.0);
            (site.upper, WakeReason::Touched, Some(ball))
        },
    );
    check("a weight", None, |world, site| {
        let weight = world.spawn((cube(0.0, 2.5), Density(3000.0))).id();
        (site.upper, WakeReason::LoadChanged, Some(weight))
    });
    check("a body that is put into another", None, |world, site| {
        let other = world.spawn(cube(0.97, 1.5)).id();
        (site.upper, WakeReason::Overlapped, Some(other))
    });
    check("a body that is added asleep", None, |world, site| {
        let place = world.get::<Transform>(site.restless).unwrap().translation;
        let sleeps = Sleeping {
            asleep: true,
            ..Default::default()
        };
        let added = world.spawn((cube(place.x, place.y + 1.0), sleeps)).id();
        (added, WakeReason::Added, None)
    });
}

/// The last groups are kept.
#[test]
fn old_wakes_are_forgotten() {
    let mut app = app();
    let world = app.world_mut();
    floor(world);
    let mut bodies = Vec::new();
    for i in 0..Wakes::CAPACITY + 8 {
        bodies.push(world.spawn(cube(2.0 * i as f32, 0.5)).id());
    }
    for _ in 0..120 {
        drystone::step(world, 1.0 / 60.0).unwrap();
    }
    for &body in &bodies {
        world.entity_mut(body).insert(GravityScale(0.9));
        drystone::step(world, 1.0 / 60.0).unwrap();
    }
    let wakes = world.resource::<Wakes>();
    assert_eq!(wakes.recent().len(), Wakes::CAPACITY);
    let last = wakes.recent().next_back().unwrap();
    assert_eq!(
        (last.first, last.run),
        (*bodies.last().unwrap(), wakes.runs())
    );
}
