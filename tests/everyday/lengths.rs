//! Steps of very different lengths follow each other: slow motion, a pause, a hitch. Structures stay at rest, and bodies that
//! fall or hit have the right speed.

use super::*;
use drystone::masonry::{Arch, Block};
use drystone::settings::SolverSettings;
use drystone::solver::{Nncg, Pgs};

/// The length of step `k`: `dt` at times that follow no simple rhythm, else 1/60 s.
fn odd(k: usize, dt: f32) -> f32 {
    if (k * 7 + k / 3).is_multiple_of(2) {
        dt
    } else {
        DT
    }
}

/// A scene that rests: spawns it at a place, and returns its bodies.
type Scene = fn(&mut World, Vec3) -> Vec<Entity>;

fn spawn_at(world: &mut World, place: Vec3, body: impl Bundle, offset: Vec3) -> Entity {
    let transform = Transform::from_translation(place + offset);
    world
        .spawn((RigidBody::Dynamic, transform))
        .insert(body)
        .id()
}

/// Twelve bricks, each half over the one below.
fn stack(world: &mut World, place: Vec3) -> Vec<Entity> {
    let at = |i: usize| Vec3::new(0.5 * (i % 2) as f32, 0.25 + 0.5 * i as f32, 0.0);
    (0..12)
        .map(|i| spawn_at(world, place, Collider::cuboid(1.0, 0.5, 0.5), at(i)))
        .collect()
}

/// A wall of six courses.
fn wall(world: &mut World, place: Vec3) -> Vec<Entity> {
    let bricks = (0..6).flat_map(|row| (0..5).map(move |i| (row, i)));
    let at = |(row, i): (usize, usize)| {
        Vec3::new(
            i as f32 + 0.5 * (row % 2) as f32,
            0.25 + 0.5 * row as f32,
            0.0,
        )
    };
    bricks
        .map(|brick| spawn_at(world, place, Collider::cuboid(1.0, 0.5, 0.5), at(brick)))
        .collect()
}

fn arch(world: &mut World, place: Vec3) -> Vec<Entity> {
    let spawn = |block: Block| {
        let id = world.spawn(block.bundle()).id();
        world.get_mut::<Transform>(id).unwrap().translation += place;
        id
    };
    Arch::default()
        .blocks()
        .unwrap()
        .into_iter()
        .map(spawn)
        .collect()
}

/// Two balls that touch, and a cube.
fn balls(world: &mut World, place: Vec3) -> Vec<Entity> {
    let mut ball = |x| spawn_at(world, place, Collider::ball(0.5), Vec3::new(x, 0.5, 0.0));
    let balls = vec![ball(0.0), ball(1.0)];
    spawn_at(world, place, cube(1.0), Vec3::new(3.0, 0.5, 0.0));
    balls
}

/// A chain of six links, an arm that a servo holds, and a weight in a grab.
fn joints(world: &mut World, place: Vec3) -> Vec<Entity> {
    let mut bodies = vec![];
    let mut above = None;
    for i in 0..6 {
        let y = 8.0 - 0.5 * i as f32;
        let link = spawn_at(
            world,
            place,
            Collider::cuboid(0.1, 0.5, 0.1),
            Vec3::new(0.0, y, 0.0),
        );
        world.spawn(SphericalJoint::new(above, link).with_anchor(place + Vec3::Y * (y + 0.25)));
        above = Some(link);
        bodies.push(link);
    }
    let arm = spawn_at(
        world,
        place,
        (Collider::cuboid(1.0, 0.1, 0.1), Mass(2.0)),
        Vec3::new(4.5, 5.0, 0.0),
    );
    let hinge = RevoluteJoint::new(None, arm).with_anchor(place + Vec3::new(4.0, 5.0, 0.0));
    world.spawn(hinge.with_motor(JointMotor::servo(0.0, 1e3)));
    bodies.push(arm);
    let held = spawn_at(
        world,
        place,
        (cube(0.5), Mass(20.0)),
        Vec3::new(8.0, 5.0, 0.0),
    );
    world.entity_mut(held).insert(Grab::gentle(
        20.0,
        Vec3::ZERO,
        place + Vec3::new(8.0, 5.0, 0.0),
    ));
    bodies.push(held);
    bodies
}

/// The stack, in mortar.
fn mortar(world: &mut World, place: Vec3) -> Vec<Entity> {
    let bodies = stack(world, place);
    for &body in &bodies {
        world.entity_mut(body).insert(Mortar::default());
    }
    bodies
}

const SCENES: [(&str, Scene); 6] = [
    ("stack", stack),
    ("wall", wall),
    ("arch", arch),
    ("balls", balls),
    ("joints", joints),
    ("mortar", mortar),
];

/// The largest speed, m/s, and way, m, of bodies in steps of these lengths, after so many of 1/60 s in which they came to rest.
fn disturbed(
    scene: Scene,
    place: Vec3,
    solver: &SolverSettings,
    settling: usize,
    lengths: impl Iterator<Item = f32>,
) -> [f32; 2] {
    let mut app = app();
    let world = app.world_mut();
    world.resource_mut::<SleepSettings>().enabled = false;
    world.insert_resource(solver.clone());
    world.spawn((
        RigidBody::Static,
        Collider::half_space(Vec3::Y),
        Friction::new(0.6),
    ));
    let bodies = scene(world, place);
    steps(world, settling);
    let start: Vec<Vec3> = bodies.iter().map(|&body| position(world, body)).collect();
    let [mut fastest, mut farthest] = [0.0f32; 2];
    for dt in lengths {
        drystone::step(world, dt).unwrap();
        for (&body, start) in bodies.iter().zip(&start) {
            fastest = fastest.max(velocity(world, body).linear.length());
            farthest = farthest.max((position(world, body) - *start).length());
        }
    }
    [fastest, farthest]
}

/// Asserts that all scenes rest in steps of these lengths.
#[track_caller]
fn rests(what: &str, settling: usize, place: Vec3, lengths: impl Iterator<Item = f32> + Clone) {
    for (name, scene) in SCENES {
        let solver = SolverSettings::default();
        let [fastest, farthest] = disturbed(scene, place, &solver, settling, lengths.clone());
        println!("{what}, {name}: {fastest} m/s, {farthest} m");
        assert!(fastest < 1e-3, "{what}, {name}: {fastest} m/s");
        assert!(farthest < 1e-4, "{what}, {name}: {farthest} m");
    }
}

/// A stack of twelve reached 15 m/s: in a tiny step, loads at rest followed the forces by as much as in a usual one, and these forces were
/// the smallest velocities over a millionth of a second. An arch reached 9 mm/s, as its friction began anew after each tiny step.
#[test]
fn structures_stay_at_rest_when_some_steps_are_short_or_long() {
    for dt in [1e-7, 1e-6, 3e-6, 1e-5, 1e-4, 1e-3, 1.0 / 240.0, 0.1] {
        rests(
            &format!("{dt} s"),
            240,
            Vec3::ZERO,
            (0..200).map(|k| odd(k, dt)),
        );
    }
}

#[test]
fn structures_stay_at_rest_in_steps_of_every_length_in_turn() {
    let lengths = [1e-7, 0.1, 1e-6, DT, 1e-3, 1e-5, 1.0 / 240.0, 1e-4];
    rests(
        "mixed",
        240,
        Vec3::ZERO,
        (0..300).map(|k| lengths[(k * 5 + k / 7) % 8]),
    );
}

#[test]
fn structures_stay_at_rest_in_slow_motion_and_after_it() {
    for dt in [1e-7, 1e-6, 1e-4] {
        let lengths = (0..1000).map(|_| dt).chain((0..60).map(|_| DT));
        rests(&format!("{dt} s"), 240, Vec3::ZERO, lengths);
    }
    let lengths = (0..10_000).map(|_| 1e-6).chain((0..60).map(|_| DT));
    let [fastest, farthest] =
        disturbed(stack, Vec3::ZERO, &SolverSettings::default(), 240, lengths);
    assert!(
        fastest < 1e-3 && farthest < 1e-4,
        "{fastest} m/s, {farthest} m"
    );
}

/// The first step of a world is a tiny one.
#[test]
fn structures_built_in_slow_motion_rest() {
    for dt in [1e-7, 1e-6, 1e-5, 1e-4] {
        let lengths = (0..300).map(|_| dt).chain((0..60).map(|_| DT));
        rests(&format!("from {dt} s"), 0, Vec3::ZERO, lengths);
    }
}

/// Bricks and balls; coordinates are rounded to 60 µm there, so an arch trembles in any steps.
#[test]
fn structures_far_from_the_origin_stay_at_rest() {
    for (name, scene) in SCENES.into_iter().filter(|(name, _)| *name != "arch") {
        for dt in [1e-7, 1e-6, 1e-4, 0.1] {
            let place = Vec3::new(1000.0, 0.0, -500.0);
            let solver = SolverSettings::default();
            let [fastest, farthest] =
                disturbed(scene, place, &solver, 240, (0..200).map(|k| odd(k, dt)));
            println!("{name}, {dt} s: {fastest} m/s, {farthest} m");
            assert!(
                fastest < 1e-3 && farthest < 1e-4,
                "{name}, {dt} s: {fastest} m/s, {farthest} m"
            );
        }
    }
}

/// A wall and an arch under the point solvers, which hold them less exactly in even steps too.
#[test]
fn point_solvers_hold_structures_at_rest() {
    let iterations = 300;
    let solvers = [
        SolverSettings::new(Pgs {
            iterations,
            ..Default::default()
        }),
        SolverSettings::new(Nncg {
            iterations,
            ..Default::default()
        }),
    ];
    for solver in &solvers {
        for (name, scene) in SCENES
            .into_iter()
            .filter(|(name, _)| ["wall", "arch", "balls"].contains(name))
        {
            for dt in [1e-7, 1e-6, 1e-4] {
                let [fastest, farthest] =
                    disturbed(scene, Vec3::ZERO, solver, 240, (0..200).map(|k| odd(k, dt)));
                println!(
                    "{}, {name}, {dt} s: {fastest} m/s, {farthest} m",
                    solver.solver.name()
                );
                assert!(
                    fastest < 0.02 && farthest < 2e-3,
                    "{name}, {dt} s: {fastest} m/s, {farthest} m"
                );
            }
        }
    }
}

/// In slow motion a body that falls gains g·t. Its way is less exact: 50 m from the origin, ways below 2 µm a step are rounded to nothing.
#[test]
fn falling_bodies_gain_speed_in_slow_motion() {
    for (dt, count) in [(1e-6, 10_000), (1e-5, 2_000), (1e-4, 1_000)] {
        let mut app = app();
        let world = app.world_mut();
        let ball = world
            .spawn((RigidBody::Dynamic, Collider::ball(0.5), at(0.0, 50.0, 0.0)))
            .id();
        steps_of(world, count, dt);
        let time = dt * count as f32;
        let gained = -velocity(world, ball).linear.y;
        assert!(
            (gained / (9.81 * time) - 1.0).abs() < 1e-3,
            "{dt} s: {gained} m/s after {time} s"
        );
        steps(world, 60);
        let gained = -velocity(world, ball).linear.y;
        assert!(
            (gained / (9.81 * (time + 1.0)) - 1.0).abs() < 1e-3,
            "{dt} s: {gained} m/s"
        );
    }
}

/// A ball arrives within a tiny step, at a floor and at another ball.
#[test]
fn blows_within_tiny_steps_are_right() {
    for dt in [1e-7, 1e-6, 1e-5, 1e-4] {
        for offset in 0..5 {
            // It arrives at the middle of the fortieth tiny step, or a little later.
            let way = 5.0 * dt * (39.5 + 0.2 * offset as f32);
            let lengths = || (0..80).map(|_| dt).chain((0..2).map(|_| DT));
            let restitution = Restitution::new(0.5);
            let mut bounce = app();
            let world = bounce.world_mut();
            world.spawn((
                RigidBody::Static,
                Collider::half_space(Vec3::Y),
                restitution,
            ));
            let fast = Velocity::linear(Vec3::NEG_Y * 5.0);
            let ball = world
                .spawn((
                    RigidBody::Dynamic,
                    Collider::ball(0.5),
                    restitution,
                    fast,
                    at(0.0, 0.5 + way, 0.0),
                ))
                .id();
            lengths().for_each(|dt| drystone::step(world, dt).unwrap());
            let left = velocity(world, ball).linear.y + 2.0 * DT * 9.81;
            println!("{dt} {offset}: {left}");
            assert!((left - 2.5).abs() < 0.05, "{dt} s: {left} m/s");

            let mut meet = app();
            let world = meet.world_mut();
            world.resource_mut::<Gravity>().0 = Vec3::ZERO;
            let mut ball = |x: f32, speed: f32| {
                let speed = Velocity::linear(Vec3::X * speed);
                world
                    .spawn((
                        RigidBody::Dynamic,
                        Collider::ball(0.5),
                        restitution,
                        speed,
                        at(x, 0.0, 0.0),
                    ))
                    .id()
            };
            let [a, b] = [ball(-1.0 - way, 5.0), ball(0.0, 0.0)];
            lengths().for_each(|dt| drystone::step(world, dt).unwrap());
            let [a, b] = [a, b].map(|ball| velocity(world, ball).linear.x);
            println!("{dt} {offset}: {a} {b}");
            assert!((a + b - 5.0).abs() < 1e-3, "{dt} s: {a} and {b} m/s");
            assert!((b - a - 2.5).abs() < 0.05, "{dt} s: {a} and {b} m/s");
        }
    }
}
