//! Bodies in free flight, and a closed group of bodies that collide.

use super::{Settings, Tolerance, Values};
use crate::{G, Lab};
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::body::{Density, GravityScale, RigidBody, Velocity};
use drystone::collider::{Collider, Restitution};
use drystone::settings::Gravity;
use glam::Vec3;

/// Row 19: a brick spun about its middle axis turns over and back for a minute. Errors are rounding of 3600 steps, a few units in the last
/// place (1e-7) each; energy is a square.
pub fn tumbles(settings: Settings, dt: f32) -> Values {
    let mut lab = settings(dt);
    lab.world.insert_resource(Gravity(Vec3::ZERO));
    // The middle moment of inertia is about the middle length, y.
    let brick = lab.body(Collider::cuboid(1.0, 0.5, 0.2), Vec3::ZERO);
    lab.set_velocity(brick, Vec3::X, Vec3::new(0.005, 5.0, 0.0));
    lab.step();
    let energy = |lab: &Lab| {
        let (pose, velocity) = (lab.pose(brick), lab.velocity(brick));
        lab.mass(brick).kinetic_energy(pose.rotation, &velocity)
    };
    let (momentum_0, energy_0) = (spin_of(&lab, brick), energy(&lab));
    // NaN stays in a sum.
    let (mut lowest, mut momentum, mut gain) = (1.0f32, 0.0f32, 0.0f32);
    let worse = |worst: f32, off: f32| match worst.is_nan() || off <= worst {
        true => worst,
        false => off,
    };
    for _ in 0..(60.0 / dt).round() as usize {
        lab.step();
        let off = (spin_of(&lab, brick) - momentum_0).length() / momentum_0.length();
        momentum = worse(momentum, off);
        gain = worse(gain, (energy(&lab) / energy_0 - 1.0).abs());
        lowest = lowest.min((lab.pose(brick).rotation * Vec3::Y).y);
    }
    let mut values = Values::at(dt);
    let what = "19: free brick, angular momentum off by a share";
    values.add(what, (momentum, 0.0), 2e-3);
    values.add("19: free brick, energy off by a share", (gain, 0.0), 4e-3);
    let what = "19: free brick turns over, lowest cosine of its middle axis";
    values.add(what, (lowest, -1.0), 0.1);
    values
}

/// Angular momentum about its centre of mass, kg·m²/s.
fn spin_of(lab: &Lab, body: Entity) -> Vec3 {
    let inverse = lab
        .mass(body)
        .world_inverse_inertia(lab.pose(body).rotation);
    inverse.inverse() * lab.velocity(body).angular
}

/// Row 20. Semi-implicit Euler is exact in the velocity, and one half step of falling ahead in the height: g T Δt/2.
pub fn flies(settings: Settings, dt: f32) -> Values {
    let mut lab = settings(dt);
    let brick = lab.body(Collider::cuboid(0.3, 0.2, 0.1), Vec3::Y);
    lab.set_velocity(brick, Vec3::new(3.0, 8.0, -1.0), Vec3::new(1.0, 2.0, 3.0));
    let time = 1.5;
    lab.run(time);
    let truth = Vec3::new(3.0 * time, 1.0 + 8.0 * time - 0.5 * G * time * time, -time);
    let off = lab.position(brick) - truth;
    let mut values = Values::at(dt);
    let what = "20: projectile, off after 1.5 s, m";
    let tolerance = Tolerance::PerStep(1.03 * 0.5 * G * time);
    values.add(what, (off.length(), 0.0), tolerance);
    let speed = Vec3::new(3.0, 8.0 - G * time, -1.0);
    let off = (lab.velocity(brick).linear - speed).length();
    values.add(
        "20: projectile, velocity off after 1.5 s, m/s",
        (off, 0.0),
        1e-4,
    );
    values
}

/// Momentum of several bodies: linear, angular about the origin, and the sum of the sizes of the linear momenta.
pub(super) fn momentum(lab: &Lab, bodies: &[Entity]) -> (Vec3, Vec3, f32) {
    let (mut linear, mut angular, mut size) = (Vec3::ZERO, Vec3::ZERO, 0.0);
    for &body in bodies {
        let (pose, v, mass) = (lab.pose(body), lab.velocity(body), lab.mass(body));
        let push = v.linear * mass.mass();
        linear += push;
        angular += pose.transform_point(mass.local_center).cross(push) + spin_of(lab, body);
        size += push.length();
    }
    (linear, angular, size)
}

/// Kinetic energy of several bodies, J.
pub(super) fn energy(lab: &Lab, bodies: &[Entity]) -> f32 {
    let of = |&body: &Entity| {
        let (pose, velocity) = (lab.pose(body), lab.velocity(body));
        lab.mass(body).kinetic_energy(pose.rotation, &velocity)
    };
    bodies.iter().map(of).sum()
}

/// What a closed group of bodies that collide for three seconds has lost, as shares of the sum of their momenta, and of their energy.
#[derive(Clone, Copy, Debug)]
pub struct Lost {
    /// Linear momentum.
    pub linear: f32,
    /// Angular momentum.
    pub angular: f32,
    /// Kinetic energy.
    pub energy: f32,
}

/// Boxes and balls of many weights fly into each other: contact only hands momentum on, linear and angular.
pub fn closed_group(mut lab: Lab, seed: u64) -> Lost {
    let mut rng = fastrand::Rng::with_seed(seed);
    let mut random = |size: f32| {
        let mut one = || (2.0 * rng.f32() - 1.0) * size;
        Vec3::new(one(), one(), one())
    };
    let mut bodies = Vec::new();
    for i in 0..24 {
        let at = Vec3::new((i % 3) as f32, (i / 3 % 3) as f32, (i / 9) as f32) * 1.5 - 1.5;
        let collider = match i % 2 {
            0 => Collider::cuboid(0.8, 0.5, 0.6),
            _ => Collider::ball(0.4),
        };
        bodies.push(lab.spawn((
            RigidBody::Dynamic,
            collider,
            Restitution::new(0.5),
            Density(500.0 * (1 + i % 4) as f32),
            GravityScale(0.0),
            Velocity {
                linear: -1.5 * at + random(1.0),
                angular: random(3.0),
            },
            Transform::from_translation(at),
        )));
    }
    lab.step();
    let (linear, angular, size) = momentum(&lab, &bodies);
    let before = energy(&lab, &bodies);
    lab.run(3.0);
    let (linear_after, angular_after, _) = momentum(&lab, &bodies);
    Lost {
        linear: (linear_after - linear).length() / size,
        angular: (angular_after - angular).length() / size,
        energy: 1.0 - energy(&lab, &bodies) / before,
    }
}

/// Row 20. Errors are rounding of 180 steps over 24 bodies.
pub fn group_keeps_momentum(settings: Settings, dt: f32) -> Values {
    let lost = closed_group(settings(dt), 7);
    let mut values = Values::at(dt);
    let what = "20: 24 bodies collide, linear momentum off by a share";
    values.add(what, (lost.linear, 0.0), 2e-5);
    let what = "20: 24 bodies collide, angular momentum off by a share";
    values.add(what, (lost.angular, 0.0), 1e-4);
    // Otherwise they have not collided.
    let what = "20: 24 bodies collide, energy lost, 0.1 to 1";
    values.add(what, (lost.energy, 0.55), 0.45);
    values
}
