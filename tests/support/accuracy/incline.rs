//! Boxes and towers on slopes.

use super::{Settings, threshold};
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

fn box_on_slope(settings: Settings, dt: f32, angle: f32, friction: f32) -> (Lab, Entity) {
    let mut lab = settings(dt);
    lab.slope(angle, friction);
    let slab = Collider::cuboid(1.0, 0.25, 1.0);
    let slab = on_slope(&mut lab, angle, slab, 0.125, Quat::IDENTITY, friction);
    (lab, slab)
}

/// Row 1: the slope in degrees at which a box starts to slide, and the one expected. 0.1° beyond it a box has gone 3 cm in 2 s.
pub fn slide_angle(settings: Settings, dt: f32, friction: f32, width: f32) -> (Option<f32>, f32) {
    let stands = |degrees: f32| {
        let (mut lab, slab) = box_on_slope(settings, dt, degrees.to_radians(), friction);
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

/// Row 2: the acceleration of a box that slides down, m/s², and the one expected.
pub fn slide_acceleration(settings: Settings, dt: f32, degrees: f32, friction: f32) -> (f32, f32) {
    let angle = degrees.to_radians();
    let (mut lab, slab) = box_on_slope(settings, dt, angle, friction);
    lab.run(0.5);
    let before = lab.velocity(slab).linear;
    lab.run(2.0);
    let gained = (lab.velocity(slab).linear - before).length() / 2.0;
    (gained, G * (angle.sin() - friction * angle.cos()))
}

/// Row 3: how far a box of 5 m/s slides at μ 0.5, m, and the way expected. `None` if it still moves after 2 s.
pub fn stop_distance(settings: Settings, dt: f32) -> (Option<f32>, f32) {
    let mut lab = settings(dt);
    lab.ground();
    let slab = lab.body(Collider::cuboid(1.0, 0.25, 1.0), Vec3::Y * 0.125);
    lab.set_velocity(slab, Vec3::X * 5.0, Vec3::ZERO);
    lab.run(2.0);
    let stopped = lab.velocity(slab).linear.length() < 1e-3;
    (
        stopped.then(|| lab.position(slab).x),
        25.0 / (2.0 * 0.5 * G),
    )
}

/// Row 6: the slope in degrees at which a loose tower of cubes topples, and the one expected. A leaning tower takes off slowly: at 0.3° beyond
/// the threshold it has turned by 0.1 rad within the 4 s.
pub fn topple_angle(settings: Settings, dt: f32, n: u32, width: f32) -> (Option<f32>, f32) {
    let stands = |degrees: f32| {
        let angle = degrees.to_radians();
        let mut lab = settings(dt);
        lab.slope(angle, 0.9);
        let cube = Collider::cuboid(1.0, 1.0, 1.0);
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
        threshold(expected - 3.0, expected + 3.0, width, stands),
        expected,
    )
}
