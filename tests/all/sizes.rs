//! Structures that stand at one size also stand at another.

use bevy_ecs::prelude::*;
use drystone::body::Pose;
use drystone::collider::Collider;
use drystone::settings::{Gravity, StabilizationSettings};
use drystone_lab::metrics::Displacement;
use glam::Vec3;
use support::*;

/// A wall of 6 × 6 bricks of so many metres, a little apart: drift and sag as shares of a brick's length after ten seconds.
fn wall(size: f32, scale_gravity: bool, scale_envelope: bool) -> (f32, f32) {
    let mut lab = Lab::shipped(1.0 / 60.0);
    if scale_gravity {
        lab.world.insert_resource(Gravity(Vec3::NEG_Y * G * size));
    }
    if scale_envelope {
        lab.world.resource_mut::<StabilizationSettings>().envelope *= size;
        lab.world
            .resource_mut::<StabilizationSettings>()
            .max_correction_speed *= size;
    }
    lab.ground();
    let mut rng = fastrand::Rng::with_seed(2);
    let bricks: Vec<Entity> = (0..36)
        .map(|i| {
            let (x, y) = ((i % 6) as f32, (i / 6) as f32);
            let mut noise = || 0.004 * (rng.f32() - 0.5);
            let shift = Vec3::new(noise(), noise(), noise());
            let at = Vec3::new(1.01 * (x + 0.3 * (y % 2.0)), 0.255 + 0.505 * y, 0.0) + shift;
            lab.body(Collider::cuboid(size, 0.5 * size, 0.5 * size), size * at)
        })
        .collect();
    let start: Vec<Pose> = bricks.iter().map(|&b| lab.pose(b)).collect();
    lab.run(10.0);
    let now: Vec<Pose> = bricks.iter().map(|&b| lab.pose(b)).collect();
    let worst = Displacement::between(&start, &now);
    (worst.drift / size, worst.sag / size)
}

#[test]
fn walls_of_small_and_large_bricks_stand_alike() {
    let (_, expected) = wall(1.0, false, false);
    for (gravity, envelope) in [(false, false), (true, false), (true, true)] {
        for size in [0.1, 1.0, 10.0] {
            let (drift, sag) = wall(size, gravity, envelope);
            let what = format!("bricks of {size} m, gravity scaled {gravity}, envelope {envelope}");
            println!("{what}: drift {drift}, sag {sag} of their length");
            assert!(drift < 0.005, "{what}: {drift}");
            assert!(
                (sag / expected - 1.0).abs() < 0.1,
                "{what}: {sag}, not {expected}"
            );
        }
    }
}
