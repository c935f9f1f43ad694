//! Sensors: who is inside, the messages about it, and that nobody is disturbed by them.

use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::message::Messages;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::body::Inactive;
use drystone::graph::ConstraintGraph;
use drystone::parry3d::query::intersection_test;
use drystone::prelude::*;
use drystone::sensor::sensor_depth;
use fastrand::Rng;
use std::collections::BTreeSet;
use support::Lab;

fn at(x: f32, y: f32, z: f32) -> Transform {
    Transform::from_xyz(x, y, z)
}

fn cube(size: f32) -> Collider {
    Collider::cuboid(size, size, size)
}

/// The bodies inside.
fn inside(lab: &Lab, sensor: Entity) -> Vec<Entity> {
    lab.world
        .get::<SensorOverlaps>(sensor)
        .unwrap()
        .bodies()
        .collect()
}

fn drain<M: Message>(lab: &mut Lab) -> Vec<M> {
    lab.world.resource_mut::<Messages<M>>().drain().collect()
}

/// Numbers of messages: entered, exited.
fn heard(lab: &mut Lab) -> (usize, usize) {
    (
        drain::<SensorEntered>(lab).len(),
        drain::<SensorExited>(lab).len(),
    )
}

#[test]
fn a_body_enters_stays_and_leaves() {
    let mut lab = Lab::new();
    let zone = lab.spawn((cube(2.0), Sensor));
    let ball = lab.spawn((RigidBody::Dynamic, Collider::ball(0.5), at(0.0, 3.0, 0.0)));
    let mut was = false;
    let (mut entered, mut exited) = (0, 0);
    for _ in 0..90 {
        lab.step();
        let y = lab.position(ball).y;
        let is = y.abs() <= 1.5;
        assert_eq!(inside(&lab, zone) == [ball], is, "{y}");
        let (enters, exits) = (
            drain::<SensorEntered>(&mut lab),
            drain::<SensorExited>(&mut lab),
        );
        assert_eq!(
            (enters.len(), exits.len()),
            (usize::from(is && !was), usize::from(!is && was))
        );
        for event in &enters {
            assert_eq!((event.sensor, event.sensor_body), (zone, zone));
            assert_eq!((event.body, event.collider), (ball, ball));
        }
        (entered, exited) = (entered + enters.len(), exited + exits.len());
        was = is;
    }
    assert_eq!((entered, exited), (1, 1));
    // It fell as if the zone were not there.
    assert!(
        lab.world
            .query::<&ContactPair>()
            .iter(&lab.world)
            .next()
            .is_none()
    );
    assert_eq!(lab.world.resource::<ConstraintGraph>().edge_count(), 0);
}

/// Whether the shapes of two bodies overlap, by an exact comparison.
fn overlap(lab: &Lab, one: Entity, other: Entity) -> bool {
    let [a, b] = [one, other].map(|body| {
        let pose = lab.world.get::<Pose>(body).unwrap();
        let shape = lab.world.get::<Collider>(body).unwrap().shape().clone();
        (
            drystone::parry3d::math::Pose::from_parts(pose.position, pose.rotation),
            shape,
        )
    });
    intersection_test(&a.0, &*a.1, &b.0, &*b.1)
        .unwrap()
        .intersecting
}

fn any_shape(rng: &mut Rng) -> Collider {
    match rng.u8(0..5) {
        0 => Collider::ball(0.2 + rng.f32()),
        1 => Collider::cuboid(0.3 + rng.f32(), 0.3 + rng.f32(), 0.3 + rng.f32()),
        2 => Collider::cylinder(0.2 + rng.f32(), 0.5 + rng.f32()),
        3 => Collider::capsule(0.2 + 0.5 * rng.f32(), 0.5 + rng.f32()),
        _ => Collider::wedge(0.5 + rng.f32(), 0.5 + rng.f32(), 1.0).unwrap(),
    }
}

fn any_place(rng: &mut Rng, reach: f32) -> Transform {
    let v = Vec3::new(rng.f32() - 0.5, rng.f32() - 0.2, rng.f32() - 0.5) * reach;
    Transform::from_translation(v).with_rotation(Quat::from_rotation_y(6.0 * rng.f32()))
}

/// Random zones and bodies, edited at random: after every step contents are those of an exact comparison of all with all, and the messages
/// sum up to them.
#[test]
fn contents_are_exact() {
    let mut rng = Rng::with_seed(7);
    let mut lab = Lab::new();
    let ground = lab.ground();
    let mut zones = Vec::new();
    for i in 0..12 {
        let (shape, at) = (any_shape(&mut rng), any_place(&mut rng, 6.0));
        let zone = lab.spawn((shape, Sensor, at));
        if i % 3 == 0 {
            let velocity = Velocity::linear(Vec3::new(0.5, 0.0, 0.2));
            lab.world
                .entity_mut(zone)
                .insert((RigidBody::Kinematic, velocity));
        }
        zones.push(zone);
    }
    let mut bodies = Vec::new();
    for _ in 0..40 {
        let (shape, at) = (any_shape(&mut rng), any_place(&mut rng, 6.0));
        bodies.push(lab.spawn((RigidBody::Dynamic, shape, at)));
    }
    let mut known: BTreeSet<(Entity, Entity)> = BTreeSet::new();
    let mut most = 0;
    for step in 0..240 {
        if step % 9 == 8 {
            let number = rng.usize(0..bodies.len());
            let body = bodies[number];
            match rng.u8(0..5) {
                0 => _ = lab.world.despawn(bodies.swap_remove(number)),
                1 => *lab.world.get_mut(body).unwrap() = any_place(&mut rng, 6.0),
                2 => _ = lab.world.entity_mut(body).insert(any_shape(&mut rng)),
                3 => {
                    let zone = zones[rng.usize(0..zones.len())];
                    lab.world.get_mut::<Transform>(zone).unwrap().translation.x += 0.7;
                }
                _ => {
                    let (shape, at) = (any_shape(&mut rng), any_place(&mut rng, 6.0));
                    bodies.push(lab.spawn((RigidBody::Dynamic, shape, at)));
                }
            }
        }
        lab.step();
        for event in drain::<SensorExited>(&mut lab) {
            assert!(
                known.remove(&(event.sensor, event.body)),
                "{step}: {event:?}"
            );
        }
        for event in drain::<SensorEntered>(&mut lab) {
            assert!(
                known.insert((event.sensor, event.body)),
                "{step}: {event:?}"
            );
        }
        for &zone in &zones {
            let found = inside(&lab, zone);
            let is_static = lab.world.get::<RigidBody>(zone) == Some(&RigidBody::Static);
            let targets = bodies.iter().chain(Some(&ground).filter(|_| !is_static));
            let expected: Vec<Entity> = targets
                .copied()
                .filter(|&body| overlap(&lab, zone, body))
                .collect();
            let sorted = |list: &[Entity]| list.iter().copied().collect::<BTreeSet<_>>();
            assert_eq!(sorted(&found), sorted(&expected), "step {step}");
            let by_events = known
                .iter()
                .filter(|(of, _)| *of == zone)
                .map(|(_, body)| *body);
            assert_eq!(sorted(&found), by_events.collect(), "step {step}");
            most = most.max(found.len());
        }
    }
    assert!(most > 3, "some bodies should meet: {most}");
}

#[test]
fn sleepers_are_detected_and_stay_asleep() {
    let mut lab = Lab::new();
    lab.ground();
    let bricks: Vec<Entity> = (0..4)
        .map(|i| lab.cube(Vec3::new(3.0 * i as f32, 0.5, 0.0)))
        .collect();
    lab.run(2.0);
    let asleep = |lab: &Lab| {
        bricks
            .iter()
            .all(|&brick| lab.world.get::<Inactive>(brick).is_some())
    };
    assert!(asleep(&lab));
    let zone = lab.spawn((Collider::cuboid(4.5, 2.0, 4.5), Sensor));
    lab.step();
    assert_eq!(inside(&lab, zone), bricks[..1]);
    lab.world.get_mut::<Transform>(zone).unwrap().translation.x = 4.5;
    lab.step();
    assert_eq!(inside(&lab, zone), bricks[1..3]);
    lab.world.despawn(bricks[1]);
    lab.step();
    assert_eq!(inside(&lab, zone), bricks[2..3]);
    assert_eq!(heard(&mut lab), (3, 2));
    // Turned off and on.
    lab.world.entity_mut(zone).insert(Disabled);
    lab.step();
    assert_eq!(heard(&mut lab), (0, 1));
    lab.world.entity_mut(zone).remove::<Disabled>();
    lab.step();
    assert_eq!(
        (inside(&lab, zone), heard(&mut lab)),
        (vec![bricks[2]], (1, 0))
    );
    lab.world.despawn(zone);
    lab.step();
    assert_eq!(heard(&mut lab), (0, 1));
    for &brick in [bricks[0], bricks[2], bricks[3]].iter() {
        assert!(lab.world.get::<Inactive>(brick).is_some());
    }
}

/// The foot of a character: a part of a dynamic body, which detects what it stands on.
#[test]
fn a_part_detects_the_ground_and_has_no_mass() {
    let mut lab = Lab::new();
    let ground = lab.ground();
    let zone = lab.spawn((cube(4.0), Sensor));
    let body = lab.spawn((
        RigidBody::Dynamic,
        Collider::capsule(0.3, 1.0),
        at(0.0, 2.0, 0.0),
    ));
    let mass = lab.mass(body);
    let foot = lab.spawn((
        Collider::ball(0.2),
        Sensor,
        at(0.0, -0.75, 0.0),
        ChildOf(body),
    ));
    assert_eq!(lab.mass(body), mass);
    lab.step();
    assert_eq!(
        (lab.mass(body).mass(), inside(&lab, foot)),
        (mass.mass(), vec![])
    );
    lab.run(1.0);
    assert_eq!(inside(&lab, foot), [ground]);
    assert_eq!(
        inside(&lab, zone),
        [body],
        "a zone does not report its floor"
    );
    assert!(
        (lab.position(body).y - 0.8).abs() < 5e-3,
        "{}",
        lab.position(body)
    );
    let event = drain::<SensorEntered>(&mut lab);
    assert!(
        event
            .iter()
            .any(|event| (event.sensor, event.sensor_body, event.body) == (foot, body, ground))
    );
    // Solid, it lifts the body.
    lab.world.entity_mut(foot).remove::<Sensor>();
    lab.run(1.0);
    assert!(lab.position(body).y > 0.9, "{}", lab.position(body));
    assert!(lab.mass(body).mass() > mass.mass());
}

#[test]
fn layers_and_exceptions_are_respected() {
    let layers = |memberships, filters| CollisionLayers {
        memberships,
        filters,
    };
    let mut lab = Lab::new();
    let still = |lab: &mut Lab, x: f32| {
        lab.spawn((
            RigidBody::Dynamic,
            GravityScale(0.0),
            cube(0.2),
            at(x, 0.0, 0.0),
        ))
    };
    let (friend, foe, named) = (
        still(&mut lab, 0.0),
        still(&mut lab, 1.0),
        still(&mut lab, 2.0),
    );
    lab.world.entity_mut(friend).insert(layers(0b01, !0));
    lab.world.entity_mut(foe).insert(layers(0b10, !0));
    let alarm = lab.spawn((
        cube(9.0),
        Sensor,
        layers(!0, 0b10),
        CollisionExceptions::from_iter([named]),
    ));
    lab.step();
    assert_eq!(inside(&lab, alarm), [foe]);
    lab.world.entity_mut(friend).insert(layers(0b10, !0));
    lab.world.entity_mut(alarm).remove::<CollisionExceptions>();
    lab.step();
    assert_eq!(inside(&lab, alarm), [friend, foe, named]);
    // Of the parts, only the one in the layer.
    let part = lab.spawn((
        cube(0.2),
        layers(0b01, !0),
        at(0.0, 1.0, 0.0),
        ChildOf(friend),
    ));
    let other = lab.spawn((
        cube(0.2),
        layers(0b10, !0),
        at(0.0, 2.0, 0.0),
        ChildOf(friend),
    ));
    lab.step();
    let found: Vec<_> = lab
        .world
        .get::<SensorOverlaps>(alarm)
        .unwrap()
        .iter()
        .collect();
    let of = |collider| {
        found
            .iter()
            .any(|overlap| (overlap.body, overlap.collider) == (friend, collider))
    };
    assert!(of(friend) && of(other) && !of(part), "{found:?}");
    // The part leaves alone.
    heard(&mut lab);
    lab.world.get_mut::<Transform>(other).unwrap().translation.y = 20.0;
    lab.step();
    let exits = drain::<SensorExited>(&mut lab);
    assert_eq!(exits.len(), 1);
    assert_eq!((exits[0].body, exits[0].collider), (friend, other));
    assert!(
        lab.world
            .get::<SensorOverlaps>(alarm)
            .unwrap()
            .contains(friend)
    );
    // A part that is added or taken does not disturb the others.
    lab.world.despawn(part);
    lab.step();
    assert_eq!(heard(&mut lab), (0, 0));
}

#[test]
fn a_sensor_touches_nothing() {
    let mut lab = Lab::new();
    let ground = lab.ground();
    let only = CollisionLayers {
        memberships: 1,
        filters: 1,
    };
    lab.world.entity_mut(ground).insert(only);
    let ghost = lab.spawn((RigidBody::Dynamic, cube(1.0), Sensor, at(0.0, 1.0, 0.0)));
    let mass = lab.mass(ghost).mass();
    assert!((mass - 1000.0).abs() < 1e-2, "{mass}");
    let other = lab.spawn((RigidBody::Kinematic, cube(1.0), Sensor, at(0.0, 0.0, 0.0)));
    lab.run(1.0);
    assert!(lab.position(ghost).y < -3.0);
    assert_eq!(
        inside(&lab, other).len(),
        1,
        "it detects the ground, and not the other sensor"
    );
    let probe = spatial_query(&mut lab.world, |query| {
        let below = Ray3d::new(Vec3::new(0.0, 5.0, 0.0), Dir3::NEG_Y);
        query.cast_ray(below, 4.9, &QueryFilter::default())
    });
    assert_eq!(probe, Ok(None));
    // An abyss.
    let abyss = lab.spawn((Collider::half_space(Vec3::Y), Sensor, at(0.0, -20.0, 0.0)));
    let ball = lab.spawn((
        RigidBody::Dynamic,
        Collider::ball(0.5),
        at(0.0, -15.0, 0.0),
        CollisionLayers {
            memberships: 2,
            filters: 2,
        },
    ));
    lab.run(0.5);
    assert!(inside(&lab, abyss).is_empty());
    lab.run(1.0);
    assert_eq!(inside(&lab, abyss), [ball]);
    // Solid from now on: the ground holds it back.
    lab.world.entity_mut(other).remove::<Sensor>();
    lab.step();
    assert!(lab.world.get::<Sensor>(other).is_none());
    let brick = lab.cube(Vec3::new(0.0, 1.05, 0.0));
    lab.run(1.0);
    assert!((lab.position(brick).y - 1.0).abs() < 5e-3);
}

#[derive(Resource, Default)]
struct Log(Vec<(&'static str, Entity)>);

#[test]
fn observers_of_the_sensor_are_triggered() {
    let mut lab = Lab::new();
    lab.world.init_resource::<Log>();
    let zone = lab.spawn((cube(1.0), Sensor));
    let silent = lab.spawn((cube(1.0), Sensor));
    lab.world
        .entity_mut(zone)
        .observe(|on: On<SensorEntered>, mut log: ResMut<Log>| log.0.push(("in", on.body)));
    lab.world
        .entity_mut(zone)
        .observe(|on: On<SensorExited>, mut log: ResMut<Log>| log.0.push(("out", on.body)));
    let ball = lab.spawn((RigidBody::Dynamic, Collider::ball(0.2), at(0.0, 2.0, 0.0)));
    lab.run(2.0);
    assert_eq!(lab.world.resource::<Log>().0, [("in", ball), ("out", ball)]);
    assert_eq!(heard(&mut lab), (4 - 2, 2));
    let _ = silent;
}

/// A body with invalid input is out of the simulation, and so out of the zone.
#[test]
fn a_quarantined_body_has_left() {
    let mut lab = Lab::new();
    let zone = lab.spawn((cube(4.0), Sensor));
    let ball = lab.spawn((RigidBody::Dynamic, GravityScale(0.0), Collider::ball(0.2)));
    lab.step();
    assert_eq!(inside(&lab, zone), [ball]);
    lab.world.entity_mut(ball).insert(Density(-1.0));
    lab.step();
    assert!(inside(&lab, zone).is_empty());
    lab.world.entity_mut(ball).insert(Density(1.0));
    lab.step();
    lab.step();
    assert_eq!(inside(&lab, zone), [ball]);
    assert_eq!(heard(&mut lab), (2, 1));
}

#[test]
fn sensors_tell_how_deep_a_body_is_inside() {
    let mut lab = Lab::new();
    let pool = lab.spawn((Collider::cuboid(4.0, 2.0, 4.0), Sensor, at(0.0, 0.0, 0.0)));
    let float = |x: f32, y: f32| {
        (
            RigidBody::Dynamic,
            GravityScale(0.0),
            cube(1.0),
            at(x, y, 0.0),
        )
    };
    let places = [(-1.5, 0.3), (-0.2, 1.4), (0.9, 1.6)];
    let [deep, shallow, outside] = places.map(|(x, y)| lab.spawn(float(x, y)));
    // A mast that stands out of the pool, on a hull that is all inside.
    let mast = lab.spawn((Collider::cuboid(0.1, 3.0, 0.1), at(0.0, 1.5, 0.0)));
    let ship = lab.spawn((RigidBody::Kinematic, cube(0.5), at(1.0, -0.2, 1.0)));
    lab.world.entity_mut(ship).add_child(mast);
    lab.step();
    let mut depth = |collider: Entity| sensor_depth(&mut lab.world, pool, collider);
    let near = |found: Option<f32>, depth: f32| (found.unwrap() - depth).abs() < 1e-3;
    // Sideways: from its inner face to the wall.
    assert!(near(depth(deep), 1.0), "{:?}", depth(deep));
    assert!(near(depth(shallow), 0.1));
    assert_eq!(depth(outside), None);
    assert!(near(depth(ship), 1.05), "{:?}", depth(ship));
    assert!(near(depth(mast), 1.05), "{:?}", depth(mast));
}
