//! Queries before the next step see bodies that were spawned, moved or changed since the last step.

use bevy_app::{App, Update};
use bevy_ecs::hierarchy::ChildOf;
use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemState;
use bevy_time::{Fixed, Time, TimePlugin, TimeUpdateStrategy, Virtual};
use bevy_transform::components::Transform;
use drystone::DrystonePlugins;
use drystone::body::{
    CenterOfMass, Density, ExternalForce, Mass, Pose, Quarantined, RigidBody, Velocity,
};
use drystone::collider::{Collider, CollisionLayers};
use drystone::query::{Dir3, QueryFilter, Ray3d, SpatialQuery, spatial_query};
use glam::Vec3;
use std::time::Duration;
use support::*;

fn brick() -> Collider {
    Collider::cuboid(1.0, 0.5, 0.5)
}

fn ask<R>(world: &mut World, what: impl FnOnce(SpatialQuery) -> R) -> R {
    let mut state = SystemState::<SpatialQuery>::new(world);
    what(state.get(world).expect("drystone is there"))
}

/// The body that a ray from above hits at this place.
fn below(world: &mut World, x: f32, z: f32) -> Option<Entity> {
    let down = Ray3d::new(Vec3::new(x, 50.0, z), Dir3::NEG_Y);
    let hit = ask(world, |query| {
        query.cast_ray(down, 100.0, &QueryFilter::default())
    });
    hit.expect("a ray").map(|hit| hit.entity)
}

fn fits(world: &mut World, position: Vec3) -> bool {
    let pose = Pose {
        position,
        ..Pose::default()
    };
    let fits = ask(world, |query| {
        query.fits(&brick(), pose, 1e-3, &QueryFilter::default())
    });
    fits.expect("a brick")
}

fn refresh(world: &mut World) {
    drystone::refresh(world);
}

#[test]
fn a_brick_is_hit_in_the_frame_in_which_it_was_laid() {
    let mut lab = Lab::new();
    // Also before the very first step.
    for round in 0..2 {
        let x = 3.0 * round as f32;
        let laid = lab.body(brick(), Vec3::new(x, 0.25, 0.0));
        refresh(&mut lab.world);
        assert_eq!(below(&mut lab.world, x, 0.0), Some(laid), "round {round}");
        assert!(!fits(&mut lab.world, Vec3::new(x + 0.5, 0.25, 0.0)));
        assert!(fits(&mut lab.world, Vec3::new(x + 1.0, 0.25, 0.0)));
        lab.world.despawn(laid);
        assert_ne!(below(&mut lab.world, x, 0.0), Some(laid));
        lab.ground();
        lab.run(0.1);
    }
}

#[test]
fn bricks_laid_one_after_the_other_in_one_frame_do_not_overlap() {
    let mut lab = Lab::new();
    let mut laid = 0;
    for place in 0..40 {
        let at = Vec3::new(0.3 * place as f32, 0.25, 0.0);
        if fits(&mut lab.world, at) {
            lab.body(brick(), at);
            refresh(&mut lab.world);
            laid += 1;
        }
    }
    assert_eq!(laid, 10, "one at every fourth place");
}

#[test]
fn a_moved_brick_is_hit_where_it_is_and_not_where_it_was() {
    for asleep in [false, true] {
        let mut lab = Lab::new();
        let ground = lab.ground();
        let moved = lab.body(brick(), Vec3::new(0.0, 0.25, 0.0));
        lab.run(if asleep { 2.0 } else { 0.1 });
        let at = Transform::from_xyz(6.0, 0.25, 0.0);
        lab.world.entity_mut(moved).insert(at);
        refresh(&mut lab.world);
        assert_eq!(below(&mut lab.world, 0.0, 0.0), Some(ground), "{asleep}");
        assert_eq!(below(&mut lab.world, 6.0, 0.0), Some(moved), "{asleep}");
        // There and back.
        let at = Transform::from_xyz(0.0, 0.25, 0.0);
        lab.world.entity_mut(moved).insert(at);
        refresh(&mut lab.world);
        assert_eq!(below(&mut lab.world, 0.0, 0.0), Some(moved), "{asleep}");
        assert_eq!(below(&mut lab.world, 6.0, 0.0), Some(ground), "{asleep}");
    }
}

#[test]
fn a_child_is_hit_where_its_parent_has_taken_it() {
    let mut lab = Lab::new();
    let cart = lab.world.spawn(Transform::default()).id();
    let child = lab.spawn((RigidBody::Static, brick(), ChildOf(cart)));
    lab.run(0.2);
    *lab.world.get_mut::<Transform>(cart).unwrap() = Transform::from_xyz(4.0, 0.0, 0.0);
    refresh(&mut lab.world);
    assert_eq!(below(&mut lab.world, 4.0, 0.0), Some(child));
    assert_eq!(below(&mut lab.world, 0.0, 0.0), None);
    *lab.world.get_mut::<Transform>(cart).unwrap() = Transform::default();
    refresh(&mut lab.world);
    assert_eq!(below(&mut lab.world, 4.0, 0.0), None);
    assert_eq!(below(&mut lab.world, 0.0, 0.0), Some(child));
}

#[test]
fn a_shape_and_layers_count_as_soon_as_they_are_changed() {
    let mut lab = Lab::new();
    let body = lab.spawn((RigidBody::Static, brick()));
    lab.run(0.2);
    assert_eq!(below(&mut lab.world, 2.0, 0.0), None);
    let wide = Collider::cuboid(5.0, 0.5, 0.5);
    lab.world.entity_mut(body).insert(wide);
    refresh(&mut lab.world);
    assert_eq!(below(&mut lab.world, 2.0, 0.0), Some(body));
    let layers = CollisionLayers {
        memberships: 2,
        filters: 2,
    };
    lab.world.entity_mut(body).insert(layers);
    refresh(&mut lab.world);
    let down = Ray3d::new(Vec3::Y * 5.0, Dir3::NEG_Y);
    let of = |memberships| CollisionLayers {
        memberships,
        filters: u32::MAX,
    };
    for (memberships, expected) in [(1, None), (2, Some(body))] {
        let filter = QueryFilter::default().with_layers(of(memberships));
        let hit = ask(&mut lab.world, |query| query.cast_ray(down, 9.0, &filter));
        assert_eq!(hit.unwrap().map(|hit| hit.entity), expected);
    }
    lab.world.entity_mut(body).remove::<Collider>();
    refresh(&mut lab.world);
    assert_eq!(below(&mut lab.world, 0.0, 0.0), None);
    lab.world
        .entity_mut(body)
        .insert(Collider::half_space(Vec3::Y));
    refresh(&mut lab.world);
    assert_eq!(below(&mut lab.world, 30.0, 0.0), Some(body));
}

/// A body with invalid input is not found, as after a step.
#[test]
fn a_body_that_cannot_be_is_not_found() {
    let mut lab = Lab::new();
    let body = lab.spawn((RigidBody::Static, brick()));
    lab.run(0.2);
    let nowhere = Transform::from_xyz(f32::NAN, 0.0, 0.0);
    lab.world.entity_mut(body).insert(nowhere);
    refresh(&mut lab.world);
    assert_eq!(below(&mut lab.world, 0.0, 0.0), None);
    lab.body(Collider::cuboid(1.0, 0.0, 1.0), Vec3::X * 3.0);
    refresh(&mut lab.world);
    assert_eq!(below(&mut lab.world, 3.0, 0.0), None);
    assert_eq!(lab.errors(), []);
}

/// Interpolation writes a `Transform` between the last two poses. Such a body has not been moved.
#[test]
fn a_body_that_is_drawn_between_two_poses_is_hit_where_physics_has_it() {
    let mut lab = Lab::new();
    let body = lab.body(brick(), Vec3::Y * 40.0);
    let spin = Velocity {
        linear: Vec3::new(30.0, -3.0, 6.0),
        angular: Vec3::new(0.3, 0.0, 0.5),
    };
    lab.world.entity_mut(body).insert(spin);
    lab.run(0.5);
    let before = lab.pose(body);
    lab.step();
    let now = lab.pose(body);
    for share in [0.0, 0.3, 0.9] {
        let drawn = Transform::from_translation(before.position.lerp(now.position, share))
            .with_rotation(before.rotation.slerp(now.rotation, share));
        lab.world.entity_mut(body).insert(drawn);
        refresh(&mut lab.world);
        let here =
            |at: Vec3| move |query: SpatialQuery| query.bodies_at(at, &QueryFilter::default());
        let front = now.position + Vec3::X * 0.49;
        assert_eq!(ask(&mut lab.world, here(front)).unwrap(), [body], "{share}");
    }
    let aside = Transform::from_translation(now.position + Vec3::Z * 4.0);
    lab.world.entity_mut(body).insert(aside);
    refresh(&mut lab.world);
    let at = now.position + Vec3::Z * 4.0;
    let found = ask(&mut lab.world, |query| {
        query.bodies_at(at, &QueryFilter::default())
    });
    assert_eq!(found.unwrap(), [body]);
}

/// Takes steps with edits of all kinds between them, and asks as often as is said.
fn play(refreshes: usize) -> Vec<[u32; 13]> {
    let mut lab = Lab::new();
    lab.ground();
    let mut rng = fastrand::Rng::with_seed(11);
    let mut bodies = Vec::new();
    for round in 0..60 {
        let mut place = || {
            Vec3::new(
                4.0 * rng.f32() - 2.0,
                0.3 + 3.0 * rng.f32(),
                2.0 * rng.f32(),
            )
        };
        let (new, old) = (place(), place());
        bodies.push(lab.body(brick(), new));
        for _ in 0..refreshes {
            refresh(&mut lab.world);
        }
        let body = bodies[rng.usize(..bodies.len())];
        let mut body = lab.world.entity_mut(body);
        match round % 7 {
            0 => _ = body.insert(Transform::from_translation(old)),
            1 => _ = body.insert(Collider::ball(0.3)),
            2 => _ = body.insert(Density(500.0)),
            3 => _ = body.insert(RigidBody::Kinematic),
            4 => _ = body.insert(RigidBody::Dynamic),
            5 => _ = body.remove::<Density>(),
            _ => {}
        }
        for _ in 0..refreshes {
            refresh(&mut lab.world);
        }
        for _ in 0..rng.usize(0..40) {
            lab.step();
        }
    }
    lab.bits()
}

#[test]
fn a_refresh_changes_nothing_of_what_is_simulated() {
    let bits = play(0);
    assert_eq!(play(1), bits);
    assert_eq!(play(3), bits);
}

fn app() -> App {
    let mut app = App::new();
    app.add_plugins((TimePlugin, DrystonePlugins::default()));
    let frame = Duration::from_millis(16);
    app.insert_resource(TimeUpdateStrategy::ManualDuration(frame));
    app.world_mut()
        .spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
    app
}

/// A game places bricks for its player while time is paused, or while frames are shorter than steps.
#[test]
fn edits_are_known_in_the_next_frame() {
    #[derive(Resource, Default)]
    struct Seen(Option<Entity>);
    for paused in [true, false] {
        let mut app = app();
        let look = |query: SpatialQuery, mut seen: ResMut<Seen>| {
            let down = Ray3d::new(Vec3::new(2.0, 5.0, 0.0), Dir3::NEG_Y);
            let hit = query.cast_ray(down, 9.0, &QueryFilter::default());
            seen.0 = hit.unwrap().map(|hit| hit.entity);
        };
        app.init_resource::<Seen>().add_systems(Update, look);
        for _ in 0..30 {
            app.update();
        }
        if paused {
            app.world_mut().resource_mut::<Time<Virtual>>().pause();
        } else {
            let frame = Duration::from_millis(1);
            app.insert_resource(TimeUpdateStrategy::ManualDuration(frame));
            // The step that is due passes.
            for _ in 0..20 {
                app.update();
            }
        }
        app.update();
        let steps = app.world().resource::<Time<Fixed>>().elapsed();
        let laid = (
            RigidBody::Dynamic,
            brick(),
            Transform::from_xyz(2.0, 0.25, 0.0),
        );
        let laid = app.world_mut().spawn(laid).id();
        app.update();
        assert_eq!(app.world().resource::<Seen>().0, Some(laid), "{paused}");
        app.world_mut()
            .entity_mut(laid)
            .insert(Transform::from_xyz(8.0, 0.25, 0.0));
        app.update();
        assert_ne!(app.world().resource::<Seen>().0, Some(laid), "{paused}");
        let now = app.world().resource::<Time<Fixed>>().elapsed();
        assert_eq!(now, steps, "no step was taken: {paused}");
    }
}

/// `spatial_query` finds bodies that were spawned and moved just before.
#[test]
fn a_query_with_the_world_needs_no_refresh() {
    let mut lab = Lab::new();
    let filter = QueryFilter::default();
    let laid = lab.body(brick(), Vec3::Y);
    let here = |world: &mut World, at: Vec3| {
        spatial_query(world, |query| query.bodies_at(at, &filter)).unwrap()
    };
    assert_eq!(here(&mut lab.world, Vec3::Y), [laid]);
    let at = Transform::from_xyz(4.0, 1.0, 0.0);
    lab.world.entity_mut(laid).insert(at);
    assert_eq!(here(&mut lab.world, Vec3::Y), []);
    assert_eq!(here(&mut lab.world, at.translation), [laid]);
}

#[test]
fn a_system_that_asks_after_another_has_laid_finds_what_was_laid() {
    #[derive(Resource, Default)]
    struct Seen(Vec<bool>);
    let mut app = app();
    let lay = |mut commands: Commands| {
        commands.spawn((
            RigidBody::Static,
            brick(),
            Transform::from_xyz(2.0, 0.25, 0.0),
        ));
    };
    let look = |query: SpatialQuery, mut seen: ResMut<Seen>| {
        let pose = Pose {
            position: Vec3::new(2.4, 0.25, 0.0),
            ..Pose::default()
        };
        let fits = query.fits(&brick(), pose, 1e-3, &QueryFilter::default());
        seen.0.push(fits.unwrap());
    };
    app.init_resource::<Seen>()
        .add_systems(Update, (look, lay, drystone::refresh, look).chain());
    app.update();
    assert_eq!(app.world().resource::<Seen>().0, [true, false]);
}

#[test]
fn mass_is_known_as_soon_as_a_body_is_spawned() {
    let mut lab = Lab::new();
    let mass = |lab: &Lab, body| lab.mass(body).mass();
    let body = lab.body(brick(), Vec3::Y * 5.0);
    assert_near(mass(&lab, body), 250.0, 1e-5, "a brick");
    lab.world.entity_mut(body).insert(Density(2000.0));
    assert_near(mass(&lab, body), 500.0, 1e-5, "of another density");
    lab.world
        .entity_mut(body)
        .insert(Collider::cuboid(1.0, 1.0, 1.0));
    assert_near(mass(&lab, body), 2000.0, 1e-5, "of another shape");
    lab.world.entity_mut(body).insert(Mass(7.0));
    assert_near(mass(&lab, body), 7.0, 1e-5, "by hand");
    lab.world.entity_mut(body).insert(CenterOfMass(Vec3::X));
    assert_eq!(lab.mass(body).local_center, Vec3::X);
    // In whatever order its components come.
    let body = lab.spawn(brick());
    lab.world.entity_mut(body).insert(RigidBody::Dynamic);
    assert_near(mass(&lab, body), 250.0, 1e-5, "shape first");
    let body = lab.spawn(RigidBody::Dynamic);
    assert_near(mass(&lab, body), 1.0, 1e-5, "no shape yet");
    lab.world.entity_mut(body).insert(brick());
    assert_near(mass(&lab, body), 250.0, 1e-5, "shape last");
    // Components that were changed in place or removed take effect with the next refresh.
    lab.world.entity_mut(body).insert(Mass(3.0));
    lab.world.entity_mut(body).remove::<Mass>();
    refresh(&mut lab.world);
    assert_near(mass(&lab, body), 250.0, 1e-5, "taken off");
}

#[test]
fn a_force_may_be_computed_from_the_mass_before_the_first_step() {
    let mut lab = Lab::new();
    let body = lab.body(brick(), Vec3::Y * 5.0);
    let force = Vec3::Y * G * lab.mass(body).mass();
    let torque = Vec3::ZERO;
    lab.world.entity_mut(body).insert(ExternalForce {
        force,
        torque,
        ..Default::default()
    });
    lab.run(1.0);
    assert!(lab.world.get::<Quarantined>(body).is_none());
    assert!(lab.position(body).distance(Vec3::Y * 5.0) < 1e-3);
}
