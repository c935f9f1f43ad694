//! Two balls that glance off each other: why the default solver loses angular momentum in row 20.

use super::Settings;
use super::free::momentum;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::body::{Mass, RigidBody, Velocity};
use drystone::collider::{Collider, Friction};
use drystone::settings::Gravity;
use glam::Vec3;

/// What a glancing hit does.
#[derive(Clone, Copy, Debug)]
pub struct Glance {
    /// Change of the angular momentum of both, kg·m²/s.
    pub off: f32,
    /// J u Δt: impulse times relative speed along the contact times step, kg·m²/s.
    pub most: f32,
}

/// Two balls of 1 kg without friction, one of which flies at 3 m/s, aside of the other by half of their distance when they touch; `phase`:
/// in which part of a step they touch, 0 to 1.
///
/// The normal and the lever arms of a contact are fixed during a step. If an impulse J acts at a time t before or after that for which they
/// hold, the balls move along each other by u t between the two. The impulse and its reaction then are two forces on parallel lines u t
/// apart: a moment of J u t, between 0 and J u Δt.
pub fn glance(settings: Settings, dt: f32, phase: f32) -> Glance {
    let mut lab = settings(dt);
    lab.world.insert_resource(Gravity(Vec3::ZERO));
    let (radius, speed, aside) = (0.5, 3.0, 0.5f32);
    let (sin, cos) = (aside, (1.0 - aside * aside).sqrt());
    let ball = |at: Vec3, velocity: Vec3| {
        (
            (RigidBody::Dynamic, Collider::ball(radius), Mass(1.0)),
            Friction::new(0.0),
            Velocity::linear(velocity),
            Transform::from_translation(at),
        )
    };
    let away = cos + (3.0 + phase) * speed * dt;
    let one = lab.spawn(ball(Vec3::new(-away, aside, 0.0), Vec3::X * speed));
    let other = lab.spawn(ball(Vec3::ZERO, Vec3::ZERO));
    let bodies: [Entity; 2] = [one, other];
    lab.step();
    let before = momentum(&lab, &bodies).1;
    for _ in 0..8 {
        lab.step();
    }
    let impulse = lab.velocity(other).linear.length();
    Glance {
        off: (momentum(&lab, &bodies).1 - before).length(),
        most: impulse * speed * sin * dt,
    }
}
