//! Snapshots that were written to bytes and read again.

use super::*;
use bevy_ecs::entity::EntityHashMap;
use drystone::settings::PhysicsThreads;
use drystone::snapshot::SnapshotError;
use drystone::solver::{Pgs, PointSolver};

/// Writes a snapshot of a world, reads it into another world, and takes steps in both.
#[track_caller]
fn goes_on_from_bytes(name: &str, world: &mut World) {
    let taken = Snapshot::take(world);
    let bytes = taken.to_bytes().unwrap();
    let read = Snapshot::from_bytes(&bytes).unwrap();
    assert!(read.to_bytes().unwrap() == bytes, "{name}");
    let mut other = floor();
    steps(&mut other, 3);
    let map = read.restore(&mut other).unwrap();
    let now = Snapshot::take(&other);
    for before in [taken, read] {
        assert_eq!(before.first_difference(&now, &map), None, "{name}");
    }
    let first = go_on(world, NOTHING, &|entity| entity);
    let again = go_on(&mut other, NOTHING, &|entity| map[&entity]);
    assert_same(name, &first, &again);
}

/// A wall that sleeps, at which a brick is touched, another laid beside it, and another taken.
#[test]
fn a_difference_takes_what_has_changed() {
    let (mut world, bricks) = scene("wall:20x15");
    steps(&mut world, 300);
    let mut earlier = Snapshot::take(&world);
    let whole = earlier.to_bytes().unwrap();
    let first = Snapshot::from_bytes(&whole).unwrap();
    let mut read = first.clone();
    let nothing = Snapshot::take(&world).to_bytes_after(&earlier).unwrap();
    println!(
        "{} bytes, {} if nothing changes",
        whole.len(),
        nothing.len()
    );
    assert!(nothing.len() < 200);
    for step in 0..6 {
        match step {
            1 => world.get_mut::<Velocity>(bricks[40]).unwrap().linear.z = 0.05,
            3 => _ = brick(&mut world, 30.0, 0.25),
            4 => _ = world.despawn(bricks[90]),
            _ => (),
        }
        steps(&mut world, 1);
        let now = Snapshot::take(&world);
        let bytes = now.to_bytes_after(&earlier).unwrap();
        let awake = |&&brick: &&Entity| world.get::<Sleeping>(brick).is_some_and(|it| !it.asleep);
        let awake = bricks.iter().filter(awake).count();
        println!(
            "step {step}: {} bytes, {awake} bricks are awake",
            bytes.len()
        );
        assert!(awake > 100 || 4 * bytes.len() < whole.len());
        if step > 0 {
            let other = Snapshot::from_bytes_after(&bytes, &first);
            assert_eq!(other.unwrap_err(), SnapshotError::OtherEarlier, "{step}");
        }
        read = Snapshot::from_bytes_after(&bytes, &read).unwrap();
        let same = read.to_bytes().unwrap() == now.to_bytes().unwrap();
        assert!(same, "step {step}");
        earlier = now;
    }
    let mut other = floor();
    let map = read.restore(&mut other).unwrap();
    let first = go_on(&mut world, NOTHING, &|entity| entity);
    let again = go_on(&mut other, NOTHING, &|entity| map[&entity]);
    assert_same("differences", &first, &again);
}

/// The tree of one or two boxes, whose numbers are not the first ones.
#[test]
fn a_few_bodies_go_on_from_bytes() {
    for count in 0..4 {
        let mut world = floor();
        for i in 0..count {
            brick(&mut world, 0.2 * i as f32, 0.5 + i as f32);
        }
        steps(&mut world, 10);
        goes_on_from_bytes("few", &mut world);
        brick(&mut world, 0.0, 5.0);
        world.spawn((RigidBody::Static, Collider::half_space(Vec3::X)));
        steps(&mut world, 2);
        goes_on_from_bytes("one more", &mut world);
    }
}

/// Every byte that is changed, and every byte that is missing, is noticed. The world stays as it was.
#[test]
fn damaged_and_foreign_bytes_are_errors() {
    let (mut world, _) = scene("wall:4x3");
    steps(&mut world, 40);
    let before = Snapshot::take(&world);
    let good = before.to_bytes().unwrap();
    let fails = |bytes: &[u8]| Snapshot::from_bytes(bytes).unwrap_err();
    fastrand::seed(7);
    for _ in 0..2_000 {
        let mut bytes = good.clone();
        let at = fastrand::usize(..bytes.len());
        bytes[at] ^= 1 << fastrand::u8(..8);
        fails(&bytes);
        bytes = good[..at].to_vec();
        fails(&bytes);
    }
    for at in 0..64 {
        let mut bytes = good.clone();
        bytes[at] ^= 0x55;
        fails(&bytes);
        fails(&good[..at]);
    }
    assert_eq!(fails(&[&good[..], &[0]].concat()), SnapshotError::Damaged);
    assert_eq!(
        fails(b"not one of ours, but long enough"),
        SnapshotError::Foreign
    );
    assert_eq!(fails(&[]), SnapshotError::Foreign);
    let mut other = good.clone();
    other[8] = 99;
    assert_eq!(
        fails(&other),
        SnapshotError::Version("format 99".to_owned())
    );
    let now = Snapshot::take(&world);
    assert_eq!(
        before.first_difference(&now, &EntityHashMap::default()),
        None
    );
}

/// A solver of the user is code.
#[test]
fn code_is_not_written() {
    let (mut world, _) = scene("wall:3x2");
    let mine: ContactSolver = ContactSolver::Points(
        std::sync::Arc::new(Pgs::default()) as std::sync::Arc<dyn PointSolver>
    );
    world.resource_mut::<SolverSettings>().solver = mine;
    let error = Snapshot::take(&world).to_bytes().unwrap_err();
    assert!(error.to_string().contains("SolverSettings"), "{error}");
    assert_eq!(Snapshot::default().to_bytes(), Err(SnapshotError::Empty));
}

#[test]
fn it_has_the_same_bytes_if_it_is_taken_on_several_threads() {
    let (mut world, ..) = bodies_of_parts();
    let mut taken = [1, 3].map(|threads| {
        let threads = PhysicsThreads::new(threads).unwrap().with_min_items(1);
        world.insert_resource(threads);
        Snapshot::take(&world)
    });
    let [one, three] = taken.each_ref().map(|of| of.to_bytes().unwrap());
    assert!(one == three);
    // Into the memory of another state.
    steps(&mut world, 20);
    world.insert_resource(PhysicsThreads::new(1).unwrap());
    taken[0].take_into(&world);
    world.insert_resource(PhysicsThreads::new(3).unwrap().with_min_items(1));
    taken[1].take_into(&world);
    let [one, three] = taken.each_ref().map(|of| of.to_bytes().unwrap());
    assert!(one == three);
}
