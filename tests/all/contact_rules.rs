//! Rules of contacts that users set: hooks, moving surfaces, layers by name; and how they learn of contacts.

use bevy_ecs::message::Messages;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::body::*;
use drystone::collider::*;
use drystone::collision_layers;
use drystone::contact::*;
use drystone::settings::{Preset, SolverSettings};
use drystone::solver::Pgs;
use glam::{Quat, Vec3};
use support::{G, Lab, assert_near};

collision_layers! {
    enum Layer { Ground, Brick, Ghost }
}

#[test]
fn layers_have_names() {
    let mut lab = Lab::new();
    let ground = lab.ground();
    lab.world
        .entity_mut(ground)
        .insert(CollisionLayers::new(Layer::Ground, LayerMask::ALL));
    let brick = lab.cube(Vec3::Y * 0.5);
    lab.world.entity_mut(brick).insert(CollisionLayers::new(
        Layer::Brick,
        [Layer::Ground, Layer::Brick],
    ));
    let ghost = lab.cube(Vec3::new(0.2, 0.5, 0.0));
    lab.world.entity_mut(ghost).insert(CollisionLayers::new(
        [Layer::Ghost],
        LayerMask::from(Layer::Ground) | Layer::Ghost.into(),
    ));
    lab.run(1.0);
    assert!(lab.position(ghost).distance(Vec3::new(0.2, 0.5, 0.0)) < 1e-3);
    assert!(lab.position(brick).distance(Vec3::Y * 0.5) < 1e-3);
    assert_eq!(!LayerMask::ALL, LayerMask::NONE);
}

fn labs() -> Vec<Lab> {
    let mut points = Lab::new();
    points.world.insert_resource(SolverSettings::new(Pgs {
        iterations: 40,
        ..Default::default()
    }));
    vec![Lab::new(), points, Lab::with_preset(Preset::Default)]
}

#[test]
fn a_belt_carries_what_lies_on_it() {
    for mut lab in labs() {
        let belt = lab.spawn((
            RigidBody::Static,
            Collider::cuboid(40.0, 1.0, 2.0),
            Friction::new(0.5),
            SurfaceVelocity(Vec3::new(2.0, 3.0, 0.0)),
        ));
        let parcels: Vec<Entity> = (0..4)
            .map(|i| {
                lab.body(
                    Collider::cuboid(0.5, 0.5, 0.5),
                    Vec3::new(-8.0 + 2.0 * i as f32, 0.75, 0.0),
                )
            })
            .collect();
        let on_top = lab.body(Collider::cuboid(0.4, 0.4, 0.4), Vec3::new(-8.0, 1.2, 0.0));
        lab.step();
        lab.run(0.2 - lab.dt);
        // Friction accelerates it by μ g.
        assert_near(
            lab.velocity(parcels[3]).linear.x,
            0.5 * G * 0.2,
            0.05,
            "μ g t",
        );
        lab.run(1.8);
        for &parcel in &parcels {
            let velocity = lab.velocity(parcel);
            assert!(
                (velocity.linear - Vec3::X * 2.0).length() < 1e-2,
                "{velocity:?}"
            );
            assert!((lab.position(parcel).y - 0.75).abs() < 1e-3);
        }
        assert!((lab.velocity(on_top).linear.x - 2.0).abs() < 1e-2);
        // Switched off, it brakes them; switched on again, it wakes them.
        lab.world.entity_mut(belt).remove::<SurfaceVelocity>();
        lab.run(3.0);
        assert!(lab.velocity(parcels[0]).linear.length() < 1e-3);
        assert!(lab.world.get::<Sleeping>(parcels[0]).unwrap().asleep);
        lab.world
            .entity_mut(belt)
            .insert(SurfaceVelocity(Vec3::Z * -1.0));
        lab.run(0.5);
        assert!(
            (lab.velocity(parcels[0]).linear.z + 1.0).abs() < 1e-2,
            "{:?}",
            lab.velocity(parcels[0])
        );
    }
}

/// A vehicle on tracks drives itself, and what it stands on gets the opposite.
#[test]
fn a_moving_surface_drives_its_body() {
    let mut lab = Lab::new();
    lab.ground();
    let plank = lab.body(Collider::cuboid(20.0, 0.2, 2.0), Vec3::Y * 0.1);
    lab.world
        .entity_mut(plank)
        .insert(Friction::new(0.0).with_rule(CombineRule::Min));
    let vehicle = lab.body(Collider::cuboid(1.0, 0.5, 0.8), Vec3::Y * 0.45);
    lab.world.entity_mut(vehicle).insert((
        SurfaceVelocity(Vec3::X * -1.0),
        Friction::new(0.8).with_rule(CombineRule::Max),
    ));
    lab.run(2.0);
    let (v, p) = (lab.velocity(vehicle).linear.x, lab.velocity(plank).linear.x);
    assert_near(v - p, 1.0, 0.01, "against each other");
    let momentum = v / lab.mass(vehicle).inverse_mass + p / lab.mass(plank).inverse_mass;
    assert!(
        momentum.abs() < 0.02 * v / lab.mass(vehicle).inverse_mass,
        "{momentum}"
    );
}

/// Reads the bodies' numbers, and does what they ask for.
struct Numbered;

impl ContactHook for Numbered {
    fn filter_pair(&self, bodies: [&BodyState; 2]) -> bool {
        bodies
            .iter()
            .all(|body| body.properties.hooks.user_data != 1)
    }

    fn modify_contacts(&self, contacts: &mut ContactModification) {
        for body in contacts.bodies() {
            match body.properties.hooks.user_data {
                2 => contacts.friction = 0.0,
                3 => contacts.restitution = 1.0,
                4 => contacts.surface_velocity = Vec3::X,
                5 => contacts.retain(|point| point.position.x > body.center.x),
                6 => contacts.friction = f32::NAN,
                _ => (),
            }
        }
    }
}

#[test]
fn hooks_filter_and_modify() {
    for mut lab in labs() {
        lab.world.insert_resource(ContactHooks::new(Numbered));
        lab.slope(0.3, 0.8);
        let turned = Quat::from_rotation_z(-0.3);
        let spawn = |lab: &mut Lab, number: u64| {
            let at = turned * Vec3::new(0.0, 0.5, 3.0 * number as f32);
            let cube = lab.cube(at);
            lab.world.get_mut::<Transform>(cube).unwrap().rotation = turned;
            lab.world.entity_mut(cube).insert((
                Friction::new(0.8),
                ActiveContactHooks::ALL.with_user_data(number),
            ));
            cube
        };
        let cubes: Vec<Entity> = (0..7).map(|number| spawn(&mut lab, number)).collect();
        lab.run(1.0);
        let x = |number: usize| lab.position(cubes[number]).x;
        let start = (turned * Vec3::Y * 0.5).x;
        assert!(
            (x(0) - start).abs() < 2e-3,
            "a hook that does nothing changes nothing"
        );
        assert!(lab.position(cubes[1]).y < -2.0, "filtered");
        assert_near(
            (x(2) - start) / 0.3f32.cos(),
            0.5 * G * 0.3f32.sin(),
            0.05,
            "without friction",
        );
        assert!(
            lab.velocity(cubes[4]).linear.length() > 0.5,
            "carried along"
        );
        let tilted = lab.pose(cubes[5]).rotation.angle_between(turned);
        assert!(tilted > 0.2, "it stands on half of its points: {tilted}");
        assert!((x(6) - start).abs() < 2e-3, "an invalid value is ignored");
        assert_eq!(lab.errors(), []);
        // Without hooks all is as usual.
        lab.world.remove_resource::<ContactHooks>();
        lab.run(2.0);
        assert!(
            lab.velocity(cubes[2]).linear.length() < 0.1,
            "{:?}",
            lab.velocity(cubes[2])
        );
    }
}

struct OneWay;

impl ContactHook for OneWay {
    fn modify_contacts(&self, contacts: &mut ContactModification) {
        contacts.one_way(Vec3::Y);
    }
}

#[test]
fn a_one_way_platform_lets_bodies_through_from_below() {
    for mut lab in labs() {
        lab.world.insert_resource(ContactHooks::new(OneWay));
        lab.spawn((
            RigidBody::Static,
            Collider::cuboid(10.0, 0.3, 10.0),
            ActiveContactHooks::MODIFY_CONTACTS,
        ));
        let mut jumpers = Vec::new();
        for i in 0..4 {
            let shape = if i % 2 == 0 {
                Collider::ball(0.3)
            } else {
                Collider::cuboid(0.6, 0.6, 0.6)
            };
            let jumper = lab.body(shape, Vec3::new(2.0 * i as f32 - 3.0, -1.0, 0.0));
            lab.set_velocity(jumper, Vec3::Y * (6.5 + 0.7 * i as f32), Vec3::ZERO);
            jumpers.push(jumper);
        }
        let faller = lab.cube(Vec3::new(0.0, 4.0, 3.0));
        let slow = lab.body(Collider::ball(0.3), Vec3::new(4.0, -1.0, 3.0));
        lab.set_velocity(slow, Vec3::Y * 3.5, Vec3::ZERO);
        lab.run(4.0);
        for jumper in jumpers {
            assert!(
                (lab.position(jumper).y - 0.45).abs() < 5e-3,
                "{}",
                lab.position(jumper)
            );
        }
        assert!((lab.position(faller).y - 0.65).abs() < 5e-3);
        assert!(lab.position(slow).y < -2.0, "it did not come up far enough");
    }
}

#[test]
fn messages_say_where_bodies_hit() {
    let mut lab = Lab::new();
    let ground = lab.ground();
    let ball = lab.body(Collider::ball(0.5), Vec3::new(2.0, 1.0, 1.0));
    lab.world
        .entity_mut(ball)
        .insert((ContactEvents, CollidingEntities::default()));
    lab.set_velocity(ball, Vec3::NEG_Y * 5.0, Vec3::ZERO);
    #[derive(Resource, Default)]
    struct Heard(Vec<ContactStarted>);
    lab.world.init_resource::<Heard>();
    lab.world
        .entity_mut(ball)
        .observe(|hit: On<ContactStarted>, mut heard: ResMut<Heard>| heard.0.push(*hit));
    lab.run(0.3);
    let told: Vec<ContactStarted> = lab
        .world
        .resource_mut::<Messages<ContactStarted>>()
        .drain()
        .collect();
    assert_eq!(told.len(), 1);
    assert_eq!(
        (told[0].body, told[0].other, told[0].normal),
        (ground, ball, Vec3::NEG_Y)
    );
    assert!(
        told[0].point.distance(Vec3::new(2.0, 0.0, 1.0)) < 0.05,
        "{:?}",
        told[0]
    );
    assert_eq!(lab.world.resource::<Heard>().0[0].normal, Vec3::Y);
    assert!(
        lab.world
            .get::<CollidingEntities>(ball)
            .unwrap()
            .contains(&ground)
    );
    // They hold while the two sleep, and end when one is gone.
    lab.run(3.0);
    assert!(lab.world.get::<Sleeping>(ball).unwrap().asleep);
    assert_eq!(lab.world.get::<CollidingEntities>(ball).unwrap().len(), 1);
    lab.world.despawn(ground);
    lab.run(0.1);
    assert!(lab.world.get::<CollidingEntities>(ball).unwrap().is_empty());
}
