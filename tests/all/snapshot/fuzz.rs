//! Bytes of snapshots that were damaged at random. Reading them never panics, and the world that they are for is not touched.
//!
//! The checksum finds all damage, and so hides the code behind it. So the values are also damaged with a checksum that is right again, as
//! somebody does who means harm. A second checksum, of the values, is compared only after all of them were read. So all code that reads is
//! reached, but no damaged snapshot is restored.

use super::*;
use drystone::snapshot::SnapshotError;
use fastrand::Rng;

/// Name, version and checksum.
const HEAD: usize = 8 + 4 + 8;

/// The checksum that the format uses.
fn checksum(bytes: &[u8]) -> u64 {
    let mix = |hash: u64, number: u64| {
        let product = u128::from(hash ^ number) * 0x9e37_79b9_7f4a_7c15;
        product as u64 ^ (product >> 64) as u64
    };
    let (words, rest) = bytes.as_chunks::<8>();
    let words = words.iter().map(|word| u64::from_le_bytes(*word));
    let rest = rest.iter().copied().map(u64::from);
    let start = bytes.len() as u64;
    words
        .chain(rest)
        .fold(start, |sum, word| mix(sum, word).rotate_left(23))
}

/// The values of a snapshot.
fn values(bytes: &[u8]) -> Vec<u8> {
    lz4_flex::decompress_size_prepended(&bytes[HEAD + 8..]).unwrap()
}

/// Bytes with such values, and a checksum that is right. That of the values themselves stays as it was; it is compared last.
fn repaired(good: &[u8], values: &[u8]) -> Vec<u8> {
    let mut rest = good[HEAD..HEAD + 8].to_vec();
    rest.extend(lz4_flex::compress_prepend_size(values));
    with_checksum(good, &rest)
}

fn with_checksum(good: &[u8], rest: &[u8]) -> Vec<u8> {
    let sum = checksum(rest).to_le_bytes();
    [&good[..HEAD - 8], &sum, rest].concat()
}

/// Flips a bit, sets a byte, cuts bytes out or off, puts some in, or copies some to another place.
fn damage(bytes: &mut Vec<u8>, rng: &mut Rng) {
    if bytes.is_empty() {
        return;
    }
    let at = rng.usize(..bytes.len());
    let len = rng.usize(..=16.min(bytes.len() - at));
    match rng.u8(..8) {
        0 | 1 => bytes[at] ^= 1 << rng.u8(..8),
        2 => bytes[at] = [0, 1, 0x7f, 0x80, 0xff][rng.usize(..5)],
        3 => bytes.truncate(at),
        4 => _ = bytes.drain(at..at + len),
        5 => _ = bytes.splice(at..at, (0..len).map(|_| rng.u8(..))),
        6 => bytes.extend((0..len).map(|_| rng.u8(..))),
        _ => {
            let to = rng.usize(..=bytes.len() - len);
            bytes.copy_within(at..at + len, to);
        }
    }
}

/// Worlds awake and asleep; with joints, mortar, a hull, a mesh, parts, sensors and a hand.
fn worlds() -> Vec<(&'static str, World)> {
    let mut all = vec![("parts", bodies_of_parts().0)];
    for (name, count) in [("wall:4x3", 20), ("wall:4x3", 150), ("bridge:5", 20)] {
        let (mut world, bodies) = scene(name);
        world.entity_mut(bodies[0]).insert(Mortar::default());
        steps(&mut world, count);
        all.push((name, world));
    }
    let mut world = floor();
    let corners = [(0.3, -0.3), (0.3, 0.3), (-0.3, -0.3), (-0.3, 0.3)];
    let mut points: Vec<Vec3> = corners.map(|(x, z)| Vec3::new(x, -0.2, z)).to_vec();
    points.push(Vec3::Y * 0.4);
    body(
        &mut world,
        Collider::convex_hull(&points).unwrap(),
        0.0,
        0.5,
        (),
    );
    let corners = [(-6.0, -6.0), (6.0, -6.0), (6.0, 6.0)];
    let corners = corners.map(|(x, z)| Vec3::new(x, 0.1, z));
    let mesh = Collider::trimesh(corners.to_vec(), vec![[0, 2, 1]]).unwrap();
    world.spawn((RigidBody::Static, mesh));
    world.spawn(Hand::new(5_000.0));
    steps(&mut world, 10);
    all.push(("shapes", world));
    all
}

fn bytes_of(world: &World) -> Vec<u8> {
    Snapshot::take(world).to_bytes().unwrap()
}

/// Each world, so many times damaged in each way.
fn fuzz(times: usize) {
    let mut target = floor();
    for (name, world) in worlds() {
        let good = bytes_of(&world);
        let whole = values(&good);
        assert!(
            repaired(&good, &whole) == good,
            "{name}: this file has the format"
        );
        let mut rng = Rng::with_seed(3);
        let mut restored = 0;
        for time in 0..times {
            // It is shown if one panics.
            println!("{name}, time {time}");
            let mut bytes = good.clone();
            for _ in 0..=rng.usize(..3) {
                damage(&mut bytes, &mut rng);
            }
            match Snapshot::from_bytes(&bytes) {
                Ok(read) => assert!(read.to_bytes().unwrap() == good, "{name}, time {time}"),
                Err(error) => assert_ne!(error, SnapshotError::Empty),
            }
            // What is compressed, and its checksum.
            let mut rest = good[HEAD..].to_vec();
            damage(&mut rest, &mut rng);
            try_to_restore(&with_checksum(&good, &rest), &mut target);
            let mut values = whole.clone();
            for _ in 0..=rng.usize(..3) {
                damage(&mut values, &mut rng);
            }
            restored += usize::from(try_to_restore(&repaired(&good, &values), &mut target));
        }
        println!("{name}: {restored} of {times} restored");
    }
}

/// Reads bytes and restores what was read, if there is something. After an error the world is as it was.
fn try_to_restore(bytes: &[u8], target: &mut World) -> bool {
    let Ok(read) = Snapshot::from_bytes(bytes) else {
        return false;
    };
    let before = Snapshot::take(target);
    let result = read.restore(target);
    if result.is_err() {
        let now = Snapshot::take(target);
        assert_eq!(before.first_difference(&now, &Default::default()), None);
    }
    result.is_ok()
}

#[test]
fn damaged_bytes_do_no_harm() {
    fuzz(60);
}

#[test]
#[ignore = "it takes minutes"]
fn damaged_bytes_do_no_harm_often() {
    fuzz(20_000);
}
