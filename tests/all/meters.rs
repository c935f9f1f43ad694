//! Meters count all bodies: a body that is quarantined, despawned or has a NaN pose has fallen.

use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::body::{Pose, Quarantined, Velocity};
use drystone::settings::Preset;
use drystone_lab::experiment::{Experiment, Outcome, Run};
use drystone_lab::metrics::{self, Displacement};
use glam::{Quat, Vec3};
use support::*;

const INFINITE: Displacement = Displacement {
    drift: f32::INFINITY,
    sag: f32::INFINITY,
    tilt: f32::INFINITY,
};

#[test]
fn a_pose_that_is_no_number_has_fallen() {
    let here = Pose::default();
    let at = |position| Pose { position, ..here };
    let turned = Pose {
        rotation: Quat::from_xyzw(f32::NAN, 0.0, 0.0, 1.0),
        ..here
    };
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
            let off = Vec3::select(axis.cmpgt(Vec3::ZERO), Vec3::splat(bad), Vec3::ZERO);
            // Among others that are well, before and after it.
            let displacement = Displacement::between(&[here; 3], &[here, at(off), here]);
            assert!(displacement.has_fallen(), "{off}: {displacement:?}");
            assert_eq!(displacement.drift, f32::INFINITY);
        }
    }
    assert!(Displacement::between([&here], [&turned]).has_fallen());
    assert!(Displacement::between([&turned], [&here]).has_fallen());
    let nowhere = metrics::NOWHERE;
    assert_eq!(Displacement::between([&here], [&nowhere]), INFINITE);
}

/// Quarantined where it stands: its pose is sound.
fn quarantine(world: &mut World, body: Entity) {
    world.get_mut::<Velocity>(body).unwrap().linear.x = f32::NAN;
}

fn despawn(world: &mut World, body: Entity) {
    world.despawn(body);
}

#[test]
fn the_worlds_meters_count_the_quarantined() {
    let mut lab = Lab::new();
    lab.ground();
    let cubes = [0.5, 1.5, 2.5].map(|y| lab.cube(Vec3::Y * y));
    lab.run(0.1);
    assert!(metrics::energy(&mut lab.world).is_finite());
    assert!(metrics::kinetic_energy(&mut lab.world).is_finite());
    assert!(metrics::rms_speed(&mut lab.world).is_finite());
    assert_eq!(metrics::watch(&lab.world, cubes[1]).0, lab.pose(cubes[1]));
    // As a solve that ran away leaves it.
    quarantine(&mut lab.world, cubes[1]);
    assert_eq!(metrics::energy(&mut lab.world), f64::INFINITY);
    assert_eq!(metrics::rms_speed(&mut lab.world), f32::INFINITY);
    lab.step();
    assert!(lab.world.get::<Quarantined>(cubes[1]).is_some());
    lab.set_velocity(cubes[1], Vec3::ZERO, Vec3::ZERO);
    assert_eq!(metrics::energy(&mut lab.world), f64::INFINITY);
    assert_eq!(metrics::kinetic_energy(&mut lab.world), f64::INFINITY);
    assert_eq!(metrics::rms_speed(&mut lab.world), f32::INFINITY);
    let (pose, velocity) = metrics::watch(&lab.world, cubes[1]);
    assert!(!pose.is_finite() && !velocity.is_finite());
}

/// The outcome of a scene in which something happens to a body.
fn outcome(scene: &str, happens: impl Fn(&mut Run)) -> Outcome {
    let scene = scene.parse().expect("a known scene");
    let mut run = Experiment::new(scene, Preset::Default).start();
    for _ in 0..10 {
        run.step();
    }
    assert!(run.outcome().stands, "{scene}");
    happens(&mut run);
    for _ in 0..10 {
        run.step();
    }
    run.outcome()
}

#[test]
fn an_experiment_counts_the_quarantined_and_the_despawned() {
    for scene in ["stack:3", "heap:20", "overlap:0.1", "wall:3x3"] {
        for lose in [quarantine, despawn] {
            let outcome = outcome(scene, |run| {
                let body = run.bodies[1];
                lose(&mut run.world, body);
            });
            assert!(!outcome.stands && outcome.fell_at.is_some(), "{scene}");
            assert_eq!(outcome.displacement, INFINITE, "{scene}");
        }
        let outcome = outcome(scene, |run| {
            let body = run.bodies[1];
            quarantine(&mut run.world, body);
        });
        assert_eq!(outcome.rms_speed, f32::INFINITY, "{scene}");
        assert_eq!(outcome.energy_gain, f64::INFINITY, "{scene}");
    }
}

#[test]
fn bodies_below_the_ground_count_as_lost() {
    let outcome = outcome("heap:20", |run| {
        let body = run.bodies[0];
        let below = Transform::from_xyz(0.0, -1.0, 0.0);
        run.world.entity_mut(body).insert(below);
    });
    assert!(!outcome.stands);
}
