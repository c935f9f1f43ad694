//! A slab on a base that is jerked.

use super::shapes::{HEIGHT, slabs};
use super::{Settings, Values};
use crate::G;
use bevy_transform::components::Transform;
use drystone::body::RigidBody;
use drystone::collider::{Collider, Friction};
use glam::Vec3;

/// Row 15: how far a slab slips on a base that gains speed at a rate A for 0.3 s and keeps it. The base is kinematic. Its
/// velocity in a step is that of the middle of the step, so that it goes the way of the formula.
pub fn base_slips(settings: Settings, dt: f32) -> Values {
    let (mu, jerk, time) = (0.5, 10.0, 0.3);
    let speed = jerk * time;
    let expected = speed * speed / (2.0 * mu * G) * (1.0 - mu * G / jerk);
    let mut values = Values::at(dt);
    for (name, slab) in slabs() {
        let mut lab = settings(dt);
        let base = lab.spawn((
            RigidBody::Kinematic,
            Collider::cuboid(20.0, 1.0, 4.0),
            Friction::new(mu),
            Transform::from_xyz(0.0, -0.5, 0.0),
        ));
        let slab = lab.spawn((
            (RigidBody::Dynamic, slab, Friction::new(mu)),
            Transform::from_xyz(0.0, 0.5 * HEIGHT, 0.0),
        ));
        lab.run(0.5);
        let apart = lab.position(base).x - lab.position(slab).x;
        for i in 1..=(1.5 / dt).round() as usize {
            let now = (jerk * (i as f32 - 0.5) * dt).min(speed);
            lab.set_velocity(base, Vec3::X * now, Vec3::ZERO);
            lab.step();
        }
        let slip = lab.position(base).x - lab.position(slab).x - apart;
        let what = format!("15: {name} slips on a jerked base, m");
        values.add_near(what, (slip, expected), 0.01);
    }
    values
}
