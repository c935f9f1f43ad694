//! Beams and plates, a hundred times as long as they are thin.

use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::body::RigidBody;
use drystone::body::Sleeping;
use drystone::collider::Collider;
use drystone_lab::metrics;
use glam::{Quat, Vec3};
use std::collections::VecDeque;
use std::f32::consts::FRAC_PI_2;
use support::*;

/// The initial pose of the i-th of five bodies, above 0.5 m. They are `thick` m high and `wide` m wide.
type Arrangement = fn(i: usize, wide: f32, thick: f32) -> Transform;

fn arrangements() -> [(&'static str, Arrangement); 5] {
    [
        ("stacked", |i, _, thick| {
            Transform::from_xyz(0.0, 0.5 * thick + i as f32 * (thick + 0.01), 0.0)
        }),
        ("apart", |i, _, thick| {
            Transform::from_xyz(0.0, 0.5 * thick + i as f32 * (thick + 0.2), 0.0)
        }),
        ("crossed", |i, _, thick| {
            Transform::from_xyz(0.0, 0.5 * thick + i as f32 * (thick + 0.05), 0.0)
                .with_rotation(Quat::from_rotation_y(i as f32 * FRAC_PI_2))
        }),
        ("side by side", |i, wide, thick| {
            Transform::from_xyz(0.0, 0.5 * thick, i as f32 * (wide + 0.002))
        }),
        ("turned a little", |i, _, thick| {
            Transform::from_xyz(
                0.01 * i as f32,
                0.5 * thick + i as f32 * (thick + 0.05),
                0.0,
            )
            .with_rotation(Quat::from_rotation_y(0.01 * i as f32))
        }),
    ]
}

fn tilted(i: usize, wide: f32, thick: f32) -> Transform {
    // Their ends hang down by 0.1 m, and they lean on their edges.
    let at = 0.1 + thick + i as f32 * (thick + 0.25);
    Transform::from_xyz(0.0, at, 0.3 * wide * i as f32).with_rotation(
        Quat::from_rotation_y(0.3 * i as f32)
            * Quat::from_rotation_z(0.02)
            * Quat::from_rotation_x(0.1 * i as f32),
    )
}

/// Five of a shape, dropped, come to rest, asleep, in so many seconds.
///
/// Energy never rises above what it was, and springs give back no more than what they have taken in the last tenth of a second.
#[track_caller]
fn come_to_rest(size: Vec3, seconds: f32, arrangements: &[(&str, Arrangement)]) {
    let grounds = [
        (Collider::half_space(Vec3::Y), Vec3::ZERO),
        (Collider::cuboid(30.0, 1.0, 30.0), Vec3::NEG_Y * 0.5),
    ];
    for (ground, (surface, at)) in grounds.into_iter().enumerate() {
        for &(name, arrangement) in arrangements {
            let mut lab = Lab::new();
            lab.spawn((
                RigidBody::Static,
                surface.clone(),
                Transform::from_translation(at),
            ));
            let bodies: Vec<Entity> = (0..5)
                .map(|i| {
                    let mut at = arrangement(i, size.z, size.y);
                    at.translation.y += 0.5;
                    let collider = Collider::cuboid(size.x, size.y, size.z);
                    lab.spawn((RigidBody::Dynamic, collider, at))
                })
                .collect();
            lab.step();
            let start = metrics::energy(&mut lab.world);
            let (mut gain, mut slept) = (0.0f64, None);
            let mut recent = VecDeque::from([start]);
            for step in 0..(120.0 * seconds) as usize {
                lab.step();
                let energy = metrics::energy(&mut lab.world);
                let most = recent.iter().copied().fold(0.0, f64::max);
                gain = gain.max((energy - most) / start);
                assert!(
                    energy <= start * (1.0 + 1e-6),
                    "{name} on {ground}: {start} to {energy} J"
                );
                recent.push_back(energy);
                if recent.len() > 6 {
                    recent.pop_front();
                }
                let asleep = |&b: &Entity| lab.world.get::<Sleeping>(b).unwrap().asleep;
                if slept.is_none() && bodies.iter().all(asleep) {
                    slept = Some(step as f32 * lab.dt);
                }
            }
            let overlap = metrics::gaps(&mut lab.world).penetration_max;
            println!(
                "{size} {name} on {ground}: asleep at {slept:?} s, gains {gain:.1e}, overlap {overlap}"
            );
            assert_eq!(lab.errors(), []);
            assert!(
                slept.is_some_and(|time| time < seconds),
                "{name} on {ground}"
            );
            assert!(gain < 1e-3, "{name} on {ground}: gains {gain}");
            assert!(overlap < 1e-3, "{name} on {ground}: {overlap} m");
        }
    }
}

#[test]
fn thin_beams_come_to_rest() {
    come_to_rest(Vec3::new(10.0, 0.05, 0.05), 5.0, &arrangements());
}

#[test]
fn beams_come_to_rest() {
    come_to_rest(Vec3::new(10.0, 0.2, 0.2), 5.0, &arrangements());
}

#[test]
fn plates_come_to_rest() {
    come_to_rest(Vec3::new(1.0, 0.01, 1.0), 5.0, &arrangements());
}

/// Bodies that land across others on an edge. A beam of 10 m rocks for a long time on one of 0.2 m: up to 11 s.
fn tilted_come_to_rest(size: Vec3) {
    come_to_rest(size, 10.0, &[("tilted", tilted)]);
}

#[test]
#[ignore = "overlap by up to 3.7 cm when they land, and gain 1 % of their energy when they part; so with 24 sweeps a step, where it \
    begins a little otherwise"]
fn tilted_thin_beams_come_to_rest() {
    tilted_come_to_rest(Vec3::new(10.0, 0.05, 0.05));
}

#[test]
fn tilted_beams_come_to_rest() {
    tilted_come_to_rest(Vec3::new(10.0, 0.2, 0.2));
}

#[test]
fn tilted_plates_come_to_rest() {
    tilted_come_to_rest(Vec3::new(1.0, 0.01, 1.0));
}
