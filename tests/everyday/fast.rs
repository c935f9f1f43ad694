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

/// How a bar of 8 m turns.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Turning {
    /// About its middle, by its `Velocity`.
    ByVelocity,
    /// About its middle, by its `Transform`.
    ByTransform,
    /// About its end, by its `Transform`, as a gate.
    AboutEnd,
    /// A dynamic gate on a hinge at its end.
    Hinged,
}

/// Whether a bar that turns at `turn` rad/s strikes a body that stands at a distance from the axis (m), at an angle (rad) ahead.
fn strikes(bar: Turning, body: Collider, turn: f32, (far, angle): (f32, f32), dt: f32) -> bool {
    let mut app = app();
    let world = app.world_mut();
    world.resource_mut::<Gravity>().0 = Vec3::ZERO;
    let pivot = match bar {
        Turning::ByVelocity | Turning::ByTransform => 0.0,
        Turning::AboutEnd | Turning::Hinged => 4.0,
    };
    let pose = |angle: f32| {
        let turn = Quat::from_rotation_y(angle);
        Transform::from_translation(turn * Vec3::X * pivot).with_rotation(turn)
    };
    let id = world
        .spawn((Collider::cuboid(8.0, 2.0, 0.1), pose(0.0)))
        .id();
    let velocity_of = Velocity {
        linear: Vec3::NEG_Z * pivot * turn,
        angular: Vec3::Y * turn,
    };
    match bar {
        Turning::ByVelocity => world
            .entity_mut(id)
            .insert((RigidBody::Kinematic, velocity_of)),
        Turning::Hinged => world
            .entity_mut(id)
            .insert((RigidBody::Dynamic, velocity_of)),
        _ => world.entity_mut(id).insert(RigidBody::Kinematic),
    };
    if bar == Turning::Hinged {
        world.spawn(
            RevoluteJoint::new(None, id)
                .with_anchor(Vec3::ZERO)
                .with_hinge_axis(Vec3::Y),
        );
    }
    let place = Quat::from_rotation_y(angle) * Vec3::X * far;
    let place = Transform::from_translation(place);
    let body = world.spawn((RigidBody::Dynamic, body, place)).id();
    if matches!(bar, Turning::ByTransform | Turning::AboutEnd) {
        steps_of(world, 1, dt);
    }
    for k in 0..(1.2 * angle / turn / dt) as usize + 4 {
        if matches!(bar, Turning::ByTransform | Turning::AboutEnd) {
            *world.get_mut::<Transform>(id).unwrap() = pose(turn * (k + 1) as f32 * dt);
        }
        steps_of(world, 1, dt);
    }
    velocity(world, body).linear.length() > 0.4 * turn * far
}

#[test]
fn turning_gates_and_ships_strike_bodies_in_their_way() {
    let bodies = [
        Collider::ball(0.1),
        cube(0.2),
        Collider::capsule(0.07, 0.15),
        Collider::cylinder(0.1, 0.2),
    ];
    let (mut passed, mut count) = (Vec::new(), 0);
    // Bars that turn about their middle may turn by 0.67 rad in a step, those that turn about their end by half of that: their middle moves
    // along the chord.
    let rates = [
        (2.0, DT),
        (10.0, DT),
        (20.0, DT),
        (3.0, 0.1),
        (40.0, 1.0 / 240.0),
    ];
    let fast = [(40.0, DT), (6.0, 0.1)];
    for bar in [
        Turning::ByVelocity,
        Turning::ByTransform,
        Turning::AboutEnd,
        Turning::Hinged,
    ] {
        let more = match bar {
            Turning::ByVelocity | Turning::ByTransform => &fast[..],
            _ => &[],
        };
        for &(turn, dt) in rates.iter().chain(more) {
            for k in 0..40 {
                let at = (0.8 + 0.075 * k as f32, 0.6 + 0.055 * k as f32);
                for (i, body) in bodies.iter().enumerate() {
                    count += 1;
                    if !strikes(bar, body.clone(), turn, at, dt) {
                        passed.push(format!("{bar:?}, body {i} at {at:?}, {turn} rad/s, {dt} s"));
                    }
                }
            }
        }
    }
    assert!(
        passed.is_empty(),
        "{} of {count}: {passed:#?}",
        passed.len()
    );
}
