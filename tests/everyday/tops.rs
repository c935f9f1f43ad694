//! Tops, coins and wheels keep their spin.

use super::*;
use std::f32::consts::TAU;

/// A cone of radius 0.4 m and height 0.2 m that stands on its tip, as a hull with so many sides. Its centre of mass is 0.15 m above the
/// tip.
fn cone(sides: usize) -> Collider {
    let ring = (0..sides)
        .map(|k| Quat::from_rotation_y(k as f32 / sides as f32 * TAU) * Vec3::new(0.4, 0.2, 0.0));
    let points: Vec<Vec3> = ring.chain([Vec3::ZERO]).collect();
    Collider::convex_hull(&points).unwrap()
}

/// Spins a top, whose axis leans by `lean` rad, for `seconds`. Returns its spin about its axis, rad/s, and its mean precession about the
/// vertical over that time, rad/s.
fn spin(
    top: impl Bundle,
    lean: f32,
    spin: f32,
    friction: f32,
    hz: f32,
    seconds: f32,
) -> (f32, f32) {
    let mut app = app();
    let world = app.world_mut();
    world.resource_mut::<SleepSettings>().enabled = false;
    let surface = (Friction::new(friction), RollingFriction::new(0.0));
    world.spawn((RigidBody::Static, Collider::half_space(Vec3::Y), surface));
    let lean = Quat::from_rotation_z(-lean);
    let velocity = Velocity {
        linear: Vec3::ZERO,
        angular: lean * Vec3::Y * spin,
    };
    let top = world
        .spawn((
            RigidBody::Dynamic,
            surface,
            velocity,
            Transform::from_rotation(lean),
        ))
        .insert(top)
        .id();
    let axis = |world: &World| world.get::<Transform>(top).unwrap().rotation * Vec3::Y;
    let azimuth = |axis: Vec3| axis.x.atan2(axis.z);
    let (mut turned, mut before) = (0.0, azimuth(axis(world)));
    for _ in 0..(seconds * hz) as usize {
        steps_of(world, 1, 1.0 / hz);
        let now = azimuth(axis(world));
        turned += (now - before + 1.5 * TAU).rem_euclid(TAU) - 0.5 * TAU;
        before = now;
    }
    (velocity_about(world, top, axis(world)), turned / seconds)
}

fn velocity_about(world: &World, body: Entity, axis: Vec3) -> f32 {
    velocity(world, body).angular.dot(axis)
}

/// The mean precession of a heavy symmetric top on its tip, rad/s, that starts with spin about its axis only. Lagrange's equations in
/// double precision, by the midpoint rule, with moments of inertia of the hull about its axis and about a line through the tip across it,
/// per mass.
fn precession(sides: usize, lean: f64, spin: f64, seconds: f64) -> f64 {
    let mut app = app();
    let top = app
        .world_mut()
        .spawn((RigidBody::Dynamic, cone(sides)))
        .id();
    steps(app.world_mut(), 1);
    let mass = *app
        .world()
        .get::<drystone::body::MassProperties>(top)
        .unwrap();
    let inertia = mass.inverse_mass as f64 / mass.inverse_inertia.as_dvec3();
    let height = mass.local_center.y as f64;
    let about_axis = inertia.max_element();
    let about_tip = inertia.min_element() + height * height;
    let vertical = about_axis * spin * lean.cos();
    let turning =
        |lean: f64| (vertical - about_axis * spin * lean.cos()) / (about_tip * lean.sin().powi(2));
    let bending = |lean: f64| {
        let turning = turning(lean);
        let moment = about_tip * turning * turning * lean.cos() - about_axis * spin * turning
            + 9.81 * height;
        moment * lean.sin() / about_tip
    };
    let dt = 1e-5;
    let (mut now, mut rate, mut turned) = (lean, 0.0, 0.0);
    for _ in 0..(seconds / dt) as usize {
        let middle = now + 0.5 * dt * rate;
        let change = bending(middle);
        turned += dt * turning(middle);
        now += dt * (rate + 0.5 * dt * change);
        rate += dt * change;
    }
    turned / seconds
}

#[test]
fn a_top_keeps_its_spin_and_precesses() {
    let lean = 15f32.to_radians();
    for sides in [24, 64] {
        for speed in [15.0, 30.0, 60.0] {
            let (left, turned) = spin(cone(sides), lean, speed, 2.0, 60.0, 5.0);
            let truth = precession(sides, lean as f64, speed as f64, 5.0) as f32;
            let text = format!(
                "{sides} sides, {speed} rad/s: {left:.2} left, {turned:.3} instead of {truth:.3} rad/s"
            );
            println!("{text}");
            assert!((left / speed - 1.0).abs() < 0.01, "{text}");
            assert!((turned / truth - 1.0).abs() < 0.03, "{text}");
        }
    }
}

#[test]
fn an_upright_top_keeps_its_spin() {
    for (friction, hz) in [(2.0, 60.0), (0.5, 60.0), (2.0, 240.0), (2.0, 30.0)] {
        let (left, _) = spin(cone(24), 0.0, 30.0, friction, hz, 5.0);
        assert!(
            (left / 30.0 - 1.0).abs() < 0.01,
            "friction {friction}, {hz} Hz: {left:.2} left of 30"
        );
    }
}

/// A wheel that rolls upright keeps its speed and its way. A disk that spins on its edge like a coin is slowed by friction across its width
/// only.
#[test]
fn wheels_and_coins_keep_their_spin() {
    let surface = (Friction::new(0.8), RollingFriction::new(0.0));
    let shape = Collider::cylinder(0.3, 0.04);
    let mut app = app();
    let world = app.world_mut();
    world.resource_mut::<SleepSettings>().enabled = false;
    world.spawn((RigidBody::Static, Collider::half_space(Vec3::Y), surface));
    let upright = Quat::from_rotation_x(0.5 * std::f32::consts::PI);
    let disk = |z: f32, linear: Vec3, angular: Vec3| {
        let pose = at(0.0, 0.3, z).with_rotation(upright);
        (
            RigidBody::Dynamic,
            shape.clone(),
            surface,
            Velocity { linear, angular },
            pose,
        )
    };
    let wheel = world
        .spawn(disk(0.0, Vec3::X * 6.0, Vec3::NEG_Z * 20.0))
        .id();
    let coin = world.spawn(disk(5.0, Vec3::ZERO, Vec3::Y * 25.0)).id();
    steps(world, 120);
    let (speed, aside) = (velocity(world, wheel).linear.x, position(world, wheel).z);
    assert!(
        (speed / 6.0 - 1.0).abs() < 0.01 && aside.abs() < 0.1,
        "{speed} m/s, {aside} m"
    );
    // Friction at the two ends of its edge, over the moment of inertia about the vertical.
    let slowing = 0.8 * 9.81 * 0.02 / (0.25 * 0.3 * 0.3 + 0.04 * 0.04 / 12.0);
    let truth = 25.0 - 2.0 * slowing;
    let (spin, height) = (velocity(world, coin).angular.y, position(world, coin).y);
    assert!(
        (spin / truth - 1.0).abs() < 0.02 && (height - 0.3).abs() < 0.01,
        "{spin} rad/s, {height} m"
    );
}

/// A cube of 0.5 m spins upright on a corner. It falls over sooner or later, but its spin is not taken at once.
#[test]
fn a_cube_spins_on_its_corner() {
    let upright = Quat::from_rotation_arc(Vec3::ONE.normalize(), Vec3::Y);
    for spin in [12.0, 24.0] {
        let mut app = app();
        let world = app.world_mut();
        world.resource_mut::<SleepSettings>().enabled = false;
        let surface = (Friction::new(0.8), RollingFriction::new(0.0));
        world.spawn((RigidBody::Static, Collider::half_space(Vec3::Y), surface));
        let pose = at(0.0, 0.25 * 3f32.sqrt(), 0.0).with_rotation(upright);
        let velocity = Velocity {
            linear: Vec3::ZERO,
            angular: Vec3::Y * spin,
        };
        let cube = world
            .spawn((RigidBody::Dynamic, cube(0.5), surface, velocity, pose))
            .id();
        steps(world, 18);
        let left = super::velocity(world, cube).angular.y;
        assert!((left / spin - 1.0).abs() < 0.01, "{left} of {spin} rad/s");
    }
}
