//! Previews in worlds whose steps are unusually short or long.

use super::*;
use std::time::Instant;

/// A tower of cubes on a plane that has stood for two seconds, and has then taken some steps of another length.
fn tower(count: usize, waking: Waking, last: f32, sleeps: bool) -> (App, Vec<Entity>) {
    let mut app = app();
    let world = app.world_mut();
    let mut settings = world.resource_mut::<SleepSettings>();
    (settings.waking, settings.enabled) = (waking, sleeps);
    world.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
    let cubes = (0..count).map(|i| {
        world
            .spawn((RigidBody::Dynamic, cube(1.0), at(0.0, 0.5 + i as f32, 0.0)))
            .id()
    });
    let cubes = cubes.collect();
    steps(world, 120);
    steps_of(world, 3, last);
    (app, cubes)
}

#[test]
fn falling_bodies_are_reported_in_slow_motion_and_in_long_steps() {
    for waking in [Waking::Islands, SleepSettings::default().waking] {
        for sleeps in [true, false] {
            for last in [1e-7, 1e-6, 5e-5, 1e-3, 1.0 / 240.0, 0.1, 0.3] {
                let (app, cubes) = tower(3, waking, last, sleeps);
                let what = format!("{last} s, {waking:?}, {sleeps}");
                for (i, falls) in [(0, 2), (1, 1), (2, 0)] {
                    let preview = preview(app.world(), &Edit::Remove(vec![cubes[i]])).unwrap();
                    assert_eq!(
                        preview.moved.len(),
                        falls,
                        "{what}: {i} of the tower, {preview:?}"
                    );
                    assert!(preview.at_rest, "{what}: {i} of the tower, {preview:?}");
                    for moved in preview.moved {
                        let down = moved.from.position.y - moved.to.position.y;
                        assert!(
                            (down - 1.0).abs() < 0.05,
                            "{what}: {i} of the tower, {down} m"
                        );
                    }
                }
            }
        }
    }
}

/// What is placed in the air falls, in whatever steps.
#[test]
fn bodies_placed_in_the_air_fall_in_slow_motion() {
    for last in [1e-7, 1e-4, 1.0 / 960.0] {
        let (app, _) = tower(1, Waking::Islands, last, true);
        let there = Pose {
            position: Vec3::new(3.0, 4.0, 0.0),
            ..Pose::default()
        };
        let preview = preview(app.world(), &Edit::Place(cube(1.0), there)).unwrap();
        let end = preview.end_pose.unwrap().position;
        assert!(
            preview.at_rest && (end.y - 0.5).abs() < 0.01,
            "{last}: {preview:?}"
        );
    }
}

/// Twenty bricks on one that goes took 29 s.
#[test]
fn a_preview_in_slow_motion_takes_a_moment() {
    for (last, dt) in [(1e-4, None), (DT, Some(1e-4)), (1e-7, None)] {
        let (app, cubes) = tower(20, Waking::Islands, last, false);
        let shadow = Shadow::of(app.world(), &Edit::Remove(vec![cubes[0]])).unwrap();
        let settings = PreviewSettings {
            dt,
            ..Default::default()
        };
        let start = Instant::now();
        let preview = shadow.run(&settings).unwrap();
        let took = start.elapsed().as_secs_f32();
        assert!(took < 5.0, "{took} s");
        assert_eq!(preview.moved.len(), 19, "{preview:?}");
    }
}

/// Something that never rests: a preview ends at its time, after a bounded number of steps.
#[test]
fn a_preview_of_what_never_rests_ends() {
    let (mut app, _) = tower(1, Waking::Islands, 1e-6, true);
    let world = app.world_mut();
    let flies = world
        .spawn((
            RigidBody::Dynamic,
            cube(1.0),
            at(0.0, 20.0, 0.0),
            GravityScale(0.0),
            Velocity::linear(Vec3::X),
        ))
        .id();
    steps_of(world, 2, 1e-6);
    let there = Pose {
        position: Vec3::new(0.0, 21.5, 0.0),
        ..Pose::default()
    };
    let preview = preview(world, &Edit::Move(flies, there)).unwrap();
    assert!(
        !preview.at_rest && preview.time >= 10.0 && preview.time < 10.1,
        "{preview:?}"
    );
}
