//! All engines of this build are held against closed forms and against each other.

use crate::arguments::{Arguments, Command};
use crate::body::Body;
use crate::compare::compare;
use crate::engine::Engine;
use crate::joint;
use crate::meter::{Metered, Overlaps};
use crate::own::Drystone;
use crate::peer::Peer;
use crate::rapier::{self, Ground, Rapier};
use crate::scene::{self, Conditions, Start};
use bevy_ecs::entity::Entity;
use bevy_transform::components::Transform;
use clap::Parser;
use drystone::body::MassProperties;
use drystone::prelude::{
    Collider, Friction, Pose, Quat, RigidBody, SphericalJoint, Vec3, Velocity,
};
use drystone_lab::experiment::Run;
use drystone_lab::metrics::Displacement;
use drystone_lab::scenes;
use std::fs;
use std::path::PathBuf;

const CONDITIONS: Conditions = Conditions {
    dt: 1.0 / 60.0,
    threads: 1,
    ground: scenes::Ground::HalfSpace,
    sleeping: false,
};

const G: f32 = 9.81;

fn options(ground: Ground) -> rapier::Options {
    rapier::Options {
        iterations: None,
        ground,
    }
}

/// Drystone and all others with a scene, which may be changed before they get it.
fn all_with(
    scene: &str,
    ground: Ground,
    change: impl FnOnce(&mut Run),
) -> (Vec<Box<dyn Engine>>, Vec<Body>) {
    let (mut run, _, joints) = scene::build(scene.parse().unwrap(), 1, CONDITIONS).unwrap();
    change(&mut run);
    let bodies = scene::read(&mut run);
    let start = Start::of(&run, &bodies, &joints, CONDITIONS);
    let peers = Peer::BUILT.iter();
    let mut engines: Vec<_> = peers
        .map(|peer| peer.start(&start, options(ground)).unwrap())
        .collect();
    engines.insert(
        0,
        Box::new(Drystone::new(run.world, &bodies, CONDITIONS.dt)),
    );
    (engines, bodies)
}

/// A start without joints.
fn unjointed(bodies: &[Body]) -> Start<'_> {
    Start {
        bodies,
        joints: &[],
        gravity: Vec3::NEG_Y * G,
        conditions: CONDITIONS,
    }
}

fn all(scene: &str) -> (Vec<Box<dyn Engine>>, Vec<Body>) {
    all_with(scene, Ground::Slab, |_| ())
}

fn steps(engine: &mut dyn Engine, count: usize) {
    for _ in 0..count {
        engine.step();
    }
}

#[test]
fn all_start_with_the_same_poses() {
    for scene in MASSES {
        let (engines, bodies) = all(scene);
        // Drystone's are written by its first step.
        for engine in &engines[1..] {
            for (body, pose) in bodies.iter().zip(engine.poses()) {
                assert_eq!(pose, body.pose, "{scene} in {}", engine.name());
            }
        }
    }
}

/// Mass, kg, centre, m, and principal inertia, kg m², in whatever order.
type Mass = (f32, Vec3, [f32; 3]);

#[track_caller]
fn same_mass(scene: &str, a: Mass, b: Mass) {
    // Moments of hulls are rounded otherwise in parry than in drystone.
    let same = |a: f32, b: f32| (a - b).abs() <= 1e-3 * a.abs().max(b.abs());
    assert!(same(a.0, b.0), "{scene}: {} kg and {} kg", a.0, b.0);
    assert!(a.1.distance(b.1) < 1e-4, "{scene}: {} and {}", a.1, b.1);
    // The choice of the first axis is arbitrary.
    let sorted = |mut inertia: [f32; 3]| {
        inertia.sort_by(f32::total_cmp);
        inertia
    };
    for (a, b) in sorted(a.2).into_iter().zip(sorted(b.2)) {
        assert!(same(a, b), "{scene}: {a} and {b}");
    }
}

const MASSES: [&str; 14] = [
    "wall:4x4",
    "arch:7",
    "heap:20",
    "massratio:100",
    "rolling",
    "chain:3",
    "ragdolls:1",
    "compounds:3x7",
    "voxels:3x9",
    "convex_pile:2",
    "rain:1",
    "tumbler:hinge:2",
    "junkyard:2",
    "field_drop:8",
];

/// Drystone's own masses of a scene's dynamic bodies, computed in its first step, with their indices.
fn own_masses(scene: &str) -> (Vec<(usize, Mass)>, Vec<Body>) {
    let (run, bodies, _) = scene::build(scene.parse().unwrap(), 1, CONDITIONS).unwrap();
    let mut drystone = Drystone::new(run.world, &bodies, CONDITIONS.dt);
    drystone.step();
    let dynamic = bodies.iter().enumerate();
    let dynamic = dynamic.filter(|(_, body)| body.kind == RigidBody::Dynamic);
    let masses = dynamic.map(|(i, body)| {
        let mass = drystone.world().get::<MassProperties>(body.entity).unwrap();
        let inertia = mass.inverse_inertia.to_array().map(f32::recip);
        (i, (mass.mass(), mass.local_center, inertia))
    });
    (masses.collect(), bodies)
}

#[test]
fn rapier_has_the_same_masses() {
    for scene in MASSES {
        let (own, bodies) = own_masses(scene);
        let mut rapier = Rapier::new(&unjointed(&bodies), options(Ground::HalfSpace)).unwrap();
        // It computes them in its first step.
        rapier.step();
        let others: Vec<_> = rapier.bodies().collect();
        for (i, own) in own {
            let mass = others[i].mass_properties().local_mprops;
            let inertia = mass.inv_principal_inertia.to_array().map(f32::recip);
            same_mass(scene, own, (others[i].mass(), mass.local_com, inertia));
        }
    }
}

#[cfg(feature = "box3d")]
#[test]
fn box3d_has_the_same_masses() {
    use rapier3d::math::Matrix;
    use rapier3d::parry::mass_properties::MassProperties;
    for scene in MASSES {
        let (own, bodies) = own_masses(scene);
        let box3d = crate::box3d::Box3d::new(&unjointed(&bodies)).unwrap();
        for (i, own) in own {
            let (mass, center, [x, y, z]) = box3d.mass(i);
            let inertia = Matrix::from_cols(x, y, z);
            let principal = MassProperties::with_inertia_matrix(center, mass, inertia);
            let principal = principal.principal_inertia().to_array();
            same_mass(scene, own, (mass, center, principal));
        }
    }
}

/// Rapier and Box3D let it sink by some millimetres, Box3D by 5 at most (its `B3_LINEAR_SLOP`).
#[test]
fn a_cube_stands_on_the_ground_where_it_was_put() {
    let (mut engines, bodies) = all("stack:1");
    for engine in &mut engines {
        let name = engine.name();
        steps(engine, 120);
        let pose = engine.poses()[1];
        let start = bodies[1].pose.position;
        let sunk = start.y - pose.position.y;
        let most = if name == "drystone" { 1e-4 } else { 5.1e-3 };
        assert!(sunk.abs() < most, "{name}: sunk by {sunk} m");
        let aside = (pose.position - start).with_y(0.0).length();
        assert!(aside < 1e-4, "{name}: {aside} m aside");
        let speed = engine.velocities()[0].linear.length();
        assert!(speed < 1e-3, "{name}: {speed} m/s");
        let overlap = Overlaps::new(&bodies, &[]).deepest(&engine.poses());
        let expected = (0.5 - pose.position.y).max(0.0);
        assert!((overlap - expected).abs() < 1e-5, "{name}: {overlap} m");
    }
}

/// ½gt² lies between what an engine says that moves by the speed before a step and one that moves by the speed after it; they
/// differ by gtΔt.
#[test]
fn a_ball_falls_as_bodies_do() {
    let raise = |run: &mut Run| {
        let ball = run.bodies[0];
        let mut ball = run.world.entity_mut(ball);
        ball.get_mut::<Transform>().unwrap().translation.y += 20.0;
        *ball.get_mut::<Velocity>().unwrap() = Velocity::default();
    };
    let (mut engines, bodies) = all_with("rolling", Ground::Slab, raise);
    let t = 1.0;
    for engine in &mut engines {
        let name = engine.name();
        steps(engine, 60);
        let fallen = bodies[1].pose.position - engine.poses()[1].position;
        let off = fallen.y - 0.5 * G * t * t;
        let limit = 0.5 * G * t * CONDITIONS.dt + 1e-3;
        assert!(off.abs() < limit, "{name}: off by {off} m");
        assert!(fallen.with_y(0.0).length() < 1e-6, "{name}: {fallen}");
        let speed = engine.velocities()[0].linear.y;
        assert!((speed + G * t).abs() < 1e-3, "{name}: {speed} m/s");
    }
}

#[test]
fn a_slab_meets_the_same_ground_in_all() {
    // Below and above the angle of friction, 26.6°.
    for ground in [Ground::HalfSpace, Ground::Slab] {
        for (scene, slope) in [("incline:20", 20f32), ("incline:32", 32.0)] {
            let (sin, cos) = slope.to_radians().sin_cos();
            // ½ (g sin α − μ g cos α) t², t = 1 s
            let expected = (0.5 * G * (sin - 0.5 * cos)).max(0.0);
            let (mut engines, bodies) = all_with(scene, ground, |_| ());
            for engine in &mut engines {
                steps(engine, 60);
                let moved = engine.poses()[1].position.distance(bodies[1].pose.position);
                let name = engine.name();
                assert!(
                    (moved - expected).abs() < 0.04,
                    "{scene} on {ground:?} in {name}: {moved} m, not {expected}"
                );
            }
        }
    }
}

/// No engine drops it, and voussoirs that just touch do not overlap.
#[test]
fn an_arch_stands_for_a_second() {
    let (mut engines, bodies) = all("arch:7");
    let start: Vec<Pose> = bodies.iter().map(|body| body.pose).collect();
    let overlap = Overlaps::new(&bodies, &[]).deepest(&start);
    assert!(overlap < 1e-5, "{overlap} m at the start");
    for engine in &mut engines {
        steps(engine, 60);
        let (name, poses) = (engine.name(), engine.poses());
        let moved = Displacement::between(&start, &poses);
        assert!(moved.drift < 0.05 && moved.sag < 0.05, "{name}: {moved:?}");
        let overlap = Overlaps::new(&bodies, &[]).deepest(&poses);
        assert!(overlap < 0.02, "{name}: {overlap} m");
    }
}

/// Joints are where the scene has them, and hold in every engine.
#[test]
fn joints_hold_in_all() {
    // Elsewhere joints stretch by centimetres; frames that went over wrongly would be further apart.
    // Drystone solves a chain directly, and sweeps the joints of ragdolls.
    for (scene, own) in [("chain:5", 1e-3), ("ragdolls:1", 8e-3)] {
        let (_, _, joints) = scene::build(scene.parse().unwrap(), 1, CONDITIONS).unwrap();
        let (mut engines, bodies) = all(scene);
        let start: Vec<Pose> = bodies.iter().map(|body| body.pose).collect();
        assert!(!joints.is_empty() && joint::stretch(&joints, &start) < 1e-5);
        for engine in &mut engines {
            for _ in 0..60 {
                engine.step();
                let stretch = joint::stretch(&joints, &engine.poses());
                let name = engine.name();
                let most = if name == "drystone" { own } else { 0.08 };
                assert!(stretch < most, "{scene} in {name}: {stretch} m");
            }
        }
    }
}

/// A motor has the same sense and speed in all, and what is kinematic turns as it should.
#[test]
fn drums_turn_alike() {
    for scene in ["tumbler:hinge:1", "tumbler:kinematic:1", "washer:1"] {
        let (mut engines, bodies) = all(scene);
        let drum = bodies
            .iter()
            .position(|body| body.collider.shape().as_compound().is_some())
            .unwrap();
        for engine in &mut engines {
            steps(engine, 60);
            let pose = engine.poses()[drum];
            let turned = pose.rotation * Vec3::X;
            let expected = Quat::from_rotation_z(25f32.to_radians()) * Vec3::X;
            let off = turned.distance(expected);
            let name = engine.name();
            assert!(off < 2e-2, "{scene} in {name}: off by {off}");
            let moved = pose.position.distance(bodies[drum].pose.position);
            assert!(moved < 2e-2, "{scene} in {name}: {moved} m");
        }
    }
}

/// Bodies come to rest on waves in all, not below them: triangles and fields are where they should be, and face up.
#[test]
fn waves_carry_in_all() {
    for scene in ["mesh_drop:8", "field_drop:8"] {
        let (mut engines, bodies) = all(scene);
        for engine in &mut engines {
            steps(engine, 240);
            let overlap = Overlaps::new(&bodies, &[]).deepest(&engine.poses());
            let name = engine.name();
            assert!(overlap < 0.03, "{scene} in {name}: {overlap} m");
            let poses = engine.poses();
            let low = poses[1..].iter().map(|pose| pose.position.y);
            let low = low.fold(f32::INFINITY, f32::min);
            assert!(low > 0.1, "{scene} in {name}: at {low} m");
        }
    }
}

/// What a filter or a joint keeps apart is not counted, and neither engine lets it collide.
#[test]
fn filters_hold_in_all() {
    let (_, bodies, joints) = scene::build("rain:1".parse().unwrap(), 1, CONDITIONS).unwrap();
    let start: Vec<Pose> = bodies.iter().map(|body| body.pose).collect();
    let overlap = Overlaps::new(&bodies, &joints).deepest(&start);
    assert!(overlap < 0.01, "{overlap} m at the start");
    assert!(Overlaps::new(&bodies, &[]).deepest(&start) > 0.05);
    // Balls of a net are 0.8 m wide and could not be 0.5 m apart.
    let near = |run: &mut Run| {
        for (i, &ball) in run.bodies.clone().iter().enumerate() {
            let mut ball = run.world.entity_mut(ball);
            ball.get_mut::<Transform>().unwrap().translation = Vec3::new(0.5 * i as f32, 9.0, 0.0);
        }
        let joints = run
            .world
            .query_filtered::<Entity, bevy_ecs::query::With<SphericalJoint>>();
        let joints: Vec<Entity> = { joints }.iter(&run.world).collect();
        joints
            .into_iter()
            .for_each(|joint| assert!(run.world.despawn(joint)));
    };
    let (run, _, _) = scene::build("joint_grid:2".parse().unwrap(), 1, CONDITIONS).unwrap();
    let mut run = run;
    near(&mut run);
    let bodies = scene::read(&mut run);
    let start = unjointed(&bodies);
    let peers = Peer::BUILT.iter();
    let mut engines: Vec<_> = peers
        .map(|peer| peer.start(&start, options(Ground::Slab)).unwrap())
        .collect();
    engines.push(Box::new(Drystone::new(run.world, &bodies, CONDITIONS.dt)));
    for engine in &mut engines {
        steps(engine, 30);
        for (body, pose) in bodies.iter().zip(engine.poses()) {
            let aside = (pose.position - body.pose.position).with_y(0.0).length();
            assert!(aside < 1e-4, "{}: {aside} m", engine.name());
        }
    }
}

/// A swinging net keeps its energy to a share, and a clump in flight all of it.
#[test]
fn energy_is_kept() {
    for (scene, lost) in [("flyers:2:5", 1e-4), ("joint_grid:corner:4", 0.2)] {
        let (run, bodies, joints) = scene::build(scene.parse().unwrap(), 1, CONDITIONS).unwrap();
        let start = Start::of(&run, &bodies, &joints, CONDITIONS);
        let engine = Drystone::new(run.world, &bodies, CONDITIONS.dt);
        let mut metered = Metered::new(engine, &start);
        metered.steps(60);
        let outcome = metered.outcome();
        let gained = outcome.energy_gain;
        assert!((-lost..1e-3).contains(&gained), "{scene}: {gained}");
        assert!(outcome.busy_time.mean <= outcome.busy_time.largest);
    }
}

#[test]
fn overlap_is_what_was_built() {
    let (engines, bodies) = all("overlap:0.125");
    let deepest = Overlaps::new(&bodies, &[]).deepest(&engines[1].poses());
    assert!((deepest - 0.125).abs() < 1e-5, "{deepest}");
}

/// Both engines take a body that is no number out of the simulation and leave it where it was.
#[test]
fn what_is_lost_has_fallen() {
    let (run, bodies, _) = scene::build("stack:3".parse().unwrap(), 1, CONDITIONS).unwrap();
    let mut rapier = Rapier::new(&unjointed(&bodies), options(Ground::Slab)).unwrap();
    rapier.lose(2);
    let mut drystone = Drystone::new(run.world, &bodies, CONDITIONS.dt);
    let lost = bodies[2].entity;
    let nowhere = Velocity::linear(Vec3::NAN);
    drystone.world().entity_mut(lost).insert(nowhere);
    let engines: [Box<dyn Engine>; 2] = [Box::new(drystone), Box::new(rapier)];
    for engine in engines {
        let mut metered = Metered::new(engine, &unjointed(&bodies));
        metered.steps(5);
        let outcome = metered.outcome();
        assert!(outcome.fell_at.is_some() && outcome.displacement.has_fallen());
        assert!(outcome.rms_speed.is_nan() && outcome.overlap == f32::INFINITY);
        assert!(outcome.stretch.is_none());
    }
}

#[test]
fn a_scene_with_a_hand_is_refused() {
    let error = scene::build("pressed:5".parse().unwrap(), 1, CONDITIONS).err();
    assert!(error.unwrap().contains("pressed:5"));
}

fn body(collider: Collider, friction: f32) -> Body {
    Body {
        entity: Entity::PLACEHOLDER,
        kind: RigidBody::Dynamic,
        collider,
        pose: Pose {
            position: Vec3::Y,
            rotation: Quat::IDENTITY,
        },
        velocity: Velocity::default(),
        density: 1000.0,
        friction: Friction::new(friction),
        restitution: Default::default(),
        layers: Default::default(),
    }
}

/// Puts bodies into Box3D.
fn into_box3d(bodies: &[Body], threads: usize) -> Result<Box<dyn Engine>, String> {
    let start = Start {
        bodies,
        joints: &[],
        gravity: Vec3::NEG_Y * G,
        conditions: Conditions {
            threads,
            ..CONDITIONS
        },
    };
    Peer::Box3d.start(&start, options(Ground::Slab))
}

#[track_caller]
fn refused(started: Result<Box<dyn Engine>, String>, why: &str) {
    let error = started.err().expect("an error");
    assert!(error.contains(why), "{error}");
}

#[cfg(not(feature = "box3d"))]
#[test]
fn an_engine_that_was_not_built_is_refused() {
    let bodies = [body(Collider::ball(0.5), 0.5)];
    refused(into_box3d(&bodies, 1), "--features box3d");
}

#[cfg(feature = "box3d")]
#[test]
fn what_box3d_lacks_is_refused() {
    let ball = || body(Collider::ball(0.5), 0.5);
    refused(
        into_box3d(&[body(Collider::cone(0.5, 1.0), 0.5)], 1),
        "Cone",
    );
    refused(
        into_box3d(&[ball(), body(Collider::ball(0.5), 0.6)], 1),
        "surfaces combine",
    );
    refused(into_box3d(&[ball()], 33), "--threads 33: Box3D has 32");
    // Corners that it would weld.
    let speck: Vec<Vec3> = (0..8)
        .map(|i| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32) * 1e-4)
        .collect();
    if let Ok(speck) = Collider::convex_hull(&speck) {
        refused(into_box3d(&[body(speck, 0.5)], 1), "Box3D makes");
    }
    // The same of other shapes, and on two threads, is taken.
    let capsule = body(Collider::capsule(0.2, 0.5), 0.5);
    let mut engine = into_box3d(&[ball(), capsule], 2).unwrap();
    steps(&mut engine, 3);
    assert!(engine.poses().iter().all(Pose::is_finite));
}

/// More worlds than one at a time, made and dropped on several threads.
#[cfg(feature = "box3d")]
#[test]
fn worlds_of_box3d_know_nothing_of_each_other() {
    let run = || {
        let (mut engines, _) = all("stack:3");
        let box3d = engines.pop().unwrap();
        let mut box3d = box3d;
        steps(&mut box3d, 30);
        (box3d.name(), box3d.poses())
    };
    let alone = run();
    assert_eq!(alone.0, "Box3D");
    let together: Vec<_> = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..8).map(|_| scope.spawn(run)).collect();
        threads.into_iter().map(|t| t.join().unwrap()).collect()
    });
    for other in together {
        assert_eq!(other, alone);
    }
}

fn parsed(line: &[&str]) -> Arguments {
    let line = ["peers"].iter().chain(line);
    Arguments::try_parse_from(line).unwrap()
}

#[test]
fn a_comparison_names_every_engine() {
    let arguments = parsed(&["--scene", "stack:2", "--steps", "7", "--turn", "3"]);
    let comparison = compare(arguments.scene[0], 1, &arguments.run).unwrap();
    assert_eq!(comparison.engines.len(), 1 + Peer::BUILT.len());
    let (shown, json) = (comparison.to_string(), comparison.json());
    for entry in &comparison.engines {
        assert!(shown.contains(entry.name), "{shown}");
        let fields = &json[entry.name.to_lowercase()];
        assert!(fields["step_ms_median"].as_f64().unwrap() > 0.0, "{json}");
    }
    assert!(json["rapier"]["step_ratio"].as_f64().unwrap() > 0.0);
    assert_eq!(json["rapier"]["iterations"], 4);
}

/// A folder of this test run.
fn folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("drystone-peers-{}-{name}", std::process::id()));
    fs::create_dir_all(&folder).unwrap();
    folder
}

fn make(line: &[&str]) -> Result<(), String> {
    match parsed(line).command {
        Some(Command::Table(table)) => table.make(),
        _ => unreachable!("a table was asked for"),
    }
}

#[test]
fn a_table_writes_its_files() {
    let folder = folder("table");
    let out = folder.to_str().unwrap();
    let readme = folder.join("README.md");
    let picture = folder.join("copy.png");
    let page = "before\n<!-- peers table -->\nold\n<!-- end -->\nafter\n";
    fs::write(&readme, page).unwrap();
    let (copy, update) = (picture.to_str().unwrap(), readme.to_str().unwrap());
    let scenes = "stack:2,heap:3,arch:5";
    let line = [
        "table", "--scenes", scenes, "--steps", "5", "--runs", "2", "--out", out,
    ];
    let line = [&line[..], &["--picture", copy, "--update", update]].concat();
    // Twice: what was put in is replaced.
    make(&line).unwrap();
    make(&line).unwrap();

    let engines = 1 + Peer::BUILT.len();
    let csv = fs::read_to_string(folder.join("table.csv")).unwrap();
    let lines: Vec<&str> = csv.lines().collect();
    assert_eq!(lines.len(), 1 + 3 * engines, "{csv}");
    let columns = lines[0].split(',').count();
    assert!(lines.iter().all(|l| l.split(',').count() == columns));

    let markdown = fs::read_to_string(folder.join("table.md")).unwrap();
    let columns = |line: &str| line.matches('|').count();
    let table: Vec<&str> = markdown.lines().take_while(|l| !l.is_empty()).collect();
    assert_eq!(table.len(), 5, "{markdown}");
    assert!(table.iter().all(|l| columns(l) == columns(table[0])));
    assert!(table[3].contains("moves") && table[0].contains("drystone / Rapier"));

    let page = fs::read_to_string(&readme).unwrap();
    assert!(page.starts_with("before\n") && page.ends_with("\nafter\n"));
    assert!(page.contains(table[4]) && !page.contains("old"), "{page}");
    assert_eq!(page.matches("| `stack:2`").count(), 1);

    let png = fs::read(folder.join("table.png")).unwrap();
    assert_eq!(&png[1..4], b"PNG");
    assert_eq!(png, fs::read(&picture).unwrap());
    fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn a_busy_table_writes_its_files() {
    let folder = folder("busy");
    let out = folder.to_str().unwrap();
    let readme = folder.join("README.md");
    fs::write(
        &readme,
        "before\n<!-- busy table -->\nold\n<!-- end -->\nafter\n",
    )
    .unwrap();
    let update = readme.to_str().unwrap();
    let scenes = "smash:8,joint_grid:corner:3,large_world:10,pile:cylinders:2";
    let line = [
        "busy", "--scenes", scenes, "--steps", "20", "--out", out, "--update", update,
    ];
    let Some(Command::Busy(busy)) = parsed(&line).command else {
        panic!("a busy table was asked for");
    };
    busy.make().unwrap();
    let csv = fs::read_to_string(folder.join("busy.csv")).unwrap();
    let lines: Vec<&str> = csv.lines().collect();
    // Box3D has no cylinders.
    let engines = 1 + Peer::BUILT.len();
    assert_eq!(lines.len(), 1 + 3 * engines + 2, "{csv}");
    let columns = lines[0].split(',').count();
    assert!(lines.iter().all(|l| l.split(',').count() == columns));
    assert!(csv.contains("large_world:10,10,20,true,drystone"), "{csv}");
    let page = fs::read_to_string(&readme).unwrap();
    assert!(page.starts_with("before\n") && page.ends_with("\nafter\n"));
    let table: Vec<&str> = page.lines().filter(|line| line.starts_with('|')).collect();
    assert_eq!(table.len(), 6, "{page}");
    let columns = |line: &str| line.matches('|').count();
    assert!(table.iter().all(|l| columns(l) == columns(table[0])));
    assert_eq!(page.contains("– in `pile:cylinders:2`"), engines == 3);
    fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn a_table_that_cannot_be_made_says_why() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.toml");
    let table = [
        "table", "--scenes", "stack:2", "--steps", "1", "--runs", "1",
    ];
    let folder = folder("refused");
    let out = folder.to_str().unwrap();
    for (options, why) in [
        (["--out", file, "--turn", "1"], "Cargo.toml"),
        (["--out", out, "--update", file], "peers table"),
        (["--out", out, "--scenes", "pressed:5"], "pressed:5"),
    ] {
        let table = match options[2] {
            "--scenes" => &[table[0], "--steps", "1"][..],
            _ => &table[..],
        };
        let error = make(&[table, &options].concat()).unwrap_err();
        assert!(error.contains(why), "{error}");
    }
    fs::remove_dir_all(&folder).unwrap();
}
