//! Scenes in which much is changed.

use super::*;
use bevy_transform::components::Transform;
use drystone::snapshot::Snapshot;
use drystone::streaming;

/// A joint that was there before its body: the replay knows which entity it waits for.
#[test]
fn joints_wait_for_their_bodies() {
    let mut world = floor();
    let later = world.spawn_empty().id();
    let hook = SphericalJoint::new(None, later).with_anchor(Vec3::Y * 3.0);
    world.spawn(hook);
    steps(&mut world, 5);
    let mut last = None;
    goes_again("waits", world, 40, |world, step| match step {
        10 => {
            let ball = (RigidBody::Dynamic, Collider::ball(0.2), place(0.5, 3.0));
            world.entity_mut(later).insert(ball);
        }
        15 => {
            let empty = world.spawn_empty().id();
            world.spawn(DistanceJoint::new(later, empty));
            last = Some(empty);
        }
        20 => {
            let ball = (RigidBody::Dynamic, Collider::ball(0.2), place(1.0, 3.0));
            world.entity_mut(last.unwrap()).insert(ball);
        }
        _ => (),
    });
}

#[test]
fn hands_hold_bodies() {
    let (mut world, bodies) = scene("wall:4x3");
    steps(&mut world, 20);
    let above = brick(&mut world, 0.0, 3.0);
    let ray = |x: f32, y: f32| Some(Ray3d::new(Vec3::new(x, y, 5.0), Dir3::NEG_Z));
    let mut hand = None;
    let last = *bodies.last().unwrap();
    let recorded = record(world, 80, |world, step| {
        match step {
            2 => {
                let ray = ray(0.0, world.get::<Transform>(above).unwrap().translation.y);
                let closed = true;
                hand = Some(
                    world
                        .spawn(Hand {
                            ray,
                            closed,
                            ..Hand::new(10_000.0)
                        })
                        .id(),
                );
            }
            50 => _ = world.despawn(hand.take().unwrap()),
            60 => {
                let grab = Grab::gentle(1_000.0, Vec3::ZERO, Vec3::Y * 3.0);
                world.entity_mut(last).insert(grab);
            }
            70 => _ = world.entity_mut(last).remove::<Grab>(),
            _ => (),
        }
        if let Some(hand) = hand.filter(|_| step > 10) {
            let state = world.get::<HandState>(hand).unwrap().held();
            assert_eq!(state, (step < 41).then_some(above), "{step}");
            let mut hand = world.get_mut::<Hand>(hand).unwrap();
            let down = 0.02 * step as f32;
            hand.ray = ray(down, 3.0 - down);
            hand.closed = step < 40;
        }
    });
    replays("hands", &recorded);
}

/// What observers do when the events of a step are triggered belongs to the next step.
#[test]
fn observers_of_contacts_write() {
    let mut world = floor();
    for i in 0..4 {
        let ball = Collider::ball(0.3);
        body(
            &mut world,
            ball,
            i as f32,
            1.0 + 0.3 * i as f32,
            ContactEvents,
        );
    }
    world.add_observer(
        |hit: On<ContactStarted>, mut bodies: Query<&mut Velocity>, mut commands: Commands| {
            bodies.get_mut(hit.body).unwrap().linear.y += 3.0;
            let at = Transform::from_translation(hit.point + Vec3::Y * 4.0);
            commands.spawn((RigidBody::Dynamic, Collider::ball(0.1), at));
        },
    );
    // What is seen before the next step includes that already.
    let mut seen = Vec::new();
    let mut recorded = record(world, 90, |world, _| seen.push(all(world)));
    let count = changes(&recorded).len();
    assert!((4..40).contains(&count), "{count}");
    recorded.seen.clear();
    let recording = Recording::from_bytes(&recorded.bytes).unwrap();
    let mut other = other_world(1);
    let mut replay = Replay::start(&recording, &mut other).unwrap();
    for (step, seen) in seen.iter().enumerate() {
        let known = all(&mut other);
        assert!(known.iter().all(|body| seen.contains(body)), "{step}");
        replay.step(&mut other).unwrap();
        assert_eq!(replay.divergence(), None);
    }
    assert!(all(&mut other).len() >= 5 + 4);
}

/// The bodies and their heights, in the order of spawning.
fn all(world: &mut World) -> Vec<(SpawnOrder, u32)> {
    let mut bodies = world.query::<(&SpawnOrder, &Transform)>();
    let bodies = bodies.iter(world);
    bodies
        .map(|(order, at)| (*order, at.translation.y.to_bits()))
        .collect()
}

/// More than components is changed: the recording has a snapshot of that.
#[test]
fn the_state_is_replaced() {
    let (mut world, _) = scene("wall:4x3");
    let far = (0..3).map(|i| brick(&mut world, 20.0, 0.25 + 0.5 * i as f32));
    let far: Vec<Entity> = far.collect();
    steps(&mut world, 200);
    let (mut snapshot, mut region) = (None, None);
    let recorded = record(world, 80, |world, step| match step {
        10 => snapshot = Some(Snapshot::take(world)),
        11 => _ = brick(world, 0.2, 3.0),
        30 => _ = snapshot.take().unwrap().restore(world).unwrap(),
        40 => region = Some(streaming::take_out(world, far.iter().copied()).unwrap()),
        45 => _ = brick(world, 0.1, 2.5),
        60 => _ = streaming::put_back(world, region.take().unwrap()),
        65 => world.get_mut::<Velocity>(far[2]).unwrap().linear.x = 1.0,
        // A contact.
        70 => {
            let mut pairs = world.query_filtered::<Entity, With<ContactPair>>();
            let pair = pairs.iter(world).next().unwrap();
            world.despawn(pair);
        }
        _ => (),
    });
    assert_eq!(changes(&recorded), [11, 30, 40, 45, 60, 65, 70]);
    replays("replaced", &recorded);
}

/// Bodies that break spawn others during a step; the user then moves, changes and removes some of those.
#[test]
fn pieces_of_bodies_that_break_are_known() {
    let (mut world, bodies) = scene("wall:4x3");
    for &brick in &bodies {
        let debris = Debris {
            lifetime: 0.9,
            ..Default::default()
        };
        let rules = Fracturable {
            energy: 5.0,
            again: 1,
            debris: Some(debris),
            ..Default::default()
        };
        world.entity_mut(brick).insert(rules);
    }
    steps(&mut world, 20);
    let pieces = |world: &mut World| -> Vec<Entity> {
        let mut all = world.query::<(Entity, &SpawnOrder, &Debris)>();
        let mut all: Vec<_> = all.iter(world).map(|of| (*of.1, of.0)).collect();
        all.sort_unstable();
        all.into_iter().map(|(_, piece)| piece).collect()
    };
    let recorded = record(world, 90, |world, step| match step {
        3 => {
            let ball = (
                RigidBody::Dynamic,
                Collider::ball(0.2),
                Mass(50.0),
                place(0.2, 0.8),
            );
            let ball = world.spawn(ball).id();
            let at = Vec3::new(0.2, 0.8, 3.0);
            world.get_mut::<Transform>(ball).unwrap().translation = at;
            *world.get_mut::<Velocity>(ball).unwrap() = Velocity::linear(-20.0 * Vec3::Z);
        }
        25 => {
            let pieces = pieces(world);
            assert!(pieces.len() > 8, "{} pieces", pieces.len());
            *world.get_mut::<Velocity>(pieces[0]).unwrap() = Velocity::linear(Vec3::Y);
            world.entity_mut(pieces[1]).insert(Friction::new(0.1));
            world.despawn(pieces[2]);
        }
        40 => _ = drystone::fracture::shatter(world, bodies[0], None),
        _ => (),
    });
    replays("fracture", &recorded);
}
