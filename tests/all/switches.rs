//! Bodies and colliders that are switched off and on; physics that is paused, slowed down or taken step by step.

use bevy_app::App;
use bevy_ecs::prelude::*;
use bevy_time::{Fixed, Time, TimePlugin, TimeUpdateStrategy};
use bevy_transform::components::Transform;
use drystone::DrystonePlugins;
use drystone::body::*;
use drystone::collider::Collider;
use drystone::contact::{CollidingEntities, contacts};
use drystone::query::{QueryFilter, spatial_query};
use drystone::settings::PhysicsTime;
use glam::{Quat, Vec3};
use std::time::Duration;
use support::{G, Lab, assert_near};

fn stack(lab: &mut Lab) -> [Entity; 3] {
    lab.ground();
    [0.5, 1.5, 2.5].map(|y| lab.cube(Vec3::Y * y))
}

#[test]
fn a_disabled_body_comes_back_as_it_was() {
    for asleep in [false, true] {
        let mut lab = Lab::new();
        let [_, middle, top] = stack(&mut lab);
        lab.run(if asleep { 3.0 } else { 0.2 });
        let is_asleep = |lab: &Lab, body| lab.world.get::<Sleeping>(body).unwrap().asleep;
        assert_eq!(is_asleep(&lab, top), asleep);
        let count = lab.world.entity(middle).archetype().components().len();
        let (pose, mass) = (lab.pose(middle), lab.mass(middle));
        lab.world.entity_mut(middle).insert(RigidBodyDisabled);
        lab.run(1.5);
        assert!(
            (lab.position(top).y - 1.5).abs() < 1e-3,
            "it has fallen: {asleep}"
        );
        assert_eq!(lab.pose(middle), pose);
        let found = spatial_query(&mut lab.world, |query| {
            query.bodies_at(Vec3::new(0.0, 1.9, 0.0), &QueryFilter::default())
        });
        assert!(!found.unwrap().contains(&middle));
        assert!(contacts(&mut lab.world, |contacts| contacts
            .on(middle)
            .is_err()));
        // Moved while it is off, it comes back there.
        lab.world
            .get_mut::<Transform>(middle)
            .unwrap()
            .translation
            .x = 3.0;
        lab.world.entity_mut(middle).remove::<RigidBodyDisabled>();
        lab.run(0.1);
        assert_eq!(lab.position(middle).x, 3.0);
        assert_eq!(lab.mass(middle), mass);
        lab.run(1.0);
        assert!((lab.position(middle).y - 0.5).abs() < 1e-3);
        let now = lab.world.entity(middle).archetype().components().len();
        assert!(now.abs_diff(count) <= 1, "only `Inactive` comes and goes");
        assert_eq!(lab.errors(), []);
    }
}

#[test]
fn a_body_in_flight_goes_on_where_it_was_stopped() {
    let mut lab = Lab::new();
    let ball = lab.body(Collider::ball(0.5), Vec3::Y * 50.0);
    lab.set_velocity(ball, Vec3::X * 3.0, Vec3::Y);
    lab.run(0.5);
    let (pose, velocity) = (lab.pose(ball), lab.velocity(ball));
    lab.world.entity_mut(ball).insert(RigidBodyDisabled);
    lab.run(1.0);
    assert_eq!((lab.pose(ball), lab.velocity(ball)), (pose, velocity));
    lab.world.entity_mut(ball).remove::<RigidBodyDisabled>();
    lab.run(0.5);
    assert_near(
        pose.position.y - lab.position(ball).y,
        0.5 * G * 0.75,
        0.01,
        "fall",
    );
}

#[test]
fn a_world_with_a_disabled_body_is_the_same_as_without_it() {
    let run = |disabled: bool| {
        let mut lab = Lab::new();
        let bodies = stack(&mut lab);
        let odd = disabled.then(|| lab.cube(Vec3::new(0.3, 1.0, 0.2)));
        if let Some(odd) = odd {
            lab.world.entity_mut(odd).insert(RigidBodyDisabled);
        }
        lab.set_velocity(bodies[2], Vec3::X * 0.5, Vec3::Y);
        lab.run(1.0);
        lab.bits()
    };
    assert_eq!(run(true), run(false));
}

#[test]
fn a_disabled_collider_touches_nothing_and_keeps_its_mass() {
    let mut lab = Lab::new();
    let [bottom, middle, top] = stack(&mut lab);
    lab.run(3.0);
    let mass = lab.mass(middle);
    lab.world.entity_mut(middle).insert(ColliderDisabled);
    lab.run(0.3);
    assert_eq!(lab.mass(middle), mass);
    assert!(lab.position(middle).y < 1.2, "it falls through");
    assert!(lab.position(top).y < 2.3, "what it bore falls");
    assert!((lab.position(bottom).y - 0.5).abs() < 1e-3);
    lab.world.entity_mut(middle).remove::<ColliderDisabled>();
    lab.run(0.1);
    assert!(lab.world.get::<Quarantined>(middle).is_none());
}

fn app() -> App {
    let mut app = App::new();
    app.add_plugins((TimePlugin, DrystonePlugins::default()));
    let frame = Duration::from_secs_f64(1.0 / 64.0);
    app.insert_resource(TimeUpdateStrategy::ManualDuration(frame));
    app.insert_resource(Time::<Fixed>::from_duration(frame));
    app.finish();
    app.update();
    app
}

fn speed(app: &App, body: Entity) -> f32 {
    -app.world().get::<Velocity>(body).unwrap().linear.y
}

#[test]
fn physics_is_paused_slowed_down_and_stepped() {
    let mut app = app();
    let ball = app
        .world_mut()
        .spawn((RigidBody::Dynamic, Collider::ball(0.5)))
        .id();
    let frames = |app: &mut App, count: usize| (0..count).for_each(|_| app.update());
    let time = |app: &mut App, change: fn(&mut PhysicsTime)| {
        change(&mut app.world_mut().resource_mut::<PhysicsTime>());
    };
    let dt = 1.0 / 64.0;
    frames(&mut app, 8);
    assert_near(speed(&app, ball), 8.0 * dt * G, 1e-4, "running");
    time(&mut app, PhysicsTime::pause);
    frames(&mut app, 8);
    assert_near(speed(&app, ball), 8.0 * dt * G, 1e-4, "paused");
    // The app goes on, and what is put there is found.
    let wall = app
        .world_mut()
        .spawn((
            RigidBody::Static,
            Collider::cuboid(1.0, 1.0, 1.0),
            Transform::from_xyz(9.0, 0.0, 0.0),
        ))
        .id();
    frames(&mut app, 1);
    let found = spatial_query(app.world_mut(), |query| {
        query.bodies_at(Vec3::X * 9.0, &QueryFilter::default())
    });
    assert_eq!(found.unwrap(), [wall]);
    time(&mut app, |time| time.request_steps(3));
    frames(&mut app, 8);
    assert_near(speed(&app, ball), 11.0 * dt * G, 1e-4, "three steps");
    time(&mut app, |time| {
        time.unpause();
        time.set_relative_speed(0.25).unwrap();
    });
    frames(&mut app, 8);
    assert_near(speed(&app, ball), 13.0 * dt * G, 1e-4, "a quarter");
    time(&mut app, |time| time.set_relative_speed(0.0).unwrap());
    frames(&mut app, 8);
    assert_near(speed(&app, ball), 13.0 * dt * G, 1e-4, "none");
}

/// Slow motion does not let a stack sink or creep.
#[test]
fn a_stack_stands_through_slow_motion() {
    let mut app = app();
    app.world_mut()
        .spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
    let brick = |y: f32| {
        let at = Transform::from_xyz(0.0, y, 0.0).with_rotation(Quat::from_rotation_y(y));
        (
            RigidBody::Dynamic,
            Collider::cuboid(1.0, 0.5, 0.5),
            at,
            CollidingEntities::default(),
        )
    };
    let bricks: Vec<Entity> = (0..8)
        .map(|i| app.world_mut().spawn(brick(0.25 + 0.5 * i as f32)).id())
        .collect();
    for speed in [1.0, 0.1, 2.0, 0.01, 1.0] {
        app.world_mut()
            .resource_mut::<PhysicsTime>()
            .set_relative_speed(speed)
            .unwrap();
        (0..60).for_each(|_| app.update());
    }
    let top = app.world().get::<Transform>(bricks[7]).unwrap().translation;
    assert!(top.distance(Vec3::Y * 3.75) < 1e-3, "{top}");
    assert_eq!(
        app.world()
            .get::<CollidingEntities>(bricks[3])
            .unwrap()
            .len(),
        2
    );
}
