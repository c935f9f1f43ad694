//! Bodies of cells: what lies and rolls on them, what falls off them, and what an edit costs.

use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::body::Sleeping;
use drystone::prelude::*;
use drystone::snapshot::Snapshot;
use std::time::Instant;
use support::*;

fn steps(lab: &mut Lab, count: usize) {
    (0..count).for_each(|_| lab.step());
}

/// A level floor at y = 0 of cells of 0.25 m, with holes and pillars below it, so that it is cut into many boxes and 5 × 5 chunks.
fn floor(lab: &mut Lab) -> Entity {
    let mut voxels = Voxels::new(0.25);
    voxels.set_box(IVec3::new(-40, -1, -40), IVec3::new(40, 0, 40), true);
    let mut rng = fastrand::Rng::with_seed(3);
    for _ in 0..2000 {
        let (x, z) = (rng.i32(-40..40), rng.i32(-40..40));
        voxels.set_box(
            IVec3::new(x, -rng.i32(2..6), z),
            IVec3::new(x + 1, -1, z + 1),
            true,
        );
    }
    lab.spawn((RigidBody::Static, voxels))
}

/// Bodies that roll and slide, each with its height and its velocity.
fn movers() -> Vec<(&'static str, Collider, f32, Velocity)> {
    let along = Vec3::new(2.0, 0.0, 0.7);
    let rolls = |radius: f32| Velocity {
        linear: along,
        angular: Vec3::Y.cross(along) / radius,
    };
    vec![
        ("ball", Collider::ball(0.3), 0.3, rolls(0.3)),
        ("small ball", Collider::ball(0.08), 0.08, rolls(0.08)),
        (
            "box",
            Collider::cuboid(0.5, 0.3, 0.4),
            0.15,
            Velocity::linear(1.5 * along),
        ),
        (
            "hull",
            Collider::wedge(0.6, 0.3, 0.4).unwrap(),
            0.15,
            Velocity::linear(1.5 * along),
        ),
        (
            "plate",
            Collider::cuboid(2.0, 0.2, 1.6),
            0.1,
            Velocity::linear(1.5 * along),
        ),
    ]
}

/// What rolls or slides over cells does so as over a plane.
#[test]
fn nothing_feels_the_seams_of_a_level_floor() {
    for (name, collider, height, velocity) in movers() {
        let runs = [false, true].map(|on_cells| {
            let mut lab = Lab::new();
            match on_cells {
                true => _ = floor(&mut lab),
                false => _ = lab.ground(),
            }
            let friction = Friction::new(0.1);
            let at =
                Transform::from_xyz(-4.1, height, -2.3).with_rotation(Quat::from_rotation_y(0.3));
            let velocity = match name.contains("ball") {
                true => velocity,
                false => Velocity {
                    linear: velocity.linear,
                    angular: Vec3::Y,
                },
            };
            let body = lab.spawn((RigidBody::Dynamic, collider.clone(), at, velocity, friction));
            let mut path = Vec::new();
            for _ in 0..90 {
                lab.step();
                path.push((lab.pose(body).position, lab.velocity(body).linear));
            }
            path
        });
        let [plane, cells] = runs;
        let (mut apart, mut hop) = (0.0_f32, 0.0_f32);
        for (plane, cells) in plane.iter().zip(&cells) {
            apart = apart.max((plane.0 - cells.0).length());
            hop = hop.max((cells.0.y - height).abs());
        }
        println!(
            "{name}: apart {:.2} mm, up or down {:.3} mm",
            1e3 * apart,
            1e3 * hop
        );
        // Friction acts at other points than on a plane, which matters to what turns.
        let most = if name.contains("ball") { 1e-3 } else { 2e-2 };
        assert!(apart < most && hop < 2e-4, "{name}: {apart} m, {hop} m");
    }
}

#[test]
fn mass_and_inertia_are_those_of_the_cells() {
    let mut lab = Lab::new();
    let mut block = Voxels::new(0.1);
    block.set_box(IVec3::new(-5, -10, -20), IVec3::new(5, 10, 20), true);
    let voxels = lab.spawn((RigidBody::Dynamic, block, Density(700.0)));
    let whole = (
        RigidBody::Dynamic,
        Collider::cuboid(1.0, 2.0, 4.0),
        Density(700.0),
    );
    let whole = lab.spawn((whole, Transform::from_xyz(20.0, 0.0, 0.0)));
    lab.step();
    let [voxels, whole] = [voxels, whole].map(|body| lab.mass(body));
    assert!((voxels.mass() / whole.mass() - 1.0).abs() < 1e-5);
    assert!(
        voxels.local_center.length() < 1e-5,
        "{}",
        voxels.local_center
    );
    let sorted = |inertia: Vec3| {
        let mut moments = inertia.to_array();
        moments.sort_by(f32::total_cmp);
        Vec3::from_array(moments)
    };
    let ratio = sorted(voxels.inverse_inertia) / sorted(whole.inverse_inertia);
    assert!((ratio - 1.0).abs().max_element() < 1e-4, "{ratio}");
}

/// Bricks lie on a hill and sleep; what is dug away below them lets them fall, and no others wake for long.
#[test]
fn a_hill_is_dug_below_what_lies_on_it() {
    let mut lab = Lab::new();
    let mut hill = Voxels::new(0.25);
    hill.set_box(IVec3::new(-32, -12, -32), IVec3::new(32, 0, 32), true);
    let hill = lab.spawn((RigidBody::Static, hill));
    let bricks: Vec<Entity> = (0..5)
        .map(|i| {
            lab.spawn((
                RigidBody::Dynamic,
                Collider::cuboid(0.5, 0.3, 0.5),
                Transform::from_xyz(-4.0 + 2.0 * i as f32, 0.15, 0.3),
            ))
        })
        .collect();
    steps(&mut lab, 60);
    let asleep = |lab: &Lab, brick: Entity| lab.world.get::<Sleeping>(brick).unwrap().asleep;
    assert!(bricks.iter().all(|brick| asleep(&lab, *brick)));
    let mut grid = lab.world.get_mut::<Voxels>(hill).unwrap();
    let dug = grid.set_box(IVec3::new(-2, -4, -2), IVec3::new(2, 0, 4), false);
    assert_eq!(dug, 4 * 4 * 6);
    steps(&mut lab, 60);
    assert!(
        (lab.pose(bricks[2]).position.y + 0.85).abs() < 1e-3,
        "{}",
        lab.pose(bricks[2]).position
    );
    for &brick in bricks[..2].iter().chain(&bricks[3..]) {
        assert!((lab.pose(brick).position.y - 0.15).abs() < 1e-4 && asleep(&lab, brick));
    }
    // It is filled again around a brick that flew away.
    lab.world.despawn(bricks[2]);
    let mut grid = lab.world.get_mut::<Voxels>(hill).unwrap();
    assert_eq!(
        grid.set_box(IVec3::new(-2, -4, -2), IVec3::new(2, 0, 4), true),
        dug
    );
    let ball = lab.body(Collider::ball(0.2), Vec3::new(0.0, 0.5, 0.3));
    steps(&mut lab, 60);
    assert!(
        (lab.pose(ball).position.y - 0.2).abs() < 1e-3,
        "{}",
        lab.pose(ball).position
    );
}

/// The momentum and angular momentum about the origin of all dynamic bodies, and their mass.
fn momentum(lab: &mut Lab) -> (f32, Vec3, Vec3) {
    let mut bodies = lab
        .world
        .query::<(&RigidBody, &Pose, &Velocity, &MassProperties)>();
    let mut sum = (0.0, Vec3::ZERO, Vec3::ZERO);
    for (kind, pose, velocity, mass) in bodies.iter(&lab.world) {
        if *kind == RigidBody::Dynamic {
            let linear = mass.mass() * velocity.linear;
            let frame = pose.rotation * mass.local_frame;
            let spin = frame * (frame.inverse() * velocity.angular / mass.inverse_inertia);
            sum.0 += mass.mass();
            sum.1 += linear;
            sum.2 += spin + pose.transform_point(mass.local_center).cross(linear);
        }
    }
    sum
}

/// A dumbbell in flight that turns is cut through: the two halves fly on as they flew.
#[test]
fn a_body_that_is_cut_flies_on_as_two() {
    for by_hand in [false, true] {
        let mut lab = Lab::new();
        lab.world.insert_resource(Gravity(Vec3::ZERO));
        let mut bell = Voxels::new(0.1);
        bell.set_box(IVec3::new(-10, -3, -3), IVec3::new(-4, 3, 3), true);
        bell.set_box(IVec3::new(4, -2, -2), IVec3::new(9, 2, 2), true);
        bell.set_box(IVec3::new(-4, 0, 0), IVec3::new(4, 1, 1), true);
        let motion = Velocity {
            linear: Vec3::new(1.0, 2.0, 0.0),
            angular: Vec3::new(0.5, 1.0, 2.0),
        };
        let at = Transform::from_xyz(1.0, 2.0, 3.0).with_rotation(Quat::from_rotation_z(0.5));
        let bell = lab.spawn((RigidBody::Dynamic, bell, motion, at));
        if by_hand {
            lab.world.entity_mut(bell).insert(Mass(10.0));
        }
        lab.step();
        let before = momentum(&mut lab);
        // The middle of the bar: one cell of 200 or so.
        lab.world
            .get_mut::<Voxels>(bell)
            .unwrap()
            .set(IVec3::ZERO, false);
        drystone::refresh(&mut lab.world);
        let after = momentum(&mut lab);
        let count = lab.world.query::<&Voxels>().iter(&lab.world).count();
        assert_eq!(count, 2);
        let share = match by_hand {
            true => 1.0,
            false => after.0 / before.0,
        };
        assert!(
            (after.0 / before.0 / share - 1.0).abs() < 1e-4,
            "{before:?} {after:?}"
        );
        if by_hand {
            assert!((after.0 - 10.0).abs() < 1e-3, "{}", after.0);
        }
        // The cell that is gone has taken some with it: that of a point of the bar.
        let lost = before.0 - after.0;
        let of_lost = (before.1 - after.1).length();
        assert!(of_lost <= 4.0 * lost + 0.05, "{before:?} {after:?}");
        steps(&mut lab, 30);
        let later = momentum(&mut lab);
        assert!(
            (later.1 - after.1).length() < 1e-3 * after.1.length(),
            "{after:?} {later:?}"
        );
    }
}

/// A tree that is cut at its foot falls; a bridge with two ends stays after one is cut; both keep their cells.
#[test]
fn what_is_no_longer_joined_falls() {
    let mut lab = Lab::new();
    let mut land = Voxels::new(0.25);
    land.set_box(IVec3::new(-20, -4, -20), IVec3::new(20, 0, 20), true);
    land.set_box(IVec3::new(0, 0, 0), IVec3::new(2, 12, 2), true);
    land.set_box(IVec3::new(-4, 12, -4), IVec3::new(6, 15, 6), true);
    land.set_box(IVec3::new(-15, 0, 8), IVec3::new(-13, 6, 10), true);
    land.set_box(IVec3::new(-5, 0, 8), IVec3::new(-3, 6, 10), true);
    land.set_box(IVec3::new(-15, 6, 8), IVec3::new(-3, 8, 10), true);
    let all = land.count();
    let land = lab.spawn((RigidBody::Static, land, Friction::new(0.9)));
    lab.step();
    let parts = |lab: &mut Lab| {
        let mut parts = lab.world.query::<(Entity, &RigidBody, &Voxels)>();
        let parts = parts
            .iter(&lab.world)
            .filter(|(_, kind, _)| **kind == RigidBody::Dynamic);
        parts
            .map(|(entity, _, voxels)| (entity, voxels.count()))
            .collect::<Vec<_>>()
    };
    let cut = |lab: &mut Lab, from: IVec3, to: IVec3| {
        let mut grid = lab.world.get_mut::<Voxels>(land).unwrap();
        let gone = grid.set_box(from, to, false);
        lab.step();
        gone
    };
    let mut gone = cut(&mut lab, IVec3::new(-5, 2, 8), IVec3::new(-3, 3, 10));
    assert_eq!(parts(&mut lab), []);
    gone += cut(&mut lab, IVec3::new(0, 1, 0), IVec3::new(2, 2, 2));
    let fallen = parts(&mut lab);
    assert_eq!(fallen.len(), 1);
    let left = lab.world.get::<Voxels>(land).unwrap().count();
    assert_eq!(left + fallen[0].1 + gone, all);
    assert_eq!(
        lab.world.get::<Friction>(fallen[0].0),
        Some(&Friction::new(0.9))
    );
    let top = lab.pose(fallen[0].0).position.y;
    steps(&mut lab, 120);
    assert!(lab.pose(fallen[0].0).position.y < top - 0.2);
    let kept = Voxels::new(0.25).with_splits(false);
    assert!(!kept.splits());
}

/// What is cut off before the first step falls from where it was put.
#[test]
fn a_body_may_be_cut_before_its_first_step() {
    let mut lab = Lab::new();
    lab.world.insert_resource(Gravity(Vec3::ZERO));
    let mut bar = Voxels::new(0.5);
    bar.set_box(IVec3::ZERO, IVec3::new(9, 1, 1), true);
    bar.set(IVec3::new(6, 0, 0), false);
    let at = Transform::from_xyz(10.0, 20.0, 30.0);
    lab.spawn((RigidBody::Dynamic, bar, at));
    lab.step();
    let mut bodies = lab.world.query::<(&Pose, &Voxels)>();
    let mut found: Vec<_> = bodies.iter(&lab.world).collect();
    found.sort_by_key(|(_, cells)| cells.count());
    let found: Vec<_> = found
        .into_iter()
        .map(|(pose, cells)| (cells.count(), pose.position))
        .collect();
    assert_eq!(
        found,
        [(2, Vec3::new(13.5, 20.0, 30.0)), (6, at.translation)]
    );
}

#[test]
fn a_body_becomes_static_and_dynamic_again() {
    let mut lab = Lab::new();
    lab.ground();
    let mut cube = Voxels::new(0.5);
    cube.set_box(IVec3::ZERO, IVec3::new(2, 20, 2), true);
    let tower = lab.spawn((RigidBody::Dynamic, cube, Transform::from_xyz(0.0, 0.5, 0.0)));
    steps(&mut lab, 60);
    assert!(lab.pose(tower).position.y.abs() < 1e-3);
    *lab.world.get_mut::<RigidBody>(tower).unwrap() = RigidBody::Static;
    steps(&mut lab, 2);
    assert!(lab.world.get::<Collider>(tower).is_none());
    let ball = lab.body(Collider::ball(0.2), Vec3::new(0.5, 10.4, 0.5));
    steps(&mut lab, 60);
    assert!(
        (lab.pose(ball).position.y - 10.2).abs() < 1e-3,
        "{}",
        lab.pose(ball).position
    );
    *lab.world.get_mut::<RigidBody>(tower).unwrap() = RigidBody::Dynamic;
    steps(&mut lab, 30);
    assert!(lab.world.get::<Collider>(tower).is_some());
    assert!(
        (lab.pose(ball).position.y - 10.2).abs() < 2e-3,
        "{}",
        lab.pose(ball).position
    );
    // Without cells it has no shape.
    lab.world
        .get_mut::<Voxels>(tower)
        .unwrap()
        .set_box(IVec3::ZERO, IVec3::new(2, 20, 2), false);
    steps(&mut lab, 120);
    assert!(lab.pose(ball).position.y < 0.3);
    let bodies = lab.world.query::<&RigidBody>().iter(&lab.world).count();
    lab.world.despawn(tower);
    assert_eq!(
        lab.world.query::<&RigidBody>().iter(&lab.world).count(),
        bodies - 1
    );
}

/// A static grid that is moved takes its chunks along, also below a parent; they go with it.
#[test]
fn chunks_go_with_their_body() {
    let mut lab = Lab::new();
    let island = lab.world.spawn(Transform::from_xyz(0.0, 3.0, 0.0)).id();
    let mut slab = Voxels::new(0.5);
    slab.set_box(IVec3::new(-20, -2, -20), IVec3::new(20, 0, 20), true);
    let slab = lab.spawn((RigidBody::Static, slab, ChildOf(island)));
    let ball = lab.body(Collider::ball(0.2), Vec3::new(0.3, 3.2, 0.3));
    steps(&mut lab, 60);
    assert!((lab.pose(ball).position.y - 3.2).abs() < 1e-3);
    lab.world
        .get_mut::<Transform>(island)
        .unwrap()
        .translation
        .y = 2.0;
    steps(&mut lab, 60);
    assert!(
        (lab.pose(ball).position.y - 2.2).abs() < 1e-3,
        "{}",
        lab.pose(ball).position
    );
    let mut chunks = lab.world.query::<&VoxelChunk>();
    assert!(chunks.iter(&lab.world).all(|chunk| chunk.0 == slab));
    assert_eq!(chunks.iter(&lab.world).count(), 16);
    lab.world.despawn(island);
    assert_eq!(chunks.iter(&lab.world).count(), 0);
    steps(&mut lab, 60);
    assert!(lab.pose(ball).position.y < 1.0);
}

#[test]
fn a_dug_hill_comes_back_from_a_snapshot() {
    let mut lab = Lab::new();
    let hill = floor(&mut lab);
    lab.body(Collider::ball(0.3), Vec3::new(0.0, 0.5, 0.0));
    steps(&mut lab, 5);
    let dig = |lab: &mut Lab| {
        let mut grid = lab.world.get_mut::<Voxels>(hill).unwrap();
        grid.set_ball(Vec3::new(0.2, -0.2, 0.1), 0.8, false);
        steps(lab, 60);
        lab.bits()
    };
    let snapshot = Snapshot::take(&lab.world);
    let first = dig(&mut lab);
    snapshot.restore(&mut lab.world).unwrap();
    assert_eq!(dig(&mut lab), first);
}

/// Hills of 256³ cells: memory, and the time of a shot of 200 cells.
#[test]
#[ignore = "measures time and memory"]
fn hills_of_256_cells_are_small_and_dug_at_once() {
    let resident = || {
        let text = std::fs::read_to_string("/proc/self/statm").unwrap();
        let pages: f64 = text.split_whitespace().nth(1).unwrap().parse().unwrap();
        pages * 4096.0 / 1e6
    };
    let mut lab = Lab::new();
    lab.step();
    let before = resident();
    let height = |x: i32, z: i32| {
        let (x, z) = (x as f32 / 40.0, z as f32 / 40.0);
        (128.0 + 60.0 * (x.sin() * z.cos()) + 12.0 * (3.1 * x + z).sin()) as i32
    };
    let start = Instant::now();
    let mut hill = Voxels::new(0.25);
    for x in 0..256 {
        for z in 0..256 {
            hill.set_box(
                IVec3::new(x, 0, z),
                IVec3::new(x + 1, height(x, z), z + 1),
                true,
            );
        }
    }
    let (count, surface) = (hill.count(), hill.faces().count());
    let filled = start.elapsed();
    let hill = lab.spawn((RigidBody::Static, hill));
    let start = Instant::now();
    lab.step();
    let first = start.elapsed();
    steps(&mut lab, 5);
    println!(
        "{count} cells, {surface} open faces: filled in {filled:.1?}, first step {first:.1?}, {:.1} MB",
        resident() - before
    );
    assert!(resident() - before < 64.0);
    let start = Instant::now();
    steps(&mut lab, 100);
    println!(
        "a step at rest: {:.3} ms",
        start.elapsed().as_secs_f64() * 10.0
    );
    let mut times = Vec::new();
    for i in 0..60 {
        let (x, z) = (20 + 37 * i % 216, 20 + 53 * i % 216);
        let center = Vec3::new(x as f32, height(x, z) as f32, z as f32) * 0.25;
        let start = Instant::now();
        let taken = lab
            .world
            .get_mut::<Voxels>(hill)
            .unwrap()
            .set_ball(center, 1.15, false);
        drystone::refresh(&mut lab.world);
        times.push((start.elapsed().as_secs_f64() * 1e3, taken));
        lab.step();
    }
    let mean =
        |of: &dyn Fn(&(f64, usize)) -> f64| times.iter().map(of).sum::<f64>() / times.len() as f64;
    let worst = times.iter().map(|time| time.0).fold(0.0, f64::max);
    println!(
        "a shot of {:.0} cells: {:.2} ms, at most {worst:.2}",
        mean(&|time| time.1 as f64),
        mean(&|time| time.0)
    );
    let start = Instant::now();
    let mut grid = lab.world.get_mut::<Voxels>(hill).unwrap();
    (0..1000).for_each(|i| _ = grid.set(IVec3::new(i % 200, 3, i / 200), false));
    println!("a cell: {:.2} µs", start.elapsed().as_secs_f64() * 1e3);
    anchor(&height);
    assert!(mean(&|time| time.0) < 1.0);
}

/// The same hill and shots with parry's voxels, which neither split nor have mass.
fn anchor(height: &dyn Fn(i32, i32) -> i32) {
    use parry3d::math::IVector;
    use parry3d::shape::Voxels;
    let start = Instant::now();
    let mut cells = Vec::new();
    for (x, z) in (0..256).flat_map(|x| (0..256).map(move |z| (x, z))) {
        cells.extend((0..height(x, z)).map(|y| IVector::new(x, y, z)));
    }
    let mut hill = Voxels::new(Vec3::splat(0.25), &cells);
    println!(
        "parry: filled in {:.1?}, {:.1} MB",
        start.elapsed(),
        hill.total_memory_size() as f64 / 1e6
    );
    let start = Instant::now();
    let mut taken = 0;
    for i in 0..60 {
        let (x, z) = (20 + 37 * i % 216, 20 + 53 * i % 216);
        let center = IVector::new(x, height(x, z), z);
        for at in (0..1000).map(|i| IVector::new(i % 10 - 5, i / 10 % 10 - 5, i / 100 - 5)) {
            if at.as_vec3().length() <= 4.6 && !hill.set_voxel(center + at, false).is_empty() {
                taken += 1;
            }
        }
    }
    let time = start.elapsed().as_secs_f64() * 1e3 / 60.0;
    println!("parry: a shot of {} cells: {time:.2} ms", taken / 60);
}
