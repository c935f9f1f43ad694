//! Two bodies that hit each other, alone.

use super::free::{energy, momentum};
use super::{Settings, Values};
use crate::Lab;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::body::{Mass, RigidBody, Velocity};
use drystone::collider::{Collider, Friction, Restitution};
use drystone::settings::Gravity;
use glam::Vec3;

/// Mass of the body that flies, and of the one that is hit, kg.
const MASSES: [f32; 2] = [2.0, 3.0];

/// Speed of the hit, m/s.
const SPEED: f32 = 3.0;

/// A body that flies along +x into one at rest, `aside` of its middle. The normal of the contact is x.
struct Hit {
    name: &'static str,
    flies: Collider,
    is_hit: Collider,
    /// Half of what either measures along x, m.
    halves: [f32; 2],
    /// Along z, m.
    aside: f32,
    restitution: f32,
}

impl Hit {
    fn body(&self, lab: &mut Lab, i: usize, at: Vec3, velocity: Vec3) -> Entity {
        let collider = [&self.flies, &self.is_hit][i].clone();
        lab.spawn((
            (RigidBody::Dynamic, collider, Mass(MASSES[i])),
            Friction::new(0.0),
            Restitution::new(self.restitution),
            Velocity::linear(velocity),
            Transform::from_translation(at),
        ))
    }

    /// Against Newton's law of impact: J = (1 + e) v/(1/m₁ + 1/m₂ + z²/I). Momenta may be off by rounding.
    fn measure(&self, settings: Settings, dt: f32, values: &mut Values) {
        let mut lab = settings(dt);
        lab.world.insert_resource(Gravity(Vec3::ZERO));
        let gap = 0.4;
        let from = Vec3::new(-self.halves[0] - self.halves[1] - gap, 0.0, self.aside);
        let one = self.body(&mut lab, 0, from, Vec3::X * SPEED);
        let other = self.body(&mut lab, 1, Vec3::ZERO, Vec3::ZERO);
        let bodies = [one, other];
        lab.step();
        let (linear, angular, size) = momentum(&lab, &bodies);
        let before = energy(&lab, &bodies);
        // Bodies that do not bounce stay in touch, and go on pushing each other while they turn: so it is measured as soon as they no
        // longer approach each other.
        for _ in 0..(0.5 / dt).ceil() as usize {
            lab.step();
            let [a, b] = bodies.map(|body| lab.velocity(body));
            if a.linear.x - b.linear.x - b.angular.y * self.aside < 0.01 * SPEED {
                break;
            }
        }
        let (linear_after, angular_after, _) = momentum(&lab, &bodies);
        let (name, e) = (self.name, self.restitution);
        let what = |of: &str| format!("hit: {name}, e {e}, {of}");
        let off = (linear_after - linear).length() / size;
        let named = what("linear momentum off by a share");
        values.add(named, (off, 0.0), 1e-5);
        let off = (angular_after - angular).length() / size;
        let named = what("angular momentum off by a share");
        values.add(named, (off, 0.0), 1e-5);
        let inertia = lab.mass(other).inverse_inertia.y;
        let mobility = 1.0 / MASSES[0] + 1.0 / MASSES[1] + self.aside * self.aside * inertia;
        let lost = (1.0 - e * e) * SPEED * SPEED / (2.0 * mobility) / before;
        let found = 1.0 - energy(&lab, &bodies) / before;
        values.add(what("energy lost, share"), (found, lost), 0.005);
        let spin = (1.0 + e) * SPEED / mobility * self.aside * inertia;
        if self.aside != 0.0 {
            let found = lab.velocity(other).angular.y;
            let named = what("spin of the one that is hit, rad/s");
            values.add_near(named, (found, spin), 0.01);
        }
    }
}

/// A ball on a wall at 45°, without gravity. It touches after `phase` steps and some.
struct Graze {
    friction: f32,
    restitution: f32,
    /// Speed along the wall and into it, m/s.
    speed: f32,
    /// m
    radius: f32,
    phase: f32,
}

impl Graze {
    /// Speed away from the wall, speed lost along it (m/s), and spin (rad/s).
    fn run(&self, settings: Settings, dt: f32) -> [f32; 3] {
        let &Self {
            friction,
            restitution,
            speed,
            radius,
            phase,
        } = self;
        let mut lab = settings(dt);
        lab.world.insert_resource(Gravity(Vec3::ZERO));
        let surface = (Friction::new(friction), Restitution::new(restitution));
        lab.spawn((RigidBody::Static, Collider::half_space(Vec3::Y), surface));
        let gap = (2.0 + phase) * speed * dt;
        let ball = lab.spawn((
            (RigidBody::Dynamic, Collider::ball(radius), surface),
            Velocity::linear(Vec3::new(speed, -speed, 0.0)),
            Transform::from_xyz(0.0, radius + gap, 0.0),
        ));
        for _ in 0..8 {
            lab.step();
        }
        let after = lab.velocity(ball);
        let lost = speed - after.linear.x;
        [after.linear.y, lost, -after.angular.z]
    }
}

/// A ball that hits a wall at 45° slides all the while and takes up spin: Δv_t = μ (1 + e) v_n, ω = 5 Δv_t/(2 r). The worst of five phases
/// of a step.
fn graze(settings: Settings, dt: f32, restitution: f32, values: &mut Values) {
    let (friction, speed, radius) = (0.1, 2.0, 0.3);
    let change = friction * (1.0 + restitution) * speed;
    let expected = [restitution * speed, change, 2.5 * change / radius];
    let mut worst = expected;
    for phase in [0.1, 0.3, 0.5, 0.7, 0.9] {
        let graze = Graze {
            friction,
            restitution,
            speed,
            radius,
            phase,
        };
        let found = graze.run(settings, dt);
        for i in 0..3 {
            if (found[i] - expected[i]).abs() >= (worst[i] - expected[i]).abs() {
                worst[i] = found[i];
            }
        }
    }
    let what = |of: &str| format!("hit: ball grazes a wall, e {restitution}, {of}");
    let [away, lost, spin] = [0, 1, 2].map(|i| (worst[i], expected[i]));
    values.add(what("speed away, m/s"), away, 0.01 * speed);
    values.add_near(what("speed lost along it, m/s"), lost, 0.01);
    values.add_near(what("spin, rad/s"), spin, 0.01);
}

/// Hits of two bodies without friction.
pub fn hits(settings: Settings, dt: f32) -> Values {
    let mut values = Values::at(dt);
    let (ball, cube) = (Collider::ball(0.3), Collider::cuboid(0.6, 0.6, 0.6));
    for restitution in [0.0, 0.5, 1.0] {
        let all = [
            ("ball on ball", &ball, &ball, 0.0),
            ("ball on cube, off its middle", &ball, &cube, 0.2),
            ("cube on cube", &cube, &cube, 0.0),
        ];
        for (name, flies, is_hit, aside) in all {
            let hit = Hit {
                name,
                flies: flies.clone(),
                is_hit: is_hit.clone(),
                halves: [0.3; 2],
                aside,
                restitution,
            };
            hit.measure(settings, dt, &mut values);
        }
    }
    values
}

/// Hits of a ball on a wall, with friction.
pub fn grazes(settings: Settings, dt: f32) -> Values {
    let mut values = Values::at(dt);
    for restitution in [0.0, 0.5] {
        graze(settings, dt, restitution, &mut values);
    }
    values
}
