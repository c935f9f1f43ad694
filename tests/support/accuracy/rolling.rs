//! Spheres and cylinders that roll.

use super::incline::on_slope;
use super::{Settings, Tolerance, Values};
use crate::G;
use drystone::collider::Collider;
use glam::{Quat, Vec3};
use std::f32::consts::FRAC_PI_2;

/// Radius of all, m.
const RADIUS: f32 = 0.5;

struct Roller {
    name: &'static str,
    collider: Collider,
    /// I/(m r²)
    inertia: f32,
}

fn rollers() -> [Roller; 2] {
    [
        Roller {
            name: "sphere",
            collider: Collider::ball(RADIUS),
            inertia: 0.4,
        },
        Roller {
            name: "cylinder",
            collider: Collider::cylinder(RADIUS, 1.0),
            inertia: 0.5,
        },
    ]
}

/// Velocity (m/s) and spin (rad/s) gained in a second, after half a second to settle.
fn roll(settings: Settings, dt: f32, roller: &Roller, degrees: f32, friction: f32) -> (f32, f32) {
    let mut lab = settings(dt);
    let angle = degrees.to_radians();
    lab.slope(angle, friction);
    let lying = Quat::from_rotation_x(FRAC_PI_2);
    let collider = roller.collider.clone();
    let body = on_slope(&mut lab, angle, collider, RADIUS, lying, friction);
    lab.run(0.5);
    let before = lab.velocity(body);
    lab.run(1.0);
    let after = lab.velocity(body);
    let downhill = Quat::from_rotation_z(-angle) * Vec3::X;
    (
        (after.linear - before.linear).dot(downhill),
        -(after.angular - before.angular).z,
    )
}

/// Row 4: μ/tan θ must exceed c/(1 + c), 2/7 and 1/3; then the spin times the radius is the speed.
pub fn rolls(settings: Settings, dt: f32) -> Values {
    let mut values = Values::at(dt);
    for roller in rollers() {
        for (degrees, friction) in [(15.0f32, 0.1), (30.0, 0.5)] {
            let (a, alpha) = roll(settings, dt, &roller, degrees, friction);
            let expected = G * degrees.to_radians().sin() / (1.0 + roller.inertia);
            let what = format!("4: {} rolls down {degrees}°, μ {friction}", roller.name);
            values.add_near(format!("{what}, m/s²"), (a, expected), 0.01);
            let rim = RADIUS * alpha;
            values.add_near(format!("{what}, at its rim, m/s²"), (rim, expected), 0.01);
        }
    }
    values
}

/// Row 4, beyond the limit.
pub fn rollers_slip(settings: Settings, dt: f32) -> Values {
    let mut values = Values::at(dt);
    for roller in rollers() {
        let (degrees, friction) = (30.0f32, 0.1);
        let (a, alpha) = roll(settings, dt, &roller, degrees, friction);
        let (sin, cos) = degrees.to_radians().sin_cos();
        let what = format!("4: {} slips down {degrees}°, μ {friction}", roller.name);
        let expected = G * (sin - friction * cos);
        values.add_near(format!("{what}, m/s²"), (a, expected), 0.01);
        let expected = friction * G * cos / (roller.inertia * RADIUS);
        values.add_near(format!("{what}, rad/s²"), (alpha, expected), 0.01);
    }
    values
}

/// Row 5: a sphere of 5 m/s on a ground of μ 0.5. When and where it rolls is found to a step; both may be off by 1.5 % at steps of 1/480 s.
pub fn slides_into_rolling(settings: Settings, dt: f32) -> Values {
    let (v, mu) = (5.0, 0.5);
    let mut lab = settings(dt);
    lab.ground();
    let ball = lab.body(Collider::ball(RADIUS), Vec3::Y * RADIUS);
    lab.set_velocity(ball, Vec3::X * v, Vec3::ZERO);
    let mut rolls_at = None;
    for i in 1..(1.0 / dt).round() as usize {
        lab.step();
        let velocity = lab.velocity(ball);
        let slip = velocity.linear.x + RADIUS * velocity.angular.z;
        if slip < 1e-3 && rolls_at.is_none() {
            rolls_at = Some((i as f32 * dt, lab.position(ball).x));
        }
    }
    let speed = lab.velocity(ball).linear.x;
    let mut values = Values::at(dt);
    values.add_near("5: sphere rolls, m/s", (speed, v * 5.0 / 7.0), 0.002);
    let [time, way] = [2.0 * v / (7.0 * mu * G), 12.0 * v * v / (49.0 * mu * G)];
    let tolerance = |of: f32| Tolerance::PerStep(0.015 * of * 480.0);
    let found = (rolls_at.map(|(time, _)| time), time);
    values.add("5: sphere begins to roll, s", found, tolerance(time));
    let found = (rolls_at.map(|(_, way)| way), way);
    values.add("5: sphere begins to roll, m", found, tolerance(way));
    values
}
