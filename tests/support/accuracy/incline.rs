//! Slabs and towers on slopes.

use super::shapes::{HEIGHT, hull_box, slabs};
use super::{Settings, Values, threshold};
use crate::{G, Lab};
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::body::RigidBody;
use drystone::collider::{Collider, Friction};
use glam::{Quat, Vec3};

/// A body on a slope that falls towards +x. It touches the slope `height` below its centre.
pub fn on_slope(
    lab: &mut Lab,
    angle: f32,
    collider: Collider,
    height: f32,
    turn: Quat,
    friction: f32,
) -> Entity {
    let rotation = Quat::from_rotation_z(-angle);
    lab.spawn((
        RigidBody::Dynamic,
        collider,
        Friction::new(friction),
        Transform::from_translation(rotation * Vec3::Y * height).with_rotation(rotation * turn),
    ))
}

/// A slab on a slope of this angle, rad.
fn slab_on_slope(
    settings: Settings,
    dt: f32,
    slab: &Collider,
    angle: f32,
    friction: f32,
) -> (Lab, Entity) {
    let mut lab = settings(dt);
    lab.slope(angle, friction);
    let (height, turn) = (0.5 * HEIGHT, Quat::IDENTITY);
    let slab = on_slope(&mut lab, angle, slab.clone(), height, turn, friction);
    (lab, slab)
}

/// The slope in degrees at which a slab starts to slide, and the one expected. 0.1° beyond it a slab has gone 3 cm in 2 s.
fn slide_angle(
    settings: Settings,
    dt: f32,
    slab: &Collider,
    friction: f32,
    width: f32,
) -> (Option<f32>, f32) {
    let stands = |degrees: f32| {
        let (mut lab, slab) = slab_on_slope(settings, dt, slab, degrees.to_radians(), friction);
        let start = lab.position(slab);
        lab.run(2.0);
        (lab.position(slab) - start).length() < 0.01
    };
    let expected = friction.atan().to_degrees();
    (
        threshold(expected - 2.0, expected + 2.0, width, stands),
        expected,
    )
}

/// Row 1.
pub fn slides(settings: Settings, dt: f32) -> Values {
    let mut values = Values::at(dt);
    let slabs = slabs();
    for (name, slab) in &slabs {
        let found = slide_angle(settings, dt, slab, 0.5, 0.02);
        values.add(format!("1: {name} starts to slide, μ 0.5, °"), found, 0.1);
    }
    for friction in [0.2, 0.9] {
        let found = slide_angle(settings, dt, &slabs[0].1, friction, 0.02);
        let what = format!("1: box starts to slide, μ {friction}, °");
        values.add(what, found, 0.1);
    }
    values
}

/// The acceleration of a slab that slides down, m/s², and the one expected.
fn slide_acceleration(
    settings: Settings,
    dt: f32,
    slab: &Collider,
    degrees: f32,
    friction: f32,
) -> (f32, f32) {
    let angle = degrees.to_radians();
    let (mut lab, slab) = slab_on_slope(settings, dt, slab, angle, friction);
    lab.run(0.5);
    let before = lab.velocity(slab).linear;
    lab.run(2.0);
    let gained = (lab.velocity(slab).linear - before).length() / 2.0;
    (gained, G * (angle.sin() - friction * angle.cos()))
}

/// Row 2.
pub fn slides_down(settings: Settings, dt: f32) -> Values {
    let mut values = Values::at(dt);
    let slabs = slabs();
    for (name, slab) in &slabs {
        let found = slide_acceleration(settings, dt, slab, 35.0, 0.5);
        let what = format!("2: {name} slides down 35°, μ 0.5, m/s²");
        values.add_near(what, found, 0.005);
    }
    for (degrees, friction) in [(28.0, 0.5), (20.0, 0.1), (50.0, 0.0)] {
        let found = slide_acceleration(settings, dt, &slabs[0].1, degrees, friction);
        let what = format!("2: box slides down {degrees}°, μ {friction}, m/s²");
        values.add_near(what, found, 0.005);
    }
    values
}

/// Row 3: the way of a slab of 5 m/s at μ 0.5. Not found if it still moves after 2 s.
pub fn stops(settings: Settings, dt: f32) -> Values {
    let mut values = Values::at(dt);
    for (name, slab) in slabs() {
        let mut lab = settings(dt);
        lab.ground();
        let slab = lab.body(slab, Vec3::Y * 0.5 * HEIGHT);
        lab.set_velocity(slab, Vec3::X * 5.0, Vec3::ZERO);
        lab.run(2.0);
        let stopped = lab.velocity(slab).linear.length() < 1e-3;
        let way = stopped.then(|| lab.position(slab).x);
        let expected = 25.0 / (2.0 * 0.5 * G);
        values.add_near(format!("3: {name} stops, m"), (way, expected), 0.006);
    }
    values
}

/// The slope in degrees at which a loose tower topples, and the one expected. A leaning tower takes off slowly: at 0.3° beyond the
/// threshold it has turned by 0.1 rad within the 4 s.
fn topple_angle(settings: Settings, dt: f32, cube: &Collider, n: u32) -> (Option<f32>, f32) {
    let stands = |degrees: f32| {
        let angle = degrees.to_radians();
        let mut lab = settings(dt);
        lab.slope(angle, 0.9);
        let tower: Vec<_> = (0..n)
            .map(|i| {
                let height = i as f32 + 0.5;
                on_slope(&mut lab, angle, cube.clone(), height, Quat::IDENTITY, 0.9)
            })
            .collect();
        lab.run(4.0);
        let upright = Quat::from_rotation_z(-angle);
        let turned = |&body: &Entity| lab.pose(body).rotation.angle_between(upright);
        tower.iter().all(|body| turned(body) < 0.1)
    };
    let expected = (1.0 / n as f32).atan().to_degrees();
    (
        threshold(expected - 3.0, expected + 3.0, 0.05, stands),
        expected,
    )
}

/// Row 6.
pub fn topples(settings: Settings, dt: f32) -> Values {
    let mut values = Values::at(dt);
    let cube = Collider::cuboid(1.0, 1.0, 1.0);
    for (name, cube, n) in [
        ("cubes", &cube, 2),
        ("cubes", &cube, 4),
        ("hulls", &hull_box(Vec3::ONE), 4),
    ] {
        let found = topple_angle(settings, dt, cube, n);
        values.add(format!("6: tower of {n} {name} topples, °"), found, 0.4);
    }
    values
}
