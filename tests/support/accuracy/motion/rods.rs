//! Row 24: rods that fall on a floor, end first.

use crate::accuracy::{Settings, Values};
use bevy_transform::components::Transform;
use drystone::body::{RigidBody, Velocity};
use drystone::collider::{Collider, Friction, Restitution};
use drystone::settings::Gravity;
use glam::{DVec2, Quat, Vec3};

/// Length and thickness, m.
const LENGTH: f32 = 1.0;
const THICKNESS: f32 = 0.05;

/// The velocity of the centre and the spin after the end of a rod has hit the floor at `speed`, by Coulomb's and Newton's laws. The rod
/// falls without spin, so the end begins to slide in one direction, if at all, and Poisson's law is the same.
fn struck(angle: f64, bounce: f64, friction: f64, speed: f64) -> (DVec2, f64) {
    let (length, thickness) = (LENGTH as f64, THICKNESS as f64);
    let inertia = (length * length + thickness * thickness) / 12.0;
    // From the centre to the corner that hits.
    let corner = DVec2::new(-0.5 * length, -0.5 * thickness);
    let r = DVec2::from_angle(angle).rotate(corner);
    let along = 1.0 + r.y * r.y / inertia;
    let across = -r.x * r.y / inertia;
    let normal = 1.0 + r.x * r.x / inertia;
    let ratio = (-across / along).clamp(-friction, friction);
    let push = (1.0 + bounce) * speed / (normal + across * ratio);
    let impulse = DVec2::new(ratio * push, push);
    let velocity = DVec2::new(0.0, -speed) + impulse;
    (velocity, r.perp_dot(impulse) / inertia)
}

/// The largest error of the velocity (m/s) and of the speed of a point at the end of the rod relative to its centre, over the speed with
/// which it hits, over five phases within a step.
fn error(settings: Settings, dt: f32, degrees: f32, bounce: f32, friction: f32) -> f32 {
    let angle = degrees.to_radians();
    let mut worst = 0.0f32;
    for phase in 0..5 {
        let mut lab = settings(dt);
        lab.world.insert_resource(Gravity(Vec3::ZERO));
        let matter = (Friction::new(friction), Restitution::new(bounce));
        lab.spawn((RigidBody::Static, Collider::half_space(Vec3::Y), matter));
        let turn = Quat::from_rotation_z(angle);
        let low = turn * Vec3::new(-0.5 * LENGTH, -0.5 * THICKNESS, 0.0);
        let speed = 3.0f32;
        let above = speed * dt * (6.0 + 0.2 * phase as f32 + 0.1);
        let rod = lab.spawn((
            (
                RigidBody::Dynamic,
                Collider::cuboid(LENGTH, THICKNESS, THICKNESS),
                matter,
            ),
            Velocity::linear(-speed * Vec3::Y),
            Transform::from_translation(Vec3::Y * (above - low.y)).with_rotation(turn),
        ));
        for _ in 0..7 {
            lab.step();
        }
        let (velocity, spin) = struck(angle as f64, bounce as f64, friction as f64, speed as f64);
        let found = lab.velocity(rod);
        let off = (found.linear.truncate() - velocity.as_vec2()).length() / speed;
        let spins = 0.5 * LENGTH * (found.angular.z - spin as f32).abs() / speed;
        worst = worst.max(off).max(spins);
    }
    worst
}

/// How rods bounce that fall on one end.
pub fn rods_bounce(settings: Settings, dt: f32) -> Values {
    let mut values = Values::at(dt);
    for (bounce, friction, most) in [(0.5, 0.0, 0.005), (0.5, 0.3, 0.03), (0.0, 0.3, 0.02)] {
        for degrees in [20.0, 30.0, 60.0] {
            let error = error(settings, dt, degrees, bounce, friction);
            let what =
                format!("24: rod at {degrees}°, e {bounce}, μ {friction}: error of velocity");
            values.add(what, (error, 0.0), most);
        }
    }
    values
}
