//! Fast bodies that meet.

use super::*;

/// Numbers between 0 and 1, always the same.
struct Dice(u64);

impl Dice {
    fn next(&mut self) -> f32 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1u64 << 24) as f32
    }

    fn direction(&mut self) -> Vec3 {
        loop {
            let found = Vec3::from_array(std::array::from_fn(|_| 2.0 * self.next() - 1.0));
            if (0.1..1.0).contains(&found.length()) {
                return found.normalize();
            }
        }
    }
}

/// Two bodies that meet: their shapes, ways and orientations, and the distance from the place where their centres would meet, m.
fn passes(shapes: [Collider; 2], ways: [Vec3; 2], turns: [Quat; 2], far: f32, speed: f32) -> bool {
    let mut app = app();
    let world = app.world_mut();
    world.resource_mut::<Gravity>().0 = Vec3::ZERO;
    let mut bodies = Vec::new();
    for ((shape, way), turn) in shapes.into_iter().zip(ways).zip(turns) {
        let pose = Transform::from_translation(-way * far).with_rotation(turn);
        bodies.push(
            world
                .spawn((
                    RigidBody::Dynamic,
                    shape,
                    Velocity::linear(way * speed),
                    pose,
                ))
                .id(),
        );
    }
    steps(world, (1.5 * far / speed / DT) as usize + 2);
    (velocity(world, bodies[0]).linear - ways[0] * speed).length() < 0.05 * speed
}

#[test]
fn cubes_that_cross_edge_on_edge_stop_each_other() {
    for speed in [60.0, 150.0, 300.0] {
        let passed = (0..60).filter(|&k| {
            passes(
                [cube(0.2), cube(0.2)],
                [Vec3::X, Vec3::Z],
                [Quat::IDENTITY; 2],
                10.0 + k as f32 / 60.0,
                speed,
            )
        });
        assert_eq!(passed.count(), 0, "{speed} m/s");
    }
}

/// Centres that meet exactly: pairs of shapes, ways and orientations by chance, at 60 to 300 m/s.
#[test]
fn none_of_a_thousand_pairs_that_meet_at_a_known_point_pass() {
    let mut dice = Dice(7);
    let corners = |dice: &mut Dice| [(); 10].map(|()| 0.15 * dice.direction());
    let shape = |dice: &mut Dice| match (8.0 * dice.next()) as u32 {
        0 => Collider::ball(0.1),
        1 => Collider::cylinder(0.1, 0.2),
        2 => Collider::capsule(0.07, 0.15),
        3 => Collider::cuboid(0.3, 0.1, 0.15),
        4 => Collider::cone(0.12, 0.25),
        5 => Collider::convex_hull(&corners(dice)).unwrap(),
        6 => Collider::round_cuboid(0.15, 0.2, 0.15, 0.02),
        _ => cube(0.2),
    };
    let (mut met, mut passed) = (0, 0);
    while met < 1000 {
        let shapes = [shape(&mut dice), shape(&mut dice)];
        let ways = [dice.direction(), dice.direction()];
        if ways[0].dot(ways[1]) > 0.7 {
            continue;
        }
        met += 1;
        let turns = [0, 1].map(|_| Quat::from_axis_angle(dice.direction(), 3.0 * dice.next()));
        let (far, speed) = (10.0 + dice.next(), 60.0 + 240.0 * dice.next());
        let [a, b] = [0, 1].map(|i| shapes[i].shape().shape_type());
        if passes(shapes, ways, turns, far, speed) {
            println!("{a:?} and {b:?} at {speed:.0} m/s");
            passed += 1;
        }
    }
    assert_eq!(passed, 0);
}

/// A bar that turns with an angular velocity, either by its `Velocity`, or drawn along by its `Transform`, hits what stands in its way. Returns how far round
/// the ball was left behind, or `None` if it was struck.
fn sweeps(body: Collider, turn: f32, by_transform: bool, far: f32, angle: f32) -> bool {
    let mut app = app();
    let world = app.world_mut();
    world.resource_mut::<Gravity>().0 = Vec3::ZERO;
    let spin = Velocity {
        linear: Vec3::ZERO,
        angular: Vec3::Y * turn,
    };
    let bar = world
        .spawn((
            RigidBody::Kinematic,
            Collider::cuboid(8.0, 2.0, 0.1),
            at(0.0, 0.0, 0.0),
        ))
        .id();
    if !by_transform {
        world.entity_mut(bar).insert(spin);
    }
    let place = Quat::from_rotation_y(angle) * Vec3::X * far;
    let body = world
        .spawn((RigidBody::Dynamic, body, Transform::from_translation(place)))
        .id();
    let count = (1.2 * angle / turn / DT) as usize + 4;
    for k in 0..count {
        if by_transform {
            let mut pose = world.get_mut::<Transform>(bar).unwrap();
            pose.rotation = Quat::from_rotation_y(turn * (k + 1) as f32 * DT);
        }
        steps(world, 1);
    }
    velocity(world, body).linear.length() > 0.5 * turn * far
}

#[test]
fn doors_and_ships_that_turn_hit_what_is_in_their_way() {
    let mut passed = Vec::new();
    for turn in [2.0, 10.0, 20.0, 40.0] {
        for by_transform in [false, true] {
            for k in 0..40 {
                let (far, angle) = (0.8 + 0.075 * k as f32, 0.6 + 0.055 * k as f32);
                for (name, body) in [
                    ("ball", Collider::ball(0.1)),
                    ("cube", cube(0.2)),
                    ("capsule", Collider::capsule(0.07, 0.15)),
                ] {
                    if !sweeps(body, turn, by_transform, far, angle) {
                        passed.push(format!(
                            "{name} at {far:.2} m, {turn} rad/s, {by_transform}"
                        ));
                    }
                }
            }
        }
    }
    assert!(passed.is_empty(), "{} of 960: {passed:#?}", passed.len());
}
