//! Recordings: a replay goes on to the same bits as the world that was recorded, whatever was changed from outside.

mod bytes;
mod chance;
mod edits;
mod rules;
mod scenes;
mod seeking;

use crate::snapshot::{DT, bits, bodies_of_parts, body, brick, floor, place, scene, steps};
use bevy_ecs::prelude::*;
use drystone::prelude::*;
use drystone::recording::{Recorder, RecorderSettings, Recording, Replay};
use drystone::settings::PhysicsThreads;

/// What is seen of a world after a step: in spawn order, the bits of bodies, joints and contacts.
type Seen = Vec<(Vec<SpawnOrder>, Vec<u32>)>;

/// A world that was recorded, and what was seen of it after each step.
struct Recorded {
    world: World,
    bytes: Vec<u8>,
    seen: Vec<Seen>,
}

/// Records so many steps of a world, with changes before each.
#[track_caller]
fn record(world: World, count: usize, act: impl FnMut(&mut World, usize)) -> Recorded {
    record_with(RecorderSettings::default(), world, count, act)
}

#[track_caller]
fn record_with(
    settings: RecorderSettings,
    mut world: World,
    count: usize,
    mut act: impl FnMut(&mut World, usize),
) -> Recorded {
    Recorder::start(&mut world, settings).unwrap();
    let seen = (0..count).map(|step| {
        act(&mut world, step);
        steps(&mut world, 1);
        bits(&mut world)
    });
    let seen = seen.collect();
    let recorder = world.resource::<Recorder>();
    assert_eq!((recorder.steps(), recorder.error()), (count, None));
    let bytes = Recorder::stop(&mut world).unwrap();
    Recorded { world, bytes, seen }
}

/// A world with other entities that has simulated something else.
fn other_world(threads: usize) -> World {
    let mut other = floor();
    let threads = PhysicsThreads::new(threads).unwrap();
    other.insert_resource(threads.with_min_items(1));
    other.spawn_batch((0..7).map(|_| ()));
    for i in 0..3 {
        brick(&mut other, i as f32, 0.3);
    }
    steps(&mut other, 5);
    other
}

/// Replays a recording on one thread and on three, in worlds with other entities. What is seen is the same.
#[track_caller]
fn replays(name: &str, recorded: &Recorded) {
    let recording = Recording::from_bytes(&recorded.bytes).unwrap();
    assert!(recording.is_whole(), "{name}");
    assert_eq!(recording.steps(), recorded.seen.len(), "{name}");
    for threads in [1, 3] {
        let mut other = other_world(threads);
        let mut replay = Replay::start(&recording, &mut other).unwrap();
        for (step, seen) in recorded.seen.iter().enumerate() {
            assert!(replay.step(&mut other).unwrap());
            let divergence = replay.divergence();
            assert_eq!(divergence, None, "{name}, {threads} threads");
            assert_same(name, step, seen, &bits(&mut other));
        }
        assert!(!replay.step(&mut other).unwrap(), "{name}");
    }
}

#[track_caller]
fn assert_same(name: &str, step: usize, seen: &Seen, again: &Seen) {
    let orders = |seen: &Seen| seen.iter().map(|of| of.0.clone()).collect::<Vec<_>>();
    assert_eq!(orders(seen), orders(again), "{name}: step {step}");
    for (one, other) in seen.iter().zip(again) {
        assert_eq!(one, other, "{name}: step {step}");
    }
}

/// Records, and replays.
#[track_caller]
fn goes_again(name: &str, world: World, count: usize, act: impl FnMut(&mut World, usize)) {
    replays(name, &record(world, count, act));
}

/// The number of changes that a recording has.
fn changes(recorded: &Recorded) -> Vec<usize> {
    let recording = Recording::from_bytes(&recorded.bytes).unwrap();
    recording.changes().collect()
}
