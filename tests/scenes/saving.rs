//! Saving to RON text by Bevy's scene format, and loading into another world: what stood stands, what slept sleeps, and bears its loads.

use bevy_ecs::entity::EntityHashMap;
use bevy_ecs::message::Messages;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use bevy_world_serialization::{DynamicWorldBuilder, WorldFilter};
use drystone::body::BodyTable;
use drystone::collider::ColliderShape;
use drystone::fracture::{fracture, seeds};
use drystone::prelude::*;
use drystone::saving::{self, TextError};
use drystone_lab::scenes::{Scene, SceneOptions};
use parry3d::shape::SharedShape;
use support::Lab;

fn save(world: &mut World) -> String {
    saving::to_string(world).unwrap()
}

fn save_as_it_is(world: &mut World, entities: Vec<Entity>) -> String {
    let registry = world.resource::<AppTypeRegistry>().clone();
    let registry = registry.read();
    let scene = DynamicWorldBuilder::from_world(world, &registry)
        .with_component_filter(WorldFilter::Denylist(saving::computed(world).collect()))
        .with_resource_filter(WorldFilter::Allowlist(saving::settings().collect()))
        .extract_entities(entities.into_iter())
        .extract_resources()
        .build();
    scene.serialize(&registry).unwrap()
}

/// Adds a scene to a world. Returns which entity has become which.
fn load(world: &mut World, text: &str) -> EntityHashMap<Entity> {
    saving::from_str(world, text).unwrap()
}

/// A fresh world in which entities have other numbers.
fn other_world(dt: f32) -> Lab {
    let mut lab = Lab::new();
    lab.dt = dt;
    let junk: Vec<Entity> = (0..7).map(|_| lab.world.spawn_empty().id()).collect();
    junk.into_iter()
        .for_each(|entity| _ = lab.world.despawn(entity));
    lab.world.spawn(Name::new("another"));
    lab
}

fn bodies(world: &mut World) -> Vec<Entity> {
    let mut bodies = world.query::<(Entity, &RigidBody)>();
    let dynamic = bodies
        .iter(world)
        .filter(|(_, kind)| **kind == RigidBody::Dynamic);
    dynamic.map(|(body, _)| body).collect()
}

/// The forces on the faces of a body, its supports, and its load, in numbers that depend on no entity but those that `map` names.
fn answers(world: &mut World, body: Entity, map: &dyn Fn(Entity) -> Entity) -> String {
    let mut faces = contacts(world, |contacts| contacts.on(body)).unwrap();
    for face in &mut faces {
        (face.on, face.by) = (map(face.on), map(face.by));
        face.colliders = face.colliders.map(map);
    }
    let mut bearings = supports(world, |supports| supports.supported_by(body)).unwrap();
    for bearing in &mut bearings {
        (bearing.above, bearing.below) = (map(bearing.above), map(bearing.below));
    }
    format!("{faces:#?} {bearings:#?} {:?}", world.get::<Load>(body))
}

/// Saves a world at rest, loads it into another one, and checks that everything is as it was: at once, after 5 s, and when it is woken.
#[track_caller]
fn stands(mut lab: Lab, seconds: f32) -> (Lab, Lab, EntityHashMap<Entity>) {
    for body in bodies(&mut lab.world) {
        lab.world.entity_mut(body).insert(Load::default());
    }
    lab.run(seconds);
    let all = bodies(&mut lab.world);
    for &body in &all {
        assert!(
            lab.world.get::<Sleeping>(body).unwrap().asleep,
            "it does not rest"
        );
    }
    let text = save(&mut lab.world);
    let mut other = other_world(lab.dt);
    let map = load(&mut other.world, &text);
    assert!(all.iter().any(|body| map[body] != *body));
    other.step();
    let messages = other.world.resource::<Messages<ContactStarted>>();
    assert!(messages.is_empty(), "contacts began");
    for &body in &all {
        let found = map[&body];
        assert!(
            other.world.get::<Sleeping>(found).unwrap().asleep,
            "it woke"
        );
        assert_eq!(other.pose(found), lab.pose(body));
        let carried = |world: &World, body| world.get::<Load>(body).unwrap().supported_weight;
        let [here, there] = [carried(&lab.world, body), carried(&other.world, found)];
        assert!(
            (here - there).abs() <= 0.01 * here.abs(),
            "{here} N, {there} N"
        );
    }
    // Forces are those at which bodies came to rest as soon as they are inactive.
    other.step();
    other.step();
    for &body in &all {
        let expected = answers(&mut lab.world, body, &|entity| map[&entity]);
        assert_eq!(
            answers(&mut other.world, map[&body], &|entity| entity),
            expected
        );
    }
    other.run(5.0);
    for &body in &all {
        assert_eq!(
            other.pose(map[&body]),
            lab.pose(body),
            "it moved in its sleep"
        );
    }
    for &body in &all {
        other.world.get_mut::<Sleeping>(map[&body]).unwrap().wake();
        lab.world.get_mut::<Sleeping>(body).unwrap().wake();
    }
    let mut bits = true;
    let mut farthest: f32 = 0.0;
    for _ in 0..(3.0 / lab.dt) as usize {
        lab.step();
        other.step();
        for &body in &all {
            let [one, two] = [lab.pose(body), other.pose(map[&body])];
            bits &= one == two;
        }
    }
    let mut before = other_world(lab.dt);
    let map_before = load(&mut before.world, &text);
    for &body in &all {
        let start = before.world.get::<Transform>(map_before[&body]).unwrap();
        let moved = other.position(map[&body]) - start.translation;
        farthest = farthest.max(moved.length());
    }
    println!(
        "{} bodies, {} bytes; woken for 3 s: {:.5} mm; same bits: {bits}",
        all.len(),
        text.len(),
        1e3 * farthest
    );
    assert!(farthest <= 1e-5, "{farthest}");
    (lab, other, map)
}

fn scene(name: &str, dt: f32) -> Lab {
    let mut lab = Lab::new();
    lab.dt = dt;
    let scene: Scene = name.parse().unwrap();
    scene.build(&mut lab.world, &SceneOptions::default());
    lab
}

const STEPS: [f32; 2] = [1.0 / 60.0, 0.1];

#[test]
fn a_wall_stands() {
    for dt in STEPS {
        stands(scene("wall:6x5", dt), 5.0);
    }
}

#[test]
fn an_arch_stands() {
    for dt in STEPS {
        stands(scene("arch:9", dt), 10.0);
    }
}

#[test]
fn a_tower_that_leans_stands() {
    for dt in STEPS {
        let mut lab = Lab::new();
        lab.dt = dt;
        lab.ground();
        for i in 0..8 {
            let lean = if i % 2 == 0 { 0.03 } else { 0.06 };
            lab.cube(Vec3::new(lean * i as f32, 0.5 + i as f32, 0.01 * i as f32));
        }
        stands(lab, 20.0);
    }
}

#[test]
fn a_door_and_a_chain_hang() {
    for dt in STEPS {
        let mut lab = Lab::new();
        lab.dt = dt;
        lab.ground();
        let door = (
            RigidBody::Dynamic,
            Collider::cuboid(1.0, 2.0, 0.05),
            Mass(20.0),
        );
        let door = lab.spawn((door, Transform::from_xyz(0.5, 1.5, 0.0)));
        let hinge = RevoluteJoint::new(None, door).with_anchor(Vec3::Y * 1.5);
        let hinge = lab.spawn((
            hinge.with_hinge_axis(Vec3::Y).with_friction(1.0),
            BreakForce::new(1e4),
        ));
        let mut last = None;
        for i in 0..5 {
            let top = Vec3::new(4.0, 4.0 - 0.4 * i as f32, 0.0);
            let link = (RigidBody::Dynamic, Collider::capsule(0.05, 0.3), Mass(2.0));
            let link = lab.spawn((link, Transform::from_translation(top - Vec3::Y * 0.2)));
            lab.spawn(SphericalJoint::new(last, link).with_anchor(top));
            last = Some(link);
        }
        let (lab, other, map) = stands(lab, 15.0);
        let of = |world: &World, joint: Entity| *world.get::<JointForces>(joint).unwrap();
        let [here, there] = [of(&lab.world, hinge), of(&other.world, map[&hinge])];
        assert!((here.force - there.force).length() < 0.01 * 20.0 * 9.81);
        let joint = other.world.get::<RevoluteJoint>(map[&hinge]).unwrap();
        assert_eq!(joint.body2, Some(map[&door]));
        assert!(other.world.get::<BreakForce>(map[&hinge]).is_some());
    }
}

/// A winch on its way is many turns from where its drum points.
#[test]
fn a_winch_goes_on_with_its_turns() {
    let mut lab = Lab::new();
    lab.dt = 1.0 / 60.0;
    let drum = lab.body(Collider::cylinder(0.3, 0.6), Vec3::Y * 2.0);
    let motor = JointMotor::position(60.0, 40.0, 30.0);
    let winch = RevoluteJoint::new(None, drum).with_hinge_axis(Vec3::Y);
    let winch = lab.spawn(winch.with_motor(motor).with_angle_limits(-1.0, 61.0));
    lab.run(1.0);
    let angle = |world: &World, joint| world.get::<JointForces>(joint).unwrap().angle().unwrap();
    let before = angle(&lab.world, winch);
    assert!((10.0..55.0).contains(&before), "{before}");
    let text = save(&mut lab.world);
    let mut other = other_world(lab.dt);
    let map = load(&mut other.world, &text);
    for _ in 0..60 {
        lab.step();
        other.step();
        let [here, there] = [angle(&lab.world, winch), angle(&other.world, map[&winch])];
        assert_eq!(here, there);
    }
    assert!(angle(&lab.world, winch) > before);
}

#[test]
fn a_text_with_compounds_within_each_other_is_an_error() {
    let nested = |depth: usize| {
        let part =
            "Compound(parts: [(position: (0.0, 0.0, 0.0), rotation: (0.0, 0.0, 0.0, 1.0), shape: ";
        part.repeat(depth) + "Ball(radius: 0.5)" + &")])".repeat(depth)
    };
    let without_limit = ron::Options::default().without_recursion_limit();
    for depth in [1, 2, 30, 20_000] {
        let text = nested(depth);
        assert_eq!(
            ron::from_str::<Collider>(&text).is_ok(),
            depth == 1,
            "{depth}"
        );
        assert_eq!(
            without_limit.from_str::<Collider>(&text).is_ok(),
            depth == 1,
            "{depth}"
        );
    }
}

#[test]
fn joints_bear_their_loads_at_once() {
    let mut lab = Lab::new();
    lab.ground();
    let bob = lab.body(Collider::ball(0.2), Vec3::new(0.0, 2.0, 0.0));
    let rope = lab.spawn(
        DistanceJoint::new(None, bob)
            .with_local_anchor1(Vec3::Y * 3.0)
            .with_max_distance(1.0),
    );
    lab.run(5.0);
    let expected = *lab.world.get::<JointForces>(rope).unwrap();
    assert!(expected.force.length() > 1.0);
    let text = save(&mut lab.world);
    let mut other = other_world(lab.dt);
    let map = load(&mut other.world, &text);
    other.step();
    assert_eq!(
        *other.world.get::<JointForces>(map[&rope]).unwrap(),
        expected
    );
}

/// Tables of four legs, two of them on each other, with parts that were spawned in another order than their entities.
#[test]
fn bodies_of_several_colliders_stand() {
    for dt in STEPS {
        let mut lab = Lab::new();
        lab.dt = dt;
        lab.ground();
        for storey in 0..3 {
            let at = Transform::from_xyz(0.02 * storey as f32, 1.05 * storey as f32, 0.0);
            let table = lab.spawn((RigidBody::Dynamic, at));
            let top = (
                Collider::cuboid(1.2, 0.05, 1.2),
                Density(600.0),
                Transform::from_xyz(0.0, 1.025, 0.0),
            );
            let mut parts: Vec<Entity> = (0..4)
                .map(|leg| {
                    let at = Vec3::new([-0.5, 0.5][leg % 2], 0.5, [-0.5, 0.5][leg / 2]);
                    lab.spawn((
                        Collider::cuboid(0.1, 1.0, 0.1),
                        Friction::new(0.7),
                        Transform::from_translation(at),
                    ))
                })
                .collect();
            parts.push(lab.spawn(top));
            lab.world.entity_mut(table).add_children(&parts);
        }
        let (_, mut other, _) = stands(lab, 10.0);
        let mut parts = other.world.query::<&drystone::children::ColliderOf>();
        assert_eq!(parts.iter(&other.world).count(), 15);
    }
}

#[test]
fn sensors_keep_their_contents_and_do_not_report_them_again() {
    let mut lab = Lab::new();
    lab.ground();
    let zone = (RigidBody::Static, Sensor, Collider::cuboid(4.0, 4.0, 4.0));
    let zone = lab.spawn((zone, Transform::from_xyz(0.0, 2.0, 0.0)));
    let inside = lab.cube(Vec3::Y * 0.5);
    let carried = lab.spawn((
        RigidBody::Dynamic,
        Collider::cuboid(1.0, 1.0, 1.0),
        Transform::from_xyz(6.0, 0.5, 0.0),
    ));
    let halo = lab.spawn((Sensor, Collider::ball(1.0), ChildOf(carried)));
    lab.run(5.0);
    let text = save(&mut lab.world);
    let mut other = other_world(lab.dt);
    let map = load(&mut other.world, &text);
    other.run(1.0);
    assert!(other.world.resource::<Messages<SensorEntered>>().is_empty());
    assert!(other.world.resource::<Messages<SensorExited>>().is_empty());
    let found = other.world.get::<SensorOverlaps>(map[&zone]).unwrap();
    let expected = lab.world.get::<SensorOverlaps>(zone).unwrap();
    assert!(found.contains(map[&inside]) && found.len() == expected.len());
    let of_halo = lab.world.get::<SensorOverlaps>(halo).unwrap().len();
    assert_eq!(
        other.world.get::<SensorOverlaps>(map[&halo]).unwrap().len(),
        of_halo
    );
    // It still reports who leaves and comes back.
    let at = |y| Transform::from_xyz(20.0, y, 0.0);
    other.world.entity_mut(map[&inside]).insert(at(0.5));
    other.step();
    assert_eq!(other.world.resource::<Messages<SensorExited>>().len(), 1);
    other
        .world
        .entity_mut(map[&inside])
        .insert(Transform::from_xyz(0.0, 0.5, 0.0));
    other.step();
    assert_eq!(other.world.resource::<Messages<SensorEntered>>().len(), 1);
}

/// Boxes, balls and hulls in mid-fall, some of which touch already.
#[test]
fn falling_bodies_go_on_to_the_same_bits() {
    let mut lab = Lab::new();
    lab.dt = 1.0 / 60.0;
    lab.ground();
    let shapes = [
        Collider::cuboid(1.0, 0.5, 0.5),
        Collider::ball(0.3),
        Collider::wedge(0.6, 0.5, 0.7).unwrap(),
        Collider::cylinder(0.3, 0.6),
    ];
    for i in 0..24 {
        let at = Vec3::new(
            0.1 * (i % 5) as f32,
            0.5 + 0.5 * i as f32,
            0.07 * (i % 3) as f32,
        );
        let body = lab.body(shapes[i % 4].clone(), at);
        lab.set_velocity(body, Vec3::X * 0.3, Vec3::new(0.3, 0.1 * i as f32, 0.0));
    }
    let mut same = 0;
    let mut largest: f32 = 0.0;
    for _ in 0..8 {
        lab.run(0.25);
        let all = bodies(&mut lab.world);
        let text = save(&mut lab.world);
        let mut other = other_world(lab.dt);
        let map = load(&mut other.world, &text);
        let mut copy = support::Lab::new();
        copy.dt = lab.dt;
        let copied = support::copy::copy_state(&lab.world, &mut copy.world);
        for &body in &all {
            let transform = |world: &World, body| *world.get::<Transform>(body).unwrap();
            assert_eq!(
                transform(&other.world, map[&body]),
                transform(&lab.world, body)
            );
            assert_eq!(other.velocity(map[&body]), lab.velocity(body));
        }
        for _ in 0..15 {
            copy.step();
            other.step();
        }
        let gaps = all.iter().map(|&body| {
            let [one, two] = [copy.pose(copied[&body]), other.pose(map[&body])];
            (one.position - two.position).length()
        });
        let gap = gaps.fold(0.0, f32::max);
        same += usize::from(gap == 0.0);
        largest = largest.max(gap);
    }
    println!("same bits after a quarter of a second: {same} of 8; largest difference {largest} m");
    assert!(largest < 0.02, "{largest}");
}

#[test]
fn shapes_come_back_bit_by_bit() {
    let corner = |i: u32| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32);
    let points: Vec<Vec3> = (0..8)
        .map(|i| corner(i) * Vec3::new(1.0, 0.3, 0.7) + Vec3::X * 0.1)
        .collect();
    let mut random = fastrand::Rng::with_seed(4);
    let mut number = || random.f32() - 0.5;
    let mut shapes = vec![
        Collider::ball(0.1),
        Collider::cuboid(1.0, 0.3, 1e-3),
        Collider::round_cuboid(0.5, 0.25, 0.1, 0.03),
        Collider::capsule(0.1, 0.7),
        Collider::capsule(0.1, 0.7)
            .scaled(Vec3::splat(0.3))
            .unwrap(),
        Collider::cylinder(0.1, 0.7),
        Collider::cone(0.1, 0.7),
        Collider::half_space(Vec3::new(0.1, 1.0, 0.3)),
        Collider::triangle(Vec3::X, Vec3::Y * 0.1, Vec3::Z),
        Collider::from(SharedShape::round_cylinder(0.5, 0.3, 0.01)),
        Collider::from(SharedShape::round_cone(0.5, 0.3, 0.01)),
        Collider::from(SharedShape::round_triangle(Vec3::X, Vec3::Y, Vec3::Z, 0.1)),
        Collider::from(SharedShape::segment(Vec3::X, Vec3::Y)),
        Collider::convex_hull(&points).unwrap(),
        Collider::trimesh(points.clone(), vec![[0, 1, 3], [0, 3, 2], [4, 5, 6]]).unwrap(),
        Collider::height_field(
            &[vec![0.0, 0.1, 0.3], vec![0.2, 0.7, -0.1]],
            Vec3::new(3.0, 0.3, 2.0),
        )
        .unwrap(),
    ];
    for _ in 0..200 {
        let points: Vec<Vec3> = (0..30)
            .map(|_| Vec3::new(number(), number(), number()))
            .collect();
        shapes.push(Collider::convex_hull(&points).unwrap());
    }
    let block = Collider::cuboid(0.4, 0.2, 0.3);
    let pieces = fracture(&block, &seeds(&block, 40, None, 0)).unwrap();
    shapes.extend(pieces.into_iter().map(|piece| piece.collider));
    let mut lab = Lab::new();
    let parts = shapes[0..2].iter().chain(&shapes[13..14]).enumerate();
    let parts = parts.map(|(i, part)| {
        (
            Vec3::X * (0.3 * i as f32),
            Quat::from_rotation_y(0.1 * i as f32),
            part.clone(),
        )
    });
    shapes.push(Collider::compound(parts.collect()).unwrap());
    for shape in &shapes {
        let text = ron::to_string(shape).unwrap();
        let found: Collider = ron::from_str(&text).unwrap();
        assert_eq!(found.description(), shape.description());
        let weighed = [&found, shape].map(|shape| {
            let body = lab.body(shape.clone(), Vec3::ZERO);
            format!("{:?}", lab.mass(body))
        });
        assert_eq!(weighed[0], weighed[1]);
        assert_eq!(faces(&found), faces(shape));
    }
    let unknown = Collider::from(SharedShape::polyline(points, None));
    assert!(unknown.description().is_none());
    assert!(
        ron::to_string(&unknown)
            .unwrap_err()
            .to_string()
            .contains("Polyline")
    );
    let flat = ColliderShape::ConvexHull {
        points: vec![Vec3::X; 9],
    };
    let error = ron::from_str::<Collider>(&ron::to_string(&flat).unwrap()).unwrap_err();
    assert!(error.to_string().contains("four points"), "{error}");
}

/// The points of the parry shape in its order.
fn faces(shape: &Collider) -> String {
    match shape.shape().as_convex_polyhedron() {
        Some(hull) => format!("{:?} {:?}", hull.points(), hull.faces().len()),
        None => String::new(),
    }
}

#[test]
fn settings_and_unusual_components_come_back() {
    let mut lab = Lab::new();
    lab.world
        .insert_resource(Gravity(Vec3::new(0.1, -3.0, 0.0)));
    lab.world
        .insert_resource(SolverSettings::new(drystone::solver::Nncg::default()));
    lab.world.resource_mut::<SleepSettings>().delay = 0.1;
    lab.world
        .resource_mut::<PhysicsTime>()
        .set_relative_speed(0.5)
        .unwrap();
    lab.ground();
    let friend = lab.cube(Vec3::new(5.0, 0.5, 0.0));
    let body = lab.cube(Vec3::Y * 0.5);
    let mut exceptions = CollisionExceptions::default();
    exceptions.0.insert(friend);
    lab.world.entity_mut(body).insert((
        (
            exceptions,
            LockedAxes::ROTATION_LOCKED,
            Dominance(3),
            MaxLinearSpeed(7.0),
            CollisionLayers::default(),
        ),
        (
            Restitution::new(0.3),
            RollingFriction::new(0.1),
            SurfaceVelocity(Vec3::X * 0.1),
            Watch::default(),
        ),
        (
            Damping {
                linear: 0.1,
                angular: 0.2,
            },
            GravityScale(0.5),
            ContactEvents,
            CollidingEntities::default(),
        ),
    ));
    lab.step();
    let text = save(&mut lab.world);
    let mut other = other_world(lab.dt);
    let map = load(&mut other.world, &text);
    let of = |world: &World, body: Entity| {
        let body = world.entity(body);
        format!(
            "{:?} {:?} {:?} {:?} {:?} {:?} {:?} {:?} {:?} {:?} {:?}",
            body.get::<LockedAxes>(),
            body.get::<Dominance>(),
            body.get::<MaxLinearSpeed>(),
            body.get::<CollisionLayers>(),
            body.get::<Restitution>(),
            body.get::<RollingFriction>(),
            body.get::<SurfaceVelocity>(),
            body.get::<Watch>(),
            body.get::<Damping>(),
            body.get::<GravityScale>(),
            body.get::<ContactEvents>(),
        )
    };
    assert_eq!(of(&other.world, map[&body]), of(&lab.world, body));
    assert!(!of(&other.world, map[&body]).contains("None"));
    let exceptions = other.world.get::<CollisionExceptions>(map[&body]).unwrap();
    assert!(exceptions.0.contains(&map[&friend]) && exceptions.0.len() == 1);
    assert_eq!(
        other.world.resource::<Gravity>(),
        lab.world.resource::<Gravity>()
    );
    assert_eq!(
        other.world.resource::<SolverSettings>(),
        lab.world.resource::<SolverSettings>()
    );
    assert_eq!(
        other.world.resource::<SleepSettings>(),
        lab.world.resource::<SleepSettings>()
    );
    assert_eq!(
        other.world.resource::<PhysicsTime>(),
        lab.world.resource::<PhysicsTime>()
    );
}

#[test]
fn a_scene_may_be_loaded_twice_beside_other_bodies() {
    let mut lab = scene("wall:4x3", 1.0 / 60.0);
    lab.run(5.0);
    let all = bodies(&mut lab.world);
    let text = save(&mut lab.world);
    let mut other = other_world(lab.dt);
    other.ground();
    let stack = [0.5, 1.5].map(|y| other.cube(Vec3::new(-30.0, y, 0.0)));
    other.run(3.0);
    let first = load(&mut other.world, &text);
    other.step();
    // The second copy is put elsewhere.
    let second = load(&mut other.world, &text);
    for &body in second.values() {
        if let Some(mut at) = other.world.get_mut::<Transform>(body) {
            at.translation += Vec3::Z * 40.0;
        }
    }
    other.run(5.0);
    let mut orders = other.world.query::<&SpawnOrder>();
    let mut orders: Vec<u64> = orders.iter(&other.world).map(|order| order.0).collect();
    orders.sort_unstable();
    assert!(
        orders.windows(2).all(|pair| pair[0] < pair[1]),
        "two bodies have one number"
    );
    for &body in &all {
        let at = lab.position(body);
        assert_eq!(other.position(first[&body]), at);
        assert!((other.position(second[&body]) - Vec3::Z * 40.0 - at).length() < 1e-4);
    }
    for body in bodies(&mut other.world) {
        assert!(other.world.get::<Sleeping>(body).unwrap().asleep);
    }
    assert!((other.position(stack[1]).y - 1.5).abs() < 1e-3);
}

/// Without `prepare` contacts are not in the scene; sleepers get their loads by statics.
#[test]
fn a_scene_without_contacts_stands_too() {
    let mut lab = scene("wall:6x5", 1.0 / 60.0);
    lab.run(5.0);
    let all = bodies(&mut lab.world);
    let mut entities = lab.world.query_filtered::<Entity, With<RigidBody>>();
    let entities = entities.iter(&lab.world).collect();
    let text = save_as_it_is(&mut lab.world, entities);
    assert!(!text.contains("Saved"));
    let mut other = other_world(lab.dt);
    let map = load(&mut other.world, &text);
    other.step();
    let weight = |world: &mut World, body| {
        let faces = contacts(world, |contacts| contacts.on(body)).unwrap();
        faces.iter().map(|face| face.force.y).sum::<f32>()
    };
    for &body in &all {
        assert!(other.world.get::<Sleeping>(map[&body]).unwrap().asleep);
        let [here, there] = [
            weight(&mut lab.world, body),
            weight(&mut other.world, map[&body]),
        ];
        assert!((here - there).abs() < 0.01 * here.abs(), "{here} {there}");
    }
    for &body in &all {
        other.world.get_mut::<Sleeping>(map[&body]).unwrap().wake();
    }
    other.run(5.0);
    for &body in &all {
        let moved = (other.position(map[&body]) - lab.position(body)).length();
        assert!(moved < 1e-4, "{moved}");
    }
}

/// The world that is saved goes on as if it had not been saved.
#[test]
fn saving_changes_nothing() {
    let mut lab = scene("heap:20", 1.0 / 60.0);
    let mut plain = scene("heap:20", 1.0 / 60.0);
    for i in 0..60 {
        if i % 10 == 0 {
            let _ = save(&mut lab.world);
        }
        lab.step();
        plain.step();
        assert_eq!(lab.bits(), plain.bits(), "step {i}");
    }
    assert!(
        lab.world
            .query::<&saving::Saved>()
            .iter(&lab.world)
            .next()
            .is_none()
    );
    assert!(lab.world.resource::<BodyTable>().count() > 20);
}

/// Lays weights on a sleeping cube of a ton, each of a quarter of what wakes it, with the numbers from `from` on. Returns the number of the
/// one that wakes it.
fn lay_until_woken(lab: &mut Lab, cube: Entity, from: usize, pause: f32) -> usize {
    for i in from..20 {
        lay_weight(lab, i);
        for _ in 0..(pause / lab.dt).round() as usize {
            lab.step();
            if !lab.world.get::<Sleeping>(cube).unwrap().asleep {
                return i;
            }
        }
    }
    usize::MAX
}

fn lay_weight(lab: &mut Lab, i: usize) {
    let (x, z) = ((i % 4) as f32 - 1.5, (i / 4) as f32 - 1.5);
    lab.spawn((
        RigidBody::Dynamic,
        Collider::cuboid(0.05, 0.05, 0.05),
        Mass(5.0),
        Transform::from_xyz(0.1 * x, 1.025, 0.1 * z),
    ));
}

/// Small changes that add up do so over a saved scene too, whether the weights sleep when it is saved or not. Nobody wakes by being loaded.
#[test]
fn a_sleeping_body_wakes_at_the_same_weight_after_loading() {
    for (pause, sleeps) in [(2.0, true), (0.2, false)] {
        let site = || {
            let mut lab = Lab::new();
            lab.dt = 1.0 / 60.0;
            lab.ground();
            let cube = lab.cube(Vec3::Y * 0.5);
            lab.run(3.0);
            assert!(lab.world.get::<Sleeping>(cube).unwrap().asleep);
            (lab, cube)
        };
        let (mut lab, cube) = site();
        let expected = lay_until_woken(&mut lab, cube, 0, pause);
        assert!((3..8).contains(&expected), "{expected}");

        let (mut lab, cube) = site();
        for i in 0..3 {
            lay_weight(&mut lab, i);
            lab.run(pause);
        }
        let text = save(&mut lab.world);
        let asleep = |world: &World, body| world.get::<Sleeping>(body).unwrap().asleep;
        let mut other = other_world(lab.dt);
        let map = load(&mut other.world, &text);
        other.step();
        lab.step();
        let all = bodies(&mut lab.world);
        for &body in &all {
            let wanted = asleep(&lab.world, body);
            assert_eq!(asleep(&other.world, map[&body]), wanted, "it woke");
            assert_eq!(other.pose(map[&body]), lab.pose(body));
        }
        assert_eq!(all.iter().all(|&body| asleep(&lab.world, body)), sleeps);
        for (lab, cube) in [(&mut lab, cube), (&mut other, map[&cube])] {
            assert_eq!(lay_until_woken(lab, cube, 3, pause), expected);
        }
    }
}

/// A hill of cells comes back with the bodies of its chunks, and is dug in the other world.
#[test]
fn a_hill_of_cells_is_dug_after_loading() {
    let mut lab = Lab::new();
    let mut hill = Voxels::new(0.25);
    hill.set_box(IVec3::new(-20, -8, -20), IVec3::new(20, 0, 20), true);
    let hill = lab.spawn((RigidBody::Static, hill));
    let ball = lab.body(Collider::ball(0.2), Vec3::new(0.1, 0.2, 0.1));
    (0..60).for_each(|_| lab.step());
    let text = save(&mut lab.world);
    let mut other = other_world(lab.dt);
    let map = load(&mut other.world, &text);
    other.step();
    let chunks = |lab: &mut Lab| lab.world.query::<&VoxelChunk>().iter(&lab.world).count();
    assert_eq!(chunks(&mut other), chunks(&mut lab));
    let (hill, ball) = (map[&hill], map[&ball]);
    assert!(other.world.get::<Sleeping>(ball).unwrap().asleep);
    let mut cells = other.world.get_mut::<Voxels>(hill).unwrap();
    assert_eq!(
        cells.set_box(IVec3::new(-2, -4, -2), IVec3::new(2, 0, 2), false),
        64
    );
    (0..60).for_each(|_| other.step());
    assert!((other.pose(ball).position.y + 0.8).abs() < 1e-3);
    assert_eq!(chunks(&mut other), chunks(&mut lab));
}

#[test]
fn text_that_is_no_scene_is_an_error() {
    let mut lab = Lab::new();
    lab.ground();
    let text = save(&mut lab.world);
    for wrong in ["", "(resources: {}", &text.replace("Collider", "Kollider")] {
        let mut other = Lab::new();
        let before = other.world.entities().len();
        let read = saving::from_str(&mut other.world, wrong);
        assert!(matches!(read, Err(TextError::Read(_))), "{read:?}");
        assert_eq!(other.world.entities().len(), before);
    }
}

/// The code of the cookbook's page about saving.
mod cookbook {
    include!("../../src/cookbook/app/save.rs");

    #[test]
    fn its_code_saves_and_loads() {
        an_arch_is_saved_and_loaded();
    }
}
