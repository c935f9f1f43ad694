//! A bouncing body.

use super::{Settings, Values};
use crate::G;
use bevy_transform::components::Transform;
use drystone::body::RigidBody;
use drystone::collider::{Collider, Restitution};
use glam::Vec3;

/// Coefficient of restitution.
const E: f32 = 0.8;
/// Height from which it falls, m.
const HEIGHT: f32 = 1.0;
/// Half the size of the body, m.
const HALF: f32 = 0.1;

/// Row 17. A bounce happens a step early or late, which changes the speed by up to g Δt. Heights are squares, and errors add up: the n-th
/// may be off by n %.
pub fn bounces(settings: Settings, dt: f32) -> Values {
    let mut values = Values::at(dt);
    let bodies = [
        ("ball", Collider::ball(HALF)),
        ("cube", Collider::cuboid(2.0 * HALF, 2.0 * HALF, 2.0 * HALF)),
    ];
    for (name, collider) in bodies {
        let mut lab = settings(dt);
        lab.spawn((
            RigidBody::Static,
            Collider::half_space(Vec3::Y),
            Restitution::new(E),
        ));
        let body = lab.spawn((
            RigidBody::Dynamic,
            collider,
            Restitution::new(E),
            Transform::from_xyz(0.0, HEIGHT + HALF, 0.0),
        ));
        let (mut apexes, mut last, mut rose_at) = (Vec::new(), 0.0, 0.0);
        for i in 0..(6.0 / dt).round() as usize {
            lab.step();
            let (v, y) = (lab.velocity(body).linear.y, lab.position(body).y - HALF);
            if last > 0.0 && v <= 0.0 {
                apexes.push(y);
            }
            if v > 0.05 {
                rose_at = i as f32 * dt;
            }
            last = v;
        }
        for n in 1..=6 {
            let expected = E.powi(2 * n) * HEIGHT;
            let apex = apexes.get(n as usize - 1).copied();
            let what = format!("17: {name} bounces, height {n}, m");
            values.add_near(what, (apex, expected), 0.01 * n as f32);
        }
        // Bounces below 5 cm/s, the last 2v/g/(1 − e) = 0.05 s, are not told from rest.
        let total = (2.0 * HEIGHT / G).sqrt() * (1.0 + E) / (1.0 - E);
        let what = format!("17: {name} comes to rest, s");
        values.add_near(what, (rose_at, total), 0.03);
        let speed = lab.velocity(body).linear.length();
        values.add(format!("17: {name} rests, m/s"), (speed, 0.0), 1e-3);
        let height = lab.position(body).y - HALF;
        values.add(format!("17: {name} rests, height, m"), (height, 0.0), 0.002);
    }
    values
}
