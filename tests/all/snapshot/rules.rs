//! Errors, change detection, the memory of a snapshot, and the search for differences.

use super::*;
use bevy_ecs::entity::EntityHashMap;
use drystone::snapshot::SnapshotError;

#[test]
fn an_empty_snapshot_or_a_world_without_plugins_is_an_error() {
    let (mut world, _) = scene("wall:3x2");
    steps(&mut world, 5);
    let before = Snapshot::take(&world);
    let error = Snapshot::default().restore(&mut world);
    assert_eq!(error, Err(SnapshotError::Empty));
    let none = Snapshot::take(&World::new()).restore(&mut world);
    assert_eq!(none, Err(SnapshotError::Empty));
    let same = Snapshot::take(&world);
    assert_eq!(
        before.first_difference(&same, &EntityHashMap::default()),
        None
    );

    let mut app = App::new();
    app.add_plugins(DrystonePlugins::default());
    let error = before.restore(app.world_mut()).unwrap_err();
    assert!(error.to_string().contains("CollapseSettings"), "{error}");
    let mut bodies = app.world_mut().query::<&RigidBody>();
    assert_eq!(bodies.iter(app.world()).count(), 0);
}

/// A restored component is marked as changed if its value differs.
#[test]
fn only_what_differs_is_marked_as_changed() {
    let (mut world, bodies) = scene("wall:5x4");
    let ball = body(&mut world, Collider::ball(0.5), 20.0, 30.0, ());
    steps(&mut world, 120);
    assert!(resting(&mut world) > 20);
    let snapshot = Snapshot::take(&world);
    steps(&mut world, 10);
    let written = |world: &mut World| {
        let mut moved = world.query_filtered::<Entity, Changed<Transform>>();
        let moved: Vec<Entity> = moved.iter(world).collect();
        world.clear_trackers();
        moved
    };
    world.clear_trackers();
    snapshot.restore(&mut world).unwrap();
    assert_eq!(written(&mut world), [ball]);
    world.get_mut::<Transform>(bodies[4]).unwrap().translation.y += 1.0;
    world.clear_trackers();
    snapshot.restore(&mut world).unwrap();
    // The ball was written by the last step that the snapshot has seen.
    let written = written(&mut world);
    assert!(
        written.contains(&bodies[4]) && written.len() <= 2,
        "{written:?}"
    );
}

/// The memory of a snapshot is used again for one of another time, of another world, and of fewer bodies.
#[test]
fn a_snapshot_is_taken_into_another() {
    let (mut heap, _) = scene("heap:20");
    steps(&mut heap, 30);
    let (mut wall, _) = scene("wall:4x3");
    steps(&mut wall, 60);
    let none = EntityHashMap::default();
    let mut snapshot = Snapshot::default();
    for world in [&heap, &wall, &heap] {
        snapshot.take_into(world);
        let fresh = Snapshot::take(world);
        assert_eq!(snapshot.first_difference(&fresh, &none), None);
        assert_eq!(fresh.first_difference(&snapshot.clone(), &none), None);
    }
}

#[test]
fn two_runs_do_not_differ() {
    let run = || {
        let (mut world, _) = scene("heap:15");
        steps(&mut world, 90);
        Snapshot::take(&world)
    };
    assert_eq!(
        run().first_difference(&run(), &EntityHashMap::default()),
        None
    );
}

/// The name of a field of each kind that was changed.
#[test]
fn the_first_difference_is_named() {
    let (mut world, bodies) = scene("wall:3x2");
    steps(&mut world, 20);
    let before = Snapshot::take(&world);
    let none = EntityHashMap::default();
    let differs = |world: &World| {
        let now = Snapshot::take(world);
        let found = before.first_difference(&now, &none).unwrap();
        (found.entity, found.of, found.field)
    };
    let pairs = &mut world.query::<(Entity, &mut ContactImpulses)>();
    let (pair, mut impulses) = pairs.iter_mut(&mut world).next().unwrap();
    impulses.points[1].rest_force += 1.0;
    let found = (
        Some(pair),
        std::any::type_name::<ContactImpulses>(),
        "points[1].rest_force".to_owned(),
    );
    assert_eq!(differs(&world), found);
    world.resource_mut::<Gravity>().0.y = -1.0;
    assert_eq!(differs(&world), found);
    world.get_mut::<Velocity>(bodies[2]).unwrap().linear.z = -0.0;
    let (entity, of, field) = differs(&world);
    assert_eq!((entity, of), (Some(bodies[2]), "drystone::body::Velocity"));
    assert_eq!(field, "linear.2");
    before.restore(&mut world).unwrap();
    world.resource_mut::<Gravity>().0.y = -1.0;
    let (entity, of, field) = differs(&world);
    assert!(entity.is_none() && of.ends_with("Gravity"), "{of}");
    assert_eq!(field, "1");
    before.restore(&mut world).unwrap();
    let new = brick(&mut world, 9.0, 0.3);
    let now = Snapshot::take(&world);
    assert!(now.entities().contains(&new));
    let found = now.first_difference(&before, &none).unwrap();
    assert_eq!((found.entity, found.values[1].clone()), (Some(new), None));
}
