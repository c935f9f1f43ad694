//! What recorders and replays promise, and what they cannot know.

use super::*;
use bevy_app::App;
use drystone::recording::{RecordingError, RecordingPlugin};
use drystone::snapshot::SnapshotError;
use drystone::solver::{Pgs, PointSolver};
use std::sync::Arc;

/// A change that the recorder does not see is found: in which step, and of which body.
#[test]
fn a_change_that_is_left_out_is_found() {
    let (mut world, bodies) = scene("wall:4x3");
    let moved = *bodies.last().unwrap();
    world.entity_mut(moved).insert(Name::new("the last brick"));
    let recorded = record(world, 40, |world, step| {
        if step == 17 {
            let mut velocity = world.get_mut::<Velocity>(moved).unwrap();
            velocity.bypass_change_detection().linear.y = 1e-3;
        }
    });
    assert_eq!(changes(&recorded), [0; 0]);
    let recording = Recording::from_bytes(&recorded.bytes).unwrap();
    let mut other = other_world(1);
    let mut replay = Replay::start(&recording, &mut other).unwrap();
    replay.seek(&mut other, 17).unwrap();
    assert_eq!(replay.divergence(), None);
    replay.step(&mut other).unwrap();
    let found = replay.divergence().unwrap().clone();
    assert_eq!(found.step, 17);
    // Its island is solved as a whole, so another brick of it may come first.
    assert!(found.body.is_some() && found.spawn_order.is_some());
    while replay.step(&mut other).unwrap() {}
    assert_eq!(replay.divergence(), Some(&found), "it is the first");
    assert!(found.to_string().starts_with("step 17 differs: body"));
    // Before it, nothing differs.
    replay.seek(&mut other, 10).unwrap();
    assert_eq!(replay.divergence(), None);
}

/// A ball that touches nothing is named.
#[test]
fn the_body_that_differs_is_named() {
    let mut world = floor();
    for i in 0..5 {
        let name = Name::new(format!("ball {i}"));
        body(&mut world, Collider::ball(0.3), 2.0 * i as f32, 50.0, name);
    }
    let mut balls = world.query_filtered::<Entity, With<Name>>();
    let balls: Vec<Entity> = balls.iter(&world).collect();
    let recorded = record(world, 10, |world, step| {
        if step == 4 {
            let mut velocity = world.get_mut::<Velocity>(balls[3]).unwrap();
            velocity.bypass_change_detection().linear.x = 1e-3;
        }
    });
    let recording = Recording::from_bytes(&recorded.bytes).unwrap();
    let mut other = other_world(1);
    let mut replay = Replay::start(&recording, &mut other).unwrap();
    while replay.step(&mut other).unwrap() {}
    let found = replay.divergence().unwrap();
    let name = recorded.world.get::<Name>(balls[3]).unwrap();
    assert_eq!(found.step, 4);
    assert_eq!(found.name.as_deref(), Some(name.as_str()));
    assert_eq!(found.body, replay.entity(balls[3]));
}

/// Recording changes no bit, and leaves nothing behind.
#[test]
fn a_world_that_is_recorded_goes_on_as_it_would() {
    let [recorded, plain] = [true, false].map(|records| {
        let (mut world, bodies) = scene("wall:5x4");
        if records {
            Recorder::start(&mut world, RecorderSettings::default()).unwrap();
        }
        for step in 0..60 {
            if step == 20 {
                world.despawn(bodies[1]);
                brick(&mut world, 0.0, 3.0);
            }
            steps(&mut world, 1);
        }
        if records {
            Recorder::stop(&mut world).unwrap();
        }
        let mut observers = world.query::<&Observer>();
        (bits(&mut world), observers.iter(&world).count())
    });
    assert_eq!(recorded, plain);
}

/// A replay may be recorded, and gives the same recording but for the ids of entities.
#[test]
fn a_replay_is_recorded() {
    let (world, bodies) = scene("wall:4x3");
    let recorded = record(world, 30, |world, step| match step {
        10 => _ = world.despawn(bodies[1]),
        15 => _ = brick(world, 0.0, 2.0),
        _ => (),
    });
    let recording = Recording::from_bytes(&recorded.bytes).unwrap();
    let mut other = other_world(1);
    let mut replay = Replay::start(&recording, &mut other).unwrap();
    Recorder::start(&mut other, RecorderSettings::default()).unwrap();
    while replay.step(&mut other).unwrap() {}
    let bytes = Recorder::stop(&mut other).unwrap();
    let again = Recorded { bytes, ..recorded };
    replays("again", &again);
    assert_eq!(changes(&again), [10, 15]);
}

#[test]
fn a_world_is_recorded_once_at_a_time() {
    let (mut world, _) = scene("wall:3x2");
    let not = RecordingError::IsNotRecording;
    assert_eq!(Recorder::stop(&mut world), Err(not.clone()));
    let start = |world: &mut World| Recorder::start(world, RecorderSettings::default());
    assert_eq!(start(&mut world), Ok(()));
    assert_eq!(start(&mut world), Err(RecordingError::IsRecording));
    steps(&mut world, 3);
    // It is of use while it goes on.
    let bytes = world.resource::<Recorder>().bytes().to_vec();
    let recording = Recording::from_bytes(&bytes).unwrap();
    assert_eq!((recording.steps(), recording.is_whole()), (3, false));
    assert!(Recorder::stop(&mut world).unwrap().len() > bytes.len());
    assert_eq!(Recorder::stop(&mut world), Err(not));
    assert_eq!(start(&mut world), Ok(()));
    let empty = RecordingError::Snapshot(SnapshotError::Empty);
    assert_eq!(start(&mut World::new()), Err(empty));
}

/// Code cannot be written. A recording that has begun ends with the last step before.
#[test]
fn code_ends_a_recording() {
    let mine = || -> ContactSolver {
        ContactSolver::Points(Arc::new(Pgs::default()) as Arc<dyn PointSolver>)
    };
    let (mut world, _) = scene("wall:3x2");
    Recorder::start(&mut world, RecorderSettings::default()).unwrap();
    steps(&mut world, 5);
    world.resource_mut::<SolverSettings>().solver = mine();
    steps(&mut world, 5);
    let recorder = world.resource::<Recorder>();
    let error = recorder.error().unwrap().clone();
    assert!(error.to_string().contains("SolverSettings"), "{error}");
    assert_eq!(recorder.steps(), 5);
    assert_eq!(Recording::from_bytes(recorder.bytes()).unwrap().steps(), 5);
    assert_eq!(Recorder::stop(&mut world), Err(error));
    // It may start again when it can.
    let start = |world: &mut World| Recorder::start(world, RecorderSettings::default());
    assert!(start(&mut world).is_err());
    world.insert_resource(SolverSettings::default());
    // The settings of the last step belong to the state.
    assert!(start(&mut world).is_err());
    steps(&mut world, 1);
    assert_eq!(start(&mut world), Ok(()));
}

/// A replay needs the plugins. The world stays as it was.
#[test]
fn a_plugin_is_missing() {
    let recorded = record(floor(), 3, |_, _| ());
    let recording = Recording::from_bytes(&recorded.bytes).unwrap();
    let mut app = App::new();
    app.add_plugins(DrystonePlugins::default());
    let ball = brick(app.world_mut(), 0.0, 0.0);
    let error = Replay::start(&recording, app.world_mut()).unwrap_err();
    assert!(error.to_string().contains("Collapse"), "{error}");
    assert!(app.world().get_entity(ball).is_ok());
}

#[test]
fn an_app_is_recorded_from_the_beginning() {
    let mut app = App::new();
    app.add_plugins((
        DrystonePlugins::default(),
        RecordingPlugin::default(),
        HandPlugin,
        CollapsePlugin,
    ));
    app.add_systems(bevy_app::Startup, |mut commands: Commands| {
        commands.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
        commands.spawn((RigidBody::Dynamic, Collider::ball(0.5), place(0.0, 2.0)));
    });
    app.finish();
    app.cleanup();
    app.update();
    let world = app.world_mut();
    let mut seen = Vec::new();
    for _ in 0..20 {
        steps(world, 1);
        seen.push(bits(world));
    }
    let bytes = Recorder::stop(world).unwrap();
    let world = std::mem::take(world);
    let recorded = Recorded { world, bytes, seen };
    assert_eq!(changes(&recorded), [0]);
    replays("app", &recorded);
}
