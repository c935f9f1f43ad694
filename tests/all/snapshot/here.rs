//! A world that has gone on in other ways before it is restored.

use super::*;
use bevy_ecs::hierarchy::{ChildOf, Children};
use drystone::streaming;

/// A component of the game.
#[derive(Component, Debug, PartialEq)]
struct Mesh(u32);

/// Bodies are despawned, spawned, and changed in every way before the snapshot is restored. The world goes on as one that went straight on.
#[test]
fn spawns_and_despawns_in_between() {
    let (mut world, bodies) = scene("wall:6x4");
    let child = (Collider::ball(0.2), place(0.0, 0.4), ChildOf(bodies[20]));
    let child = world.spawn(child).id();
    steps(&mut world, 90);
    let snapshot = Snapshot::take(&world);
    let (top, below) = (bodies[23], bodies[2]);
    let act = |world: &mut World, here: &dyn Fn(Entity) -> Entity, step: usize| match step {
        3 => world.get_mut::<Velocity>(here(top)).unwrap().linear.x = 1.0,
        25 => _ = world.despawn(here(below)),
        _ => (),
    };
    let first = go_on(&mut world, &act, &|entity| entity);

    let mut new = Vec::new();
    for i in 0..5 {
        new.push(brick(&mut world, 0.3 * i as f32, 4.0 + i as f32));
    }
    world.despawn(bodies[20]);
    world.despawn(bodies[7]);
    // Its parent was spawned since: it is not despawned with it.
    world.entity_mut(bodies[9]).insert(ChildOf(new[0]));
    world
        .entity_mut(bodies[10])
        .insert((Mass(90.0), Friction::new(0.1), Disabled));
    world
        .entity_mut(bodies[11])
        .remove::<(RigidBody, Collider)>();
    world.entity_mut(bodies[12]).insert(RigidBody::Static);
    steps(&mut world, 20);
    world.despawn(new[3]);
    brick(&mut world, 5.0, 1.0);

    let map = snapshot.restore(&mut world).unwrap();
    for gone in [bodies[20], child, bodies[7], bodies[2]] {
        assert_ne!(map[&gone], gone);
    }
    assert!(!map.contains_key(&bodies[9]));
    assert!(world.get::<ChildOf>(bodies[9]).is_none());
    assert_eq!(
        world.get::<ChildOf>(map[&child]).unwrap().parent(),
        map[&bodies[20]]
    );
    assert_eq!(world.get::<Children>(map[&bodies[20]]).unwrap().len(), 1);
    assert!(new.iter().all(|&body| world.get_entity(body).is_err()));
    let now = Snapshot::take(&world);
    assert_eq!(snapshot.first_difference(&now, &map), None);
    let here = |entity| map.get(&entity).copied().unwrap_or(entity);
    assert_same("in between", &first, &go_on(&mut world, &act, &here));
}

/// A snapshot is restored many times, as a client does that predicts.
#[test]
fn steps_that_are_taken_back_again_and_again() {
    let (mut world, bodies) = scene("wall:5x4");
    steps(&mut world, 20);
    let push = |world: &mut World, step: usize| {
        let mut body = world.get_mut::<ExternalImpulse>(bodies[step % 20]).unwrap();
        body.linear.z = if step.is_multiple_of(3) { 40.0 } else { 0.0 };
    };
    let mut straight = Vec::new();
    let start = Snapshot::take(&world);
    for step in 0..ON {
        push(&mut world, step);
        steps(&mut world, 1);
        straight.push(bits(&mut world));
    }
    start.restore(&mut world).unwrap();
    let mut last = Snapshot::default();
    for (step, straight) in straight.iter().enumerate() {
        last.take_into(&world);
        // A wrong guess.
        for guess in 0..3 {
            push(&mut world, step + guess + 1);
            steps(&mut world, 1);
        }
        assert_eq!(last.restore(&mut world).unwrap().len(), 0);
        push(&mut world, step);
        steps(&mut world, 1);
        assert_eq!(&bits(&mut world), straight, "step {step}");
    }
}

/// Components of the game stay as they are, and so do its own entities.
#[test]
fn data_of_the_game_stays() {
    let mut world = floor();
    let camera = world.spawn((place(0.0, 9.0), Mesh(1))).id();
    let ball = body(&mut world, Collider::ball(0.5), 0.0, 3.0, Mesh(2));
    let gone = body(&mut world, Collider::ball(0.5), 3.0, 3.0, Mesh(3));
    steps(&mut world, 5);
    let snapshot = Snapshot::take(&world);
    assert!(!snapshot.entities().contains(&camera));
    world.get_mut::<Transform>(camera).unwrap().translation.x = 4.0;
    world.get_mut::<Mesh>(ball).unwrap().0 = 20;
    let lamp = world.spawn(place(1.0, 1.0)).id();
    world.despawn(gone);
    steps(&mut world, 5);
    let map = snapshot.restore(&mut world).unwrap();
    assert_eq!(world.get::<Transform>(camera).unwrap().translation.x, 4.0);
    assert_eq!(world.get(ball), Some(&Mesh(20)));
    assert!(world.get_entity(lamp).is_ok());
    assert!(map.contains_key(&gone));
    assert_eq!(world.get::<Mesh>(map[&gone]), None);
}

/// Edits that no step has seen yet belong to the state, whether the values are the same when the snapshot is restored or not.
#[test]
fn edits_since_the_last_step() {
    let edit = |world: &mut World, bodies: &[Entity]| {
        world
            .entity_mut(bodies[0])
            .insert((Mass(3_000.0), Load::default()));
        world
            .get_mut::<Transform>(bodies[19])
            .unwrap()
            .translation
            .x += 0.2;
        world.get_mut::<ExternalImpulse>(bodies[7]).unwrap().linear = Vec3::Z * 200.0;
        let mut pairs = world.query::<&mut ContactImpulses>();
        for mut impulses in pairs.iter_mut(world) {
            for point in &mut impulses.points {
                point.normal_force *= 0.5;
            }
        }
        world.despawn(bodies[2]);
        brick(world, 0.0, 4.0);
    };
    let rest = || {
        let (mut world, bodies) = scene("wall:5x4");
        steps(&mut world, 100);
        assert!(resting(&mut world) > 20);
        (world, bodies)
    };
    let (mut world, bodies) = rest();
    edit(&mut world, &bodies);
    let straight = go_on(&mut world, NOTHING, &|entity| entity);
    let (mut world, bodies) = rest();
    edit(&mut world, &bodies);
    let snapshot = Snapshot::take(&world);
    for again in 0..2 {
        snapshot.restore(&mut world).unwrap();
        let shown = go_on(&mut world, NOTHING, &|entity| entity);
        assert_same(&format!("edits {again}"), &straight, &shown);
    }
    goes_on_again("edits", &mut world, NOTHING);
}

/// Two snapshots that were taken one after the other are restored in any order.
#[test]
fn back_and_forth() {
    let (mut world, _) = scene("heap:20");
    steps(&mut world, 30);
    let early = Snapshot::take(&world);
    steps(&mut world, 60);
    let late = Snapshot::take(&world);
    let after_late = go_on(&mut world, NOTHING, &|entity| entity);
    early.restore(&mut world).unwrap();
    let after_early = go_on(&mut world, NOTHING, &|entity| entity);
    late.restore(&mut world).unwrap();
    let shown = go_on(&mut world, NOTHING, &|entity| entity);
    assert_same("late", &after_late, &shown);
    early.restore(&mut world).unwrap();
    let shown = go_on(&mut world, NOTHING, &|entity| entity);
    assert_same("early", &after_early, &shown);
}

/// Half of a sleeping wall is out, and its neighbours rest on what is not there.
#[test]
fn a_region_that_is_out() {
    let mut world = floor();
    let place = |i: usize, x: f32| brick_at(x, i);
    let far = (0..4)
        .map(|i| world.spawn(place(i, 20.0)).id())
        .collect::<Vec<_>>();
    let near = (0..4)
        .map(|i| world.spawn(place(i, 0.0)).id())
        .collect::<Vec<_>>();
    steps(&mut world, 240);
    assert_eq!(resting(&mut world), 9);
    let region = streaming::take_out(&mut world, far.iter().copied()).unwrap();
    steps(&mut world, 10);
    let top = near[3];
    let snapshot = Snapshot::take(&world);
    let act = |world: &mut World, here: &dyn Fn(Entity) -> Entity, step: usize| {
        if step == 5 {
            world.get_mut::<Velocity>(here(top)).unwrap().linear.x = 1.0;
        }
    };
    let first = go_on(&mut world, &act, &|entity| entity);
    snapshot.restore(&mut world).unwrap();
    let again = go_on(&mut world, &act, &|entity| entity);
    assert_same("a region is out", &first, &again);
    let left_out = streaming::put_back(&mut world, region);
    assert!(left_out.is_empty(), "{left_out:?}");
    steps(&mut world, 5);
    for body in far {
        assert!(world.get::<Sleeping>(body).unwrap().asleep);
        assert!(world.get::<RigidBodyDisabled>(body).is_none());
    }
}

fn brick_at(x: f32, number: usize) -> impl Bundle {
    let at = place(x, 0.25 + 0.5 * number as f32);
    (RigidBody::Dynamic, Collider::cuboid(1.0, 0.5, 0.5), at)
}
