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

#[test]
fn a_heap_a_wall_and_a_bridge_go_on_from_bytes() {
    for (name, number) in [
        ("heap:20", 40),
        ("wall:6x4", 29),
        ("wall:6x4", 150),
        ("bridge:9", 20),
    ] {
        let (mut world, _) = scene(name);
        steps(&mut world, number);
        goes_on_from_bytes(name, &mut world);
    }
}

/// Hulls are told apart by their place in memory, and so are meshes.
#[test]
fn shapes_that_many_bodies_share_go_on_from_bytes() {
    let mut world = empty();
    let corners = [(-6.0, -6.0), (6.0, -6.0), (6.0, 6.0), (-6.0, 6.0)];
    let corners = corners.map(|(x, z)| Vec3::new(x, 0.0, z));
    let mesh = Collider::trimesh(corners.to_vec(), vec![[0, 2, 1], [0, 3, 2]]).unwrap();
    world.spawn((RigidBody::Static, mesh));
    let peak = [(0.3, -0.3), (0.3, 0.3), (-0.3, -0.3), (-0.3, 0.3)];
    let mut points: Vec<Vec3> = peak.iter().map(|&(x, z)| Vec3::new(x, -0.2, z)).collect();
    points.push(Vec3::Y * 0.4);
    let hull = Collider::convex_hull(&points).unwrap();
    for i in 0..4 {
        body(&mut world, hull.clone(), 1.5 * i as f32, 0.5, ());
    }
    let cube = Collider::cuboid(0.5, 0.5, 0.5);
    let parent = body(&mut world, cube.clone(), -2.0, 0.3, ());
    world.spawn((cube, place(0.5, 0.0), bevy_ecs::hierarchy::ChildOf(parent)));
    steps(&mut world, 30);
    goes_on_from_bytes("hulls", &mut world);
}

/// Parry keeps which parts touch, and the axes between them.
#[test]
fn compounds_children_meshes_and_height_fields_go_on_from_bytes() {
    let heights = vec![
        vec![0.0, 0.2, 0.0],
        vec![0.3, 0.0, 0.1],
        vec![0.0, 0.1, 0.4],
    ];
    let field = Collider::height_field(&heights, Vec3::new(12.0, 1.0, 12.0)).unwrap();
    let half_space = Collider::half_space(Vec3::Y);
    for ground in [half_space, scenes::triangles(), field] {
        for number in [20, 35, 50, 90] {
            let mut world = scenes::compounds_on(ground.clone());
            for i in 0..3 {
                body(
                    &mut world,
                    Collider::cuboid(1.0, 0.5, 0.5),
                    1.2 * i as f32 - 2.0,
                    2.5,
                    (),
                );
            }
            steps(&mut world, number);
            goes_on_from_bytes("compounds", &mut world);
        }
    }
    let (mut world, ..) = bodies_of_parts();
    for _ in 0..6 {
        steps(&mut world, 7);
        goes_on_from_bytes("children", &mut world);
    }
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
