//! Bodies that are spawned while they slide.

use crate::G;
use crate::accuracy::{Settings, Values};
use bevy_transform::components::Transform;
use drystone::body::{RigidBody, Velocity};
use drystone::collider::{Collider, Friction};
use glam::{Quat, Vec3};

/// How much faster than it should a box is that is spawned with `speed`, m/s, downwards on a slope: the most within 0.3 s, m/s.
fn gained(settings: Settings, dt: f32, (slope, friction): (f32, f32), speed: f32) -> f32 {
    let mut lab = settings(dt);
    lab.slope(slope, friction);
    let turn = Quat::from_rotation_z(-slope);
    let along = turn * Vec3::X;
    let block = lab.spawn((
        (
            RigidBody::Dynamic,
            Collider::cuboid(1.0, 0.25, 1.0),
            Friction::new(friction),
        ),
        Velocity::linear(speed * along),
        Transform::from_translation(turn * (0.125 * Vec3::Y)).with_rotation(turn),
    ));
    let slows = G * (friction * slope.cos() - slope.sin());
    let mut most = 0.0f32;
    for i in 1..=(0.3 / dt) as usize {
        lab.step();
        let expected = (speed - slows * i as f32 * dt).max(0.0);
        let off = lab.velocity(block).linear.dot(along) - expected;
        if off.abs() > most.abs() {
            most = off;
        }
    }
    most
}

/// How boxes slide that are spawned with a velocity.
pub fn slides_from_the_start(settings: Settings, dt: f32) -> Values {
    let mut values = Values::at(dt);
    for (slope, friction, speed, name) in [
        (0.3f32, 1.001 * 0.3f32.tan(), 0.1, "on a slope, 0.1 m/s"),
        (0.0, 0.4, 0.1, "on level ground, 0.1 m/s"),
        (0.0, 0.4, 1.0, "on level ground, 1 m/s"),
    ] {
        let gained = gained(settings, dt, (slope, friction), speed);
        let what = format!("23: box spawned {name}, velocity gained, m/s");
        values.add(what, (gained, 0.0), 1e-4);
    }
    values
}
