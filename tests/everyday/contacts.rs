//! Contact events for bodies that begin to listen later.

use super::*;
use drystone::contact::ContactForceEvents;

/// What a body heard: who began to touch it (+1) or ceased (−1).
#[derive(Resource, Default)]
struct Heard(Vec<(Entity, Entity, i32)>);

fn world() -> (App, Entity, Entity) {
    let mut app = app();
    let world = app.world_mut();
    world.init_resource::<Heard>();
    let ground = (RigidBody::Static, Collider::half_space(Vec3::Y));
    let ground = world.spawn(ground).id();
    world.add_observer(move |event: On<ContactStarted>, mut heard: ResMut<Heard>| {
        // From the other body to this one.
        let up = if event.body == ground { -1.0 } else { 1.0 };
        assert!((event.normal - up * Vec3::Y).length() < 0.01);
        // As far as it falls in a step.
        assert!(event.point.y.abs() < 0.15 && event.impulse >= 0.0);
        assert_eq!(event.colliders, [event.body, event.other]);
        heard.0.push((event.body, event.other, 1));
    });
    world.add_observer(|event: On<ContactEnded>, mut heard: ResMut<Heard>| {
        heard.0.push((event.body, event.other, -1))
    });
    let body = world
        .spawn((RigidBody::Dynamic, cube(1.0), at(0.0, 0.5, 0.0)))
        .id();
    (app, ground, body)
}

fn heard(world: &mut World) -> Vec<(Entity, Entity, i32)> {
    std::mem::take(&mut world.resource_mut::<Heard>().0)
}

#[test]
fn a_contact_that_exists_already_starts_and_ends_for_who_listens_later() {
    // Awake, asleep, and asleep with the marker for inactive bodies.
    for before in [10, 60, 200] {
        for waking in [Waking::Islands, SleepSettings::default().waking] {
            for on_ground in [false, true] {
                let (mut app, ground, body) = world();
                let world = app.world_mut();
                world.resource_mut::<SleepSettings>().waking = waking;
                steps(world, before);
                let (own, other) = if on_ground {
                    (ground, body)
                } else {
                    (body, ground)
                };
                world.entity_mut(own).insert(ContactEvents);
                steps(world, 5);
                assert_eq!(heard(world), [(own, other, 1)], "{before}, {waking:?}");
                // Another component tells nothing anew.
                world
                    .entity_mut(own)
                    .insert((ContactForceEvents::default(), Friction::new(0.7)));
                steps(world, 60);
                assert_eq!(heard(world), []);
                world.get_mut::<Transform>(body).unwrap().translation.y += 3.0;
                steps(world, 2);
                assert_eq!(heard(world), [(own, other, -1)], "{before}, {waking:?}");
                steps(world, 120);
                assert_eq!(heard(world), [(own, other, 1)], "{before}, {waking:?}");
            }
        }
    }
}

/// A contact that ends in the step in which somebody begins to listen.
#[test]
fn whoever_hears_the_end_has_heard_the_start() {
    let (mut app, ground, body) = world();
    let world = app.world_mut();
    steps(world, 30);
    world.entity_mut(body).insert(ContactEvents);
    world.get_mut::<Transform>(body).unwrap().translation.y += 3.0;
    steps(world, 2);
    assert!(
        matches!(heard(world)[..], [] | [(_, _, 1), (_, _, -1)]),
        "{ground}"
    );
}

#[test]
fn listeners_get_each_event_once_from_the_beginning_or_again() {
    let (mut app, ground, body) = world();
    let world = app.world_mut();
    world.entity_mut(body).insert(ContactEvents);
    steps(world, 30);
    assert_eq!(heard(world), [(body, ground, 1)]);
    world.entity_mut(body).remove::<ContactEvents>();
    steps(world, 5);
    world.get_mut::<Transform>(body).unwrap().translation.y += 1.0;
    steps(world, 2);
    assert_eq!(heard(world), []);
    world.entity_mut(body).insert(ContactEvents);
    steps(world, 120);
    assert_eq!(heard(world), [(body, ground, 1)]);
}

/// A world that goes on from a snapshot tells nothing anew.
#[test]
fn a_snapshot_starts_no_contact_again() {
    let (mut app, _, body) = world();
    let world = app.world_mut();
    steps(world, 10);
    world.entity_mut(body).insert(ContactEvents);
    steps(world, 10);
    assert_eq!(heard(world).len(), 1);
    let snapshot = drystone::snapshot::Snapshot::take(world);
    snapshot.restore(world).unwrap();
    steps(world, 10);
    assert_eq!(heard(world), []);
    let (mut other, ..) = self::world();
    let other = other.world_mut();
    drystone::snapshot::Snapshot::from_bytes(&snapshot.to_bytes().unwrap())
        .unwrap()
        .restore(other)
        .unwrap();
    steps(other, 10);
    assert_eq!(heard(other), []);
}
