//! Row 22: blocks on a floor that is shaken.

use super::at_step;
use super::rocking::{HEIGHT, block_of, lean_of};
use crate::accuracy::{Settings, Values, threshold};
use crate::{G, Lab};
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::body::RigidBody;
use drystone::collider::{Collider, Friction};
use drystone_lab::housner::Lean;
use glam::{Quat, Vec3};
use std::f64::consts::{PI, TAU};

/// A motion of a floor along x: its acceleration and its place, by time.
#[derive(Clone, Copy, Debug)]
enum Shake {
    /// So many m/s² at so many Hz, from rest.
    Sine { acceleration: f64, frequency: f64 },
    /// Half a period of a sine of so many rad/s.
    Pulse { acceleration: f64, rate: f64 },
    /// An acceleration that grows by so many m/s³.
    Growing { jerk: f64 },
}

impl Shake {
    /// The acceleration, m/s².
    fn acceleration(&self, t: f64) -> f64 {
        match *self {
            Self::Sine {
                acceleration,
                frequency,
            } => acceleration * (TAU * frequency * t).sin(),
            Self::Pulse { acceleration, rate } if rate * t < PI => acceleration * (rate * t).sin(),
            Self::Pulse { .. } => 0.0,
            Self::Growing { jerk } => jerk * t,
        }
    }

    /// How far the floor has gone, m.
    fn way(&self, t: f64) -> f64 {
        let sine = |a: f64, w: f64, t: f64| a / w * (t - (w * t).sin() / w);
        match *self {
            Self::Sine {
                acceleration,
                frequency,
            } => sine(acceleration, TAU * frequency, t),
            Self::Pulse { acceleration, rate } => {
                let end = PI / rate;
                sine(acceleration, rate, t.min(end))
                    + 2.0 * acceleration / rate * (t - end).max(0.0)
            }
            Self::Growing { jerk } => jerk * t * t * t / 6.0,
        }
    }

    /// The velocity with which the floor goes as far in a step as it should, m/s.
    fn velocity(&self, step: usize, dt: f32) -> f32 {
        let dt = dt as f64;
        let [from, to] = [step as f64 * dt, (step + 1) as f64 * dt].map(|t| self.way(t));
        ((to - from) / dt) as f32
    }
}

/// A block that slides on a slope by Coulomb's law, in double precision: how far it slides down on a floor that is shaken, m.
fn slides(slope: f64, friction: f64, shake: Shake, until: f64) -> f64 {
    const STEP: f64 = 1e-5;
    let (sin, cos) = slope.sin_cos();
    let (mut v, mut way) = (0.0f64, 0.0f64);
    for i in 0..(until / STEP).round() as usize {
        let a = shake.acceleration(i as f64 * STEP);
        let drive = G as f64 * sin - a * cos;
        let held = friction * (G as f64 * cos + a * sin).max(0.0);
        if v == 0.0 && drive.abs() <= held {
            continue;
        }
        let side = if v == 0.0 { drive.signum() } else { v.signum() };
        let next = v + STEP * (drive - side * held);
        v = if next * side < 0.0 && drive.abs() <= held {
            0.0
        } else {
            next
        };
        way += STEP * v;
    }
    way
}

/// How far a flat block slides down on a floor that is shaken, m.
fn slid(
    settings: Settings,
    dt: f32,
    (slope, friction): (f32, f32),
    shake: Shake,
    until: f32,
) -> f32 {
    let mut lab = settings(dt);
    let turn = Quat::from_rotation_z(-slope);
    let floor = lab.spawn((
        (
            RigidBody::Kinematic,
            Collider::cuboid(60.0, 1.0, 4.0),
            Friction::new(friction),
        ),
        Transform::from_translation(turn * (-0.5 * Vec3::Y)).with_rotation(turn),
    ));
    let block = lab.spawn((
        (
            RigidBody::Dynamic,
            Collider::cuboid(1.0, 0.25, 1.0),
            Friction::new(friction),
        ),
        Transform::from_translation(turn * (0.125 * Vec3::Y)).with_rotation(turn),
    ));
    lab.run(0.5);
    let apart = |lab: &Lab| (lab.position(block) - lab.position(floor)).dot(turn * Vec3::X);
    let before = apart(&lab);
    shake_floor(&mut lab, floor, shake, until, |_, _| true);
    apart(&lab) - before
}

fn shake_floor(
    lab: &mut Lab,
    floor: Entity,
    shake: Shake,
    until: f32,
    mut tell: impl FnMut(&Lab, f64) -> bool,
) {
    for i in 0..(until / lab.dt).round() as usize {
        lab.set_velocity(floor, Vec3::X * shake.velocity(i, lab.dt), Vec3::ZERO);
        lab.step();
        if !tell(lab, (i + 1) as f64 * lab.dt as f64) {
            break;
        }
    }
}

/// A block that stands on a kinematic floor, and the floor.
fn standing(settings: Settings, dt: f32, slenderness: f32) -> (Lab, Entity, Entity) {
    let mut lab = settings(dt);
    let floor = lab.spawn((
        (
            RigidBody::Kinematic,
            Collider::cuboid(40.0, 1.0, 4.0),
            Friction::new(2.0),
        ),
        Transform::from_xyz(0.0, -0.5, 0.0),
    ));
    let block = lab.spawn((
        (
            RigidBody::Dynamic,
            Collider::cuboid(HEIGHT * slenderness, HEIGHT, 1.0),
            Friction::new(2.0),
        ),
        Transform::from_xyz(0.0, 0.5 * HEIGHT, 0.0),
    ));
    lab.run(0.5);
    (lab, block, floor)
}

/// The least acceleration of half a sine at which a block falls, m/s², and the truth. `ratio` is the rate of the sine over the block's p.
fn overturns(settings: Settings, dt: f32, slenderness: f32, ratio: f64) -> [Option<f32>; 2] {
    let truth = block_of(slenderness, HEIGHT);
    let rate = ratio * truth.p2.sqrt();
    let pulse = |acceleration: f32| Shake::Pulse {
        acceleration: acceleration as f64,
        rate,
    };
    let expected = threshold(1.0, 15.0, 1e-3, |acceleration| {
        let lean = Lean {
            angle: 0.0,
            speed: 0.0,
        };
        let floor = |t| pulse(acceleration).acceleration(t);
        truth
            .rock(lean, 6.0, floor, |_, lean| lean.angle.abs() < 1.2)
            .angle
            .abs()
            < 1.2
    });
    let around = expected.unwrap_or(4.0);
    let found = threshold(0.7 * around, 1.4 * around, 1e-3 * around, |acceleration| {
        let (mut lab, block, floor) = standing(settings, dt, slenderness);
        let mut stands = true;
        shake_floor(&mut lab, floor, pulse(acceleration), 6.0, |lab, _| {
            stands = lean_of(lab, block).abs() < 1.2;
            stands
        });
        stands
    });
    [found, expected]
}

/// The acceleration of a floor, growing by 0.5 m/s³, at which a block has begun to rock, over that of gravity, and the truth.
fn begins(settings: Settings, dt: f32, slenderness: f32) -> [f64; 2] {
    const LEAN: f64 = 2e-3;
    let shake = Shake::Growing { jerk: 0.5 };
    let lean = Lean {
        angle: 0.0,
        speed: 0.0,
    };
    let mut times = [f64::NAN; 2];
    let floor = |t| shake.acceleration(t);
    block_of(slenderness, HEIGHT).rock(lean, 20.0, floor, |t, lean| {
        times[1] = t;
        lean.angle.abs() < LEAN
    });
    let (mut lab, block, floor) = standing(settings, dt, slenderness);
    let mut last = (0.0, 0.0);
    shake_floor(&mut lab, floor, shake, 20.0, |lab, t| {
        let lean = lean_of(lab, block).abs();
        if lean >= LEAN {
            // Between two steps.
            times[0] = last.0 + (t - last.0) * (LEAN - last.1) / (lean - last.1);
        }
        last = (t, lean);
        lean < LEAN
    });
    times.map(|t| shake.acceleration(t) / G as f64)
}

/// What blocks do on floors that are shaken.
pub fn shakes(settings: Settings, dt: f32) -> Values {
    let mut values = Values::at(dt);
    let [found, expected] = begins(settings, dt, 0.25).map(|a| a as f32);
    let what = "22: box of 1 : 4 begins to rock, g";
    values.add_near(
        what,
        (found, expected),
        at_step(dt, [0.05, 0.01, 0.01, 0.01]),
    );
    let shake = |share: f64, frequency: f64| Shake::Sine {
        acceleration: share * G as f64,
        frequency,
    };
    let (slope, friction) = (8f32.to_radians(), 0.4);
    let below = slid(settings, dt, (slope, friction), shake(0.2, 1.0), 10.0);
    let what = "22: box slips below the limit of friction, m";
    values.add(what, (below, 0.0), at_step(dt, [5e-3, 1e-4, 1e-4, 1e-4]));
    for frequency in [1.0, 3.0] {
        let shake = shake(0.5, frequency);
        let until = 10.0 / frequency;
        let found = slid(settings, dt, (slope, friction), shake, until as f32);
        let expected = slides(slope as f64, friction as f64, shake, until) as f32;
        let what = format!("22: box slides on a slope shaken at {frequency} Hz, m");
        values.add_near(what, (found, expected), 0.02);
    }
    for ratio in [2.0, 4.0, 6.0] {
        let [found, expected] = overturns(settings, dt, 0.25, ratio);
        let what = format!("22: pulse of {ratio} p overturns a box of 1 : 4, m/s²");
        let most = at_step(dt, [0.01, 0.01, 0.01, 0.001]);
        values.add_near(what, (found, expected.unwrap_or(f32::NAN)), most);
    }
    values
}
