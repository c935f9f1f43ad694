//! Recordings that are cut off or damaged.

use super::*;
use drystone::recording::RecordingError;

/// Length of the head of a chunk.
const HEAD: usize = 17;

fn small() -> Recorded {
    let (mut world, bodies) = scene("wall:3x2");
    steps(&mut world, 5);
    record(world, 12, |world, step| match step {
        3 => _ = brick(world, 0.0, 2.0),
        7 => _ = world.despawn(bodies[0]),
        _ => (),
    })
}

/// A recording that ends anywhere is of use up to there.
#[test]
fn a_recording_that_is_cut_off_has_the_steps_before() {
    let recorded = small();
    let good = &recorded.bytes;
    let (mut most, mut replayed) = (0, 0);
    // The snapshot is one chunk.
    let start = 12 + HEAD + u32::from_le_bytes(good[13..17].try_into().unwrap()) as usize;
    let places = (0..start).step_by(97).chain(start - HEAD..good.len());
    for len in places {
        match Recording::from_bytes(&good[..len]) {
            Ok(recording) => {
                assert!(!recording.is_whole(), "{len}");
                assert!(recording.steps() >= most, "{len}");
                if recording.steps() > most {
                    let mut other = other_world(1);
                    let mut replay = Replay::start(&recording, &mut other).unwrap();
                    while replay.step(&mut other).unwrap() {
                        let step = replay.steps() - 1;
                        assert_same("cut off", step, &recorded.seen[step], &bits(&mut other));
                    }
                    assert_eq!(replay.divergence(), None);
                    replayed += 1;
                }
                most = recording.steps();
            }
            Err(error) => {
                assert_eq!(most, 0, "{len}");
                let expected = [RecordingError::Foreign, RecordingError::Empty];
                assert!(expected.contains(&error), "{error}");
            }
        }
    }
    assert_eq!((most, replayed), (12, 12));
}

/// Every byte that was changed is noticed.
#[test]
fn damaged_and_foreign_bytes_are_errors() {
    let recorded = small();
    let good = &recorded.bytes;
    let fails = |bytes: &[u8]| Recording::from_bytes(bytes).unwrap_err();
    fastrand::seed(11);
    let places = (0..400).map(|_| fastrand::usize(..good.len()));
    let last = good.len() - 600.min(good.len())..good.len();
    for at in places.chain(0..64).chain(last) {
        let mut bytes = good.clone();
        bytes[at] ^= 1 << fastrand::u8(..8);
        fails(&bytes);
    }
    assert_eq!(
        fails(&[&good[..], &[0]].concat()),
        RecordingError::Damaged { steps: 12 }
    );
    assert_eq!(
        fails(b"not one of ours, but long enough"),
        RecordingError::Foreign
    );
    let mut other = good.clone();
    other[8] = 99;
    assert_eq!(
        fails(&other),
        RecordingError::Version("format 99".to_owned())
    );
    // In the last third there are steps only.
    let mut bytes = good.clone();
    let at = bytes.len() - 40;
    bytes[at] ^= 1;
    assert!(matches!(
        fails(&bytes),
        RecordingError::Damaged { steps: 1.. }
    ));
}

/// Chunks in another order, twice, or missing, each of them good.
#[test]
fn chunks_out_of_order_do_no_harm() {
    let recorded = small();
    let (start, mut rest) = recorded.bytes.split_at(12);
    let mut chunks = Vec::new();
    while !rest.is_empty() {
        let len: [u8; 4] = rest[1..5].try_into().unwrap();
        let (chunk, others) = rest.split_at(HEAD + u32::from_le_bytes(len) as usize);
        chunks.push(chunk);
        rest = others;
    }
    fastrand::seed(3);
    for _ in 0..200 {
        let mut chunks = chunks.clone();
        let [i, j] = [(); 2].map(|()| fastrand::usize(1..chunks.len()));
        match fastrand::u8(..3) {
            0 => chunks.swap(i, j),
            1 => _ = chunks.remove(i),
            _ => chunks.insert(i, chunks[j]),
        }
        let bytes = [start, &chunks.concat()].concat();
        if let Ok(recording) = Recording::from_bytes(&bytes) {
            let mut other = other_world(1);
            let mut replay = Replay::start(&recording, &mut other).unwrap();
            while replay.step(&mut other).unwrap() {}
        }
    }
}

#[test]
fn a_recording_goes_to_a_file_and_is_read_from_it() {
    let name = format!("drystone-{}.recording", std::process::id());
    let path = std::env::temp_dir().join(name);
    let settings = RecorderSettings {
        path: Some(path.clone()),
        ..RecorderSettings::default()
    };
    let (world, _) = scene("wall:3x2");
    let recorded = record_with(settings.clone(), world, 100, |world, step| {
        if step == 70 {
            brick(world, 0.0, 3.0);
        }
    });
    assert!(recorded.bytes.is_empty());
    let bytes = std::fs::read(&path).unwrap();
    let recorded = Recorded { bytes, ..recorded };
    replays("file", &recorded);
    assert_eq!(Recording::read(&path).unwrap().steps(), 100);

    // The game ends within a step.
    let (mut world, _) = scene("wall:3x2");
    Recorder::start(&mut world, settings).unwrap();
    steps(&mut world, 10);
    brick(&mut world, 0.0, 3.0);
    let mut schedules = world.resource_mut::<Schedules>();
    let step = schedules.get_mut(PhysicsSchedule).unwrap();
    step.add_systems(|| panic!("a bug"));
    let panicked = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| steps(&mut world, 1)));
    assert!(panicked.is_err());
    drop(world);
    let recording = Recording::read(&path).unwrap();
    assert!(!recording.is_whole());
    assert_eq!(recording.steps(), 11);
    assert_eq!(recording.changes().collect::<Vec<_>>(), [10]);
    std::fs::remove_file(&path).unwrap();
    assert!(matches!(
        Recording::read(&path),
        Err(RecordingError::File(_))
    ));
}
