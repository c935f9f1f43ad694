//! Bytes that nobody wrote, with the right checksums.

use super::*;
use drystone::collider::{ColliderShape, CompoundPart};
use drystone::recording::{Recorder, RecorderSettings, Recording};
use drystone::snapshot::Snapshot;
use std::sync::OnceLock;

/// As the library's.
fn checksum(bytes: &[u8]) -> [u8; 8] {
    let mix = |hash: u64, number: u64| {
        let product = u128::from(hash ^ number) * 0x9e37_79b9_7f4a_7c15;
        product as u64 ^ (product >> 64) as u64
    };
    let (words, rest) = bytes.as_chunks::<8>();
    let words = words.iter().map(|word| u64::from_le_bytes(*word));
    let rest = rest.iter().copied().map(u64::from);
    let sum = words.chain(rest).fold(bytes.len() as u64, |sum, word| {
        mix(sum, word).rotate_left(23)
    });
    sum.to_le_bytes()
}

/// The values of a snapshot.
fn open(bytes: &[u8]) -> Vec<u8> {
    lz4_flex::decompress_size_prepended(&bytes[28..]).unwrap()
}

/// A snapshot with other values than it had. The checksum of the values themselves is compared after they were read.
fn close(bytes: &[u8], values: &[u8]) -> Vec<u8> {
    let mut rest = bytes[20..28].to_vec();
    rest.extend(lz4_flex::compress_prepend_size(values));
    [&bytes[..12], &checksum(&rest), &rest].concat()
}

fn length(mut number: usize) -> Vec<u8> {
    let mut out = Vec::new();
    while number >= 0x80 {
        out.push(number as u8 | 0x80);
        number >>= 7;
    }
    out.push(number as u8);
    out
}

/// Reads on a thread with the stack of a worker, and returns whether it went well. An overflow would end the process.
fn reads(read: impl FnOnce() -> bool + Send + 'static) -> bool {
    std::thread::Builder::new()
        .stack_size(2 << 20)
        .spawn(read)
        .unwrap()
        .join()
        .unwrap()
}

/// A scene with all kinds of shapes, a joint and a child, and its bytes.
fn scene() -> &'static [u8] {
    static SCENE: OnceLock<Vec<u8>> = OnceLock::new();
    SCENE.get_or_init(|| {
        let mut app = app();
        let world = app.world_mut();
        let steps_of_field = vec![vec![0.0, 0.1], vec![0.2, 0.0]];
        let field = Collider::height_field(&steps_of_field, Vec3::new(20.0, 1.0, 20.0)).unwrap();
        world.spawn((RigidBody::Static, field));
        let part = |x: f32| (Vec3::X * x, Quat::IDENTITY, cube(0.5));
        let pair = Collider::compound(vec![part(0.0), part(0.5)]).unwrap();
        let one = world
            .spawn((RigidBody::Dynamic, pair, at(0.0, 1.0, 0.0)))
            .id();
        let wedge = Collider::wedge(1.0, 0.5, 1.0).unwrap();
        let other = world
            .spawn((RigidBody::Dynamic, wedge, at(2.0, 1.0, 0.0)))
            .id();
        world.spawn((cube(0.3), at(0.0, 0.5, 0.0), ChildOf(other)));
        world.spawn(RevoluteJoint::new(one, other).with_angle_limits(-1.0, 1.0));
        steps(world, 40);
        Snapshot::take(world).to_bytes().unwrap()
    })
}

#[test]
fn a_snapshot_is_what_these_tests_take_it_for() {
    let bytes = scene();
    assert_eq!(close(bytes, &open(bytes))[..28], bytes[..28]);
    assert!(Snapshot::from_bytes(&close(bytes, &open(bytes))).is_ok());
}

/// The bytes of a compound within a compound, and so on.
fn nested(depth: usize) -> Vec<u8> {
    let of = |parts| postcard::to_allocvec(&ColliderShape::Compound { parts }).unwrap();
    let ball = ColliderShape::Ball { radius: 0.5 };
    let shape = postcard::to_allocvec(&ball).unwrap();
    let part = CompoundPart {
        position: Vec3::ZERO,
        rotation: Quat::IDENTITY,
        shape: ball,
    };
    let outer = of(vec![part]);
    let around = &outer[..outer.len() - shape.len()];
    let mut all = around.repeat(depth);
    all.extend(shape);
    all
}

#[test]
fn compounds_within_each_other_are_damage_and_no_overflow() {
    let bytes = scene();
    // In the place of the first compound of the scene.
    let part = |x: f32| CompoundPart {
        position: Vec3::X * x,
        rotation: Quat::IDENTITY,
        shape: ColliderShape::Cuboid {
            half_extents: Vec3::splat(0.25),
        },
    };
    let known = ColliderShape::Compound {
        parts: vec![part(0.0), part(0.5)],
    };
    let known = postcard::to_allocvec(&known).unwrap();
    let known = [length(known.len() + 1), known].concat();
    let values = open(bytes);
    let start = values
        .windows(known.len())
        .position(|part| part == known)
        .unwrap();
    for depth in [1, 2, 3, 20_000, 1_000_000] {
        let shape = nested(depth);
        let shape = [length(shape.len() + 1), shape].concat();
        let values = [&values[..start], &shape, &values[start + known.len()..]].concat();
        let crafted = close(bytes, &values);
        // The sum of the values is another one even where the shape may be read.
        assert!(
            !reads(move || Snapshot::from_bytes(&crafted).is_ok()),
            "{depth}"
        );
        let shape = nested(depth);
        let is_read = reads(move || postcard::from_bytes::<Collider>(&shape).is_ok());
        assert_eq!(is_read, depth == 1, "{depth}");
        let shape = nested(depth);
        let is_read = reads(move || postcard::from_bytes::<ColliderShape>(&shape).is_ok());
        assert_eq!(is_read, depth == 1, "{depth}");
    }
    // The thread reads compounds still.
    assert!(postcard::from_bytes::<Collider>(&nested(1)).is_ok());
    assert!(postcard::from_bytes::<Collider>(&nested(2)).is_err());
    assert!(postcard::from_bytes::<Collider>(&nested(1)).is_ok());
}

/// A compound that is spawned in a recording is replaced by one that nests.
#[test]
fn a_recording_with_compounds_within_each_other_is_damaged() {
    let mut app = app();
    let world = app.world_mut();
    Recorder::start(world, RecorderSettings::default()).unwrap();
    steps(world, 1);
    let part = |x: f32| (Vec3::X * x, Quat::IDENTITY, cube(0.5));
    let pair = Collider::compound(vec![part(0.0), part(0.5)]).unwrap();
    let known = postcard::to_allocvec(&pair).unwrap();
    world.spawn((RigidBody::Dynamic, pair));
    steps(world, 1);
    let bytes = Recorder::stop(world).unwrap();
    assert!(Recording::from_bytes(&bytes).is_ok());
    let place = bytes
        .windows(known.len())
        .position(|part| part == known)
        .unwrap();
    // The chunks: name and version of the file, then heads of 17 bytes and contents.
    let (mut start, mut end) = (12, 12);
    while end <= place {
        start = end;
        let length = bytes[start + 1..start + 5].try_into().unwrap();
        end = start + 17 + u32::from_le_bytes(length) as usize;
    }
    for depth in [1, 2, 20_000, 1_000_000] {
        let mut contents = [
            &bytes[start + 17..place],
            &nested(depth),
            &bytes[place + known.len()..end],
        ]
        .concat();
        // Flags, and the length of the changes.
        let changes = contents.len() as u32 - 5;
        contents[1..5].copy_from_slice(&changes.to_le_bytes());
        let mut head = bytes[start..start + 17].to_vec();
        head[1..5].copy_from_slice(&(contents.len() as u32).to_le_bytes());
        head[5..13].copy_from_slice(&checksum(&contents));
        let sum = checksum(&head[..13]);
        head[13..].copy_from_slice(&sum[..4]);
        let crafted = [&bytes[..start], &head, &contents, &bytes[end..]].concat();
        assert_eq!(
            reads(move || Recording::from_bytes(&crafted).is_ok()),
            depth == 1,
            "{depth}"
        );
    }
}

/// A chain of bodies, each below the one before, goes on in another world.
#[test]
fn a_deep_hierarchy_overflows_no_stack() {
    let goes_on = || {
        let mut app = app();
        let world = app.world_mut();
        let mut above = world.spawn((RigidBody::Static, Transform::default())).id();
        for _ in 0..2_000 {
            above = world.spawn((Transform::default(), ChildOf(above))).id();
        }
        let lowest = (
            RigidBody::Dynamic,
            cube(0.5),
            at(0.0, 2.0, 0.0),
            ChildOf(above),
        );
        let lowest = world.spawn(lowest).id();
        steps(world, 3);
        let bytes = Snapshot::take(world).to_bytes().unwrap();
        let mut other = self::app();
        let other = other.world_mut();
        let ids = Snapshot::from_bytes(&bytes)
            .unwrap()
            .restore(other)
            .unwrap();
        steps(world, 3);
        steps(other, 3);
        world.get::<Pose>(lowest) == other.get::<Pose>(ids[&lowest])
    };
    // On so small a stack a function that calls itself for each parent overflows.
    let thread = std::thread::Builder::new().stack_size(256 << 10);
    assert!(thread.spawn(goes_on).unwrap().join().unwrap());
}

/// No entity is below itself.
#[test]
fn a_hierarchy_that_goes_round_is_damage() {
    let mut app = app();
    let world = app.world_mut();
    let [a, b] = [0.0, 9.0].map(|x| {
        world
            .spawn((RigidBody::Static, cube(1.0), at(x, 0.0, 0.0)))
            .id()
    });
    let c = world.spawn((RigidBody::Static, cube(1.0), ChildOf(b))).id();
    steps(world, 1);
    world.entity_mut(b).insert(ChildOf(a));
    let good = Snapshot::take(world).to_bytes().unwrap();
    assert!(Snapshot::from_bytes(&good).is_ok());
    world.entity_mut(a).insert(ChildOf(c));
    let bad = Snapshot::take(world).to_bytes().unwrap();
    assert!(Snapshot::from_bytes(&bad).is_err());
}
