//! A replay goes to any step, forwards and backwards.

use super::*;
use drystone::snapshot::Snapshot;
use std::num::{NonZeroU32, NonZeroUsize};

/// A wall that is built on, with a change before every third step.
fn build(settings: RecorderSettings) -> Recorded {
    let (mut world, bodies) = scene("wall:4x3");
    steps(&mut world, 20);
    let mut laid = Vec::new();
    record_with(settings, world, 60, |world, step| {
        if step % 3 == 0 {
            let x = 0.5 * (step % 4) as f32;
            laid.push(brick(world, x, 2.0 + 0.1 * step as f32));
        }
        match step {
            20 => _ = world.despawn(bodies[2]),
            40 => _ = world.despawn(laid[1]),
            // It is lost with all that was laid since, and comes back with another id.
            50 => {
                let snapshot = Snapshot::take(world);
                world.despawn(laid[0]);
                steps_aside(world);
                snapshot.restore(world).unwrap();
            }
            _ => (),
        }
    })
}

/// Something is spawned and despawned.
fn steps_aside(world: &mut World) {
    let aside = brick(world, 30.0, 1.0);
    world.despawn(aside);
}

#[track_caller]
fn seeks(recorded: &Recorded, keeps: Option<usize>) {
    let recording = Recording::from_bytes(&recorded.bytes).unwrap();
    let mut other = other_world(1);
    let mut replay = Replay::start(&recording, &mut other).unwrap();
    if let Some(keeps) = keeps.and_then(NonZeroUsize::new) {
        replay = replay.with_kept_every(keeps);
    }
    for steps in [10, 11, 60, 30, 29, 31, 0, 1, 45, 52, 20, 21, 60, 59] {
        replay.seek(&mut other, steps).unwrap();
        assert_eq!(replay.steps(), steps);
        if steps > 0 {
            assert_same("seek", steps, &recorded.seen[steps - 1], &bits(&mut other));
        }
        for step in steps..60.min(steps + 4) {
            assert!(replay.step(&mut other).unwrap());
            let name = format!("from {steps}");
            assert_same(&name, step, &recorded.seen[step], &bits(&mut other));
        }
        assert_eq!(replay.divergence(), None, "{steps}");
    }
    let error = replay.seek(&mut other, 61).unwrap_err();
    assert_eq!(
        error.to_string(),
        "the recording has 60 steps, so there is no step 61"
    );
    assert_eq!(replay.steps(), 60);
}

#[test]
fn from_the_start() {
    seeks(&build(RecorderSettings::default()), None);
}

#[test]
fn from_snapshots_that_the_replay_keeps() {
    let recorded = build(RecorderSettings::default());
    seeks(&recorded, Some(7));
    seeks(&recorded, Some(1));
}

#[test]
fn from_snapshots_in_the_recording() {
    let plain = build(RecorderSettings::default());
    for every in [1, 8] {
        let recorded = build(RecorderSettings {
            key_frames_every: NonZeroU32::new(every),
            ..RecorderSettings::default()
        });
        assert!(recorded.bytes.len() > 3 * plain.bytes.len());
        replays("key frames", &recorded);
        seeks(&recorded, None);
        seeks(&recorded, Some(5));
    }
}
