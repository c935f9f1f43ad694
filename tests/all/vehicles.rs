//! Vehicles: wheels as rays, which bear, drive, brake and steer as closed forms say, and a cart on jointed wheels.

use bevy_ecs::message::Messages;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::body::Sleeping;
use drystone::collider::CombineRule;
use drystone::diagnosis::{BodyError, BodyProblem};
use drystone::prelude::*;
use drystone::snapshot::Snapshot;
use drystone::vehicle::ackermann;
use glam::Vec3Swizzles;
use std::f32::consts::{FRAC_PI_2, PI, TAU};
use support::*;

const G: f32 = 9.81;
const MASS: f32 = 1200.0;

/// Distance of the axles, and of the wheels of an axle from the middle, m.
const BASE: f32 = 2.6;
const HALF_TRACK: f32 = 0.7;

/// Height of the body's centre with the default wheels at rest on flat ground, m.
fn height() -> f32 {
    let rate = TAU * 1.5;
    0.1 + 0.4 + 0.35 - G / (rate * rate)
}

/// A wheel that rolls without resistance, whose friction is that of the wheel alone.
fn plain() -> Wheel {
    Wheel {
        grip: Friction::new(0.8).with_rule(CombineRule::Max),
        rolling_resistance: 0.0,
        ..Default::default()
    }
}

struct Car {
    body: Entity,
    /// Front left and right, rear left and right.
    wheels: [Entity; 4],
}

/// A car whose centre of mass is in the middle of its wheels, as high as they are mounted.
fn car(lab: &mut Lab, wheel: Wheel, at: Transform) -> Car {
    let body = (
        RigidBody::Dynamic,
        Collider::cuboid(1.6, 0.5, 3.6),
        Mass(MASS),
    );
    let body = lab.spawn((body, Name::new("car"), at));
    let wheels = [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)].map(|(x, z)| {
        let place = Transform::from_xyz(x * HALF_TRACK, -0.1, z * 0.5 * BASE);
        lab.spawn((wheel, ChildOf(body), place))
    });
    Car { body, wheels }
}

impl Car {
    fn each(&self, lab: &mut Lab, mut change: impl FnMut(usize, &mut Wheel)) {
        for (number, wheel) in self.wheels.into_iter().enumerate() {
            change(number, &mut lab.world.get_mut::<Wheel>(wheel).unwrap());
        }
    }

    fn states(&self, lab: &Lab) -> [WheelState; 4] {
        self.wheels
            .map(|wheel| *lab.world.get::<WheelState>(wheel).unwrap())
    }

    fn pose(&self, lab: &Lab) -> Pose {
        *lab.world.get::<Pose>(self.body).unwrap()
    }

    fn speed(&self, lab: &Lab) -> Vec3 {
        lab.world.get::<Velocity>(self.body).unwrap().linear
    }

    fn sleeps(&self, lab: &Lab) -> bool {
        lab.world.get::<Sleeping>(self.body).unwrap().asleep
    }

    /// Sets it in motion, with its wheels rolling.
    fn roll(&self, lab: &mut Lab, speed: f32) {
        let forward = self.pose(lab).rotation * Vec3::NEG_Z;
        lab.world
            .entity_mut(self.body)
            .insert(Velocity::linear(speed * forward));
        for wheel in self.wheels {
            let radius = lab.world.get::<Wheel>(wheel).unwrap().radius;
            lab.world.get_mut::<WheelState>(wheel).unwrap().spin = speed / radius;
        }
    }
}

fn flat(dt: f32) -> Lab {
    let mut lab = Lab::new();
    lab.dt = dt;
    lab.ground();
    lab
}

fn raised(y: f32) -> Transform {
    Transform::from_xyz(0.0, y, 0.0)
}

const RATES: [f32; 2] = [1.0 / 60.0, 1.0 / 30.0];

#[test]
fn springs_are_compressed_by_the_weight_of_the_body() {
    for dt in RATES {
        for frequency in [1.0f32, 1.5, 3.0] {
            let mut lab = flat(dt);
            let wheel = Wheel {
                frequency,
                ..plain()
            };
            let car = car(&mut lab, wheel, raised(0.9));
            lab.run(8.0);
            // m g / (n k).
            let stiffness = MASS / 4.0 * (TAU * frequency) * (TAU * frequency);
            let expected = MASS * G / (4.0 * stiffness);
            for state in car.states(&lab) {
                let case = format!("{frequency} Hz, {dt} s: {state:?}");
                if expected < 0.3 {
                    assert!(
                        (state.compression / expected - 1.0).abs() < 0.01,
                        "{expected} {case}"
                    );
                }
                assert!(
                    (state.load / (0.25 * MASS * G) - 1.0).abs() < 0.01,
                    "{case}"
                );
            }
            assert!(
                car.sleeps(&lab),
                "{frequency} Hz, {dt} s: {}",
                car.speed(&lab)
            );
        }
    }
}

#[test]
fn a_body_without_dampers_bobs_with_the_frequency_of_its_springs_and_keeps_its_energy() {
    for (dt, frequency) in [(1.0 / 60.0, 1.5f32), (1.0 / 60.0, 2.0), (1.0 / 30.0, 1.0)] {
        let mut lab = flat(dt);
        lab.world.resource_mut::<SleepSettings>().enabled = false;
        let rate = TAU * frequency;
        let wheel = Wheel {
            frequency,
            damping_ratio: 0.0,
            suspension: 0.6,
            travel: 0.6,
            ..plain()
        };
        let middle = 0.1 + 0.6 + 0.35 - G / (rate * rate);
        let car = car(&mut lab, wheel, raised(middle + 0.03));
        let (mut crossings, mut last, mut highest) = (Vec::new(), 0.03f32, 0.0f32);
        for step in 1..(20.0 / dt) as usize {
            lab.step();
            let now = car.pose(&lab).position.y - middle;
            if last < 0.0 && now >= 0.0 {
                crossings.push((step as f32 - now / (now - last)) * dt);
            }
            last = now;
            if step as f32 * dt > 19.0 {
                highest = highest.max(now);
            }
        }
        let count = crossings.len() - 1;
        let found = count as f32 / (crossings[count] - crossings[0]);
        assert!(
            (found / frequency - 1.0).abs() < 0.02,
            "{found} Hz instead of {frequency}"
        );
        assert!(
            (0.02..0.0315).contains(&highest),
            "{highest} after 19 s at {frequency} Hz, {dt} s"
        );
    }
}

#[test]
fn locked_wheels_stop_a_car_within_its_braking_distance() {
    for dt in RATES {
        for speed in [10.0f32, 25.0] {
            let mut lab = flat(dt);
            let car = car(&mut lab, plain(), raised(height()));
            lab.run(1.0);
            car.roll(&mut lab, speed);
            lab.run(0.5);
            let start = car.pose(&lab).position;
            let speed = car.speed(&lab).length();
            car.each(&mut lab, |_, wheel| wheel.brake = 1e5);
            lab.run(10.0);
            let way = (car.pose(&lab).position - start).length();
            let expected = speed * speed / (2.0 * 0.8 * G);
            assert!(
                (way / expected - 1.0).abs() < 0.02,
                "{way} m instead of {expected}, {dt} s"
            );
            // It stands, and has not turned.
            assert!(car.speed(&lab).length() < 1e-3);
            let forward = car.pose(&lab).rotation * Vec3::NEG_Z;
            assert!(forward.x.abs() < 0.01, "{forward}");
        }
    }
}

#[test]
fn a_gentle_brake_slows_with_its_torque() {
    for dt in RATES {
        let mut lab = flat(dt);
        let wheel = Wheel {
            mass_share: 0.001,
            ..plain()
        };
        let car = car(&mut lab, wheel, raised(height()));
        lab.run(1.0);
        car.roll(&mut lab, 10.0);
        car.each(&mut lab, |_, wheel| wheel.brake = 300.0);
        let before = car.speed(&lab).length();
        lab.run(2.0);
        let lost = before - car.speed(&lab).length();
        let expected = 2.0 * 4.0 * 300.0 / 0.35 / MASS;
        assert!((lost / expected - 1.0).abs() < 0.02, "{lost} {expected}");
    }
}

#[test]
fn engines_accelerate_up_to_what_the_grip_allows() {
    for dt in RATES {
        // Torque of each wheel, the acceleration that it gives, and whether wheels spin.
        let weak = 4.0 * 100.0 / 0.35 / (MASS * (1.0 + 4.0 * 0.5 * 0.02));
        for (torque, expected, spins) in [(100.0, weak, false), (1e4, 0.8 * G, true)] {
            let mut lab = flat(dt);
            let car = car(&mut lab, plain(), raised(height()));
            lab.run(1.0);
            car.each(&mut lab, |_, wheel| wheel.engine = torque);
            lab.run(2.0);
            let before = -car.speed(&lab).z;
            lab.run(2.0);
            let found = (-car.speed(&lab).z - before) / 2.0;
            assert!(
                (found / expected - 1.0).abs() < 0.02,
                "{found} m/s² instead of {expected}, {dt} s"
            );
            let slip = car.states(&lab).map(|state| -state.slip.x);
            assert!(slip.iter().all(|slip| (*slip > 1.0) == spins), "{slip:?}");
            assert!(
                car.pose(&lab).position.x.abs() < 0.05,
                "{:?}",
                car.pose(&lab)
            );
        }
    }
}

#[test]
fn a_car_turns_about_the_point_to_which_its_axles_aim() {
    for dt in RATES {
        for angle in [0.1f32, 0.3, -0.5] {
            let mut lab = flat(dt);
            let car = car(&mut lab, plain(), raised(height()));
            lab.run(1.0);
            let radius = BASE / angle.tan();
            car.each(&mut lab, |number, wheel| {
                if number < 2 {
                    let across = [-HALF_TRACK, HALF_TRACK][number];
                    wheel.steering = ackermann(angle, BASE, across);
                }
            });
            car.roll(&mut lab, 1.5);
            let mut places = Vec::new();
            lab.run(2.0);
            let turned_before = (car.pose(&lab).rotation * Vec3::NEG_Z).xz();
            for _ in 0..(2.0 / dt) as usize {
                lab.step();
                // The middle of the rear axle.
                places.push(car.pose(&lab).transform_point(Vec3::Z * 0.5 * BASE));
            }
            let turned = (car.pose(&lab).rotation * Vec3::NEG_Z).xz();
            let turn = turned.angle_to(turned_before);
            let way: f32 = places
                .windows(2)
                .map(|pair| pair[0].distance(pair[1]))
                .sum();
            let found = way / turn;
            assert!(
                (found / radius - 1.0).abs() < 0.02,
                "{found} m instead of {radius}, {dt} s"
            );
        }
    }
}

#[test]
fn a_parked_car_does_not_creep_on_a_slope_and_sleeps() {
    for dt in RATES {
        // Up the slope, across it, and in between.
        for heading in [0.0f32, FRAC_PI_2, 0.7] {
            for sleeps in [false, true] {
                let mut lab = Lab::new();
                lab.dt = dt;
                lab.world.resource_mut::<SleepSettings>().enabled = sleeps;
                let slope = 0.2f32.atan();
                lab.slope(slope, 0.5);
                let turn = Quat::from_rotation_z(-slope) * Quat::from_rotation_y(heading);
                let at = Transform::from_translation(turn * Vec3::Y * height()).with_rotation(turn);
                let car = car(
                    &mut lab,
                    Wheel {
                        brake: 3000.0,
                        ..plain()
                    },
                    at,
                );
                lab.run(3.0);
                let start = car.pose(&lab);
                lab.run(60.0);
                let way = (car.pose(&lab).position - start.position).length();
                assert!(way < 1e-3, "{way} m in a minute, {heading} rad, {dt} s");
                assert_eq!(car.sleeps(&lab), sleeps, "{heading} rad, {dt} s");
                // Without brake it rolls, if it looks up or down.
                car.each(&mut lab, |_, wheel| wheel.brake = 0.0);
                lab.run(0.1);
                assert!(!car.sleeps(&lab));
                lab.run(0.9);
                let speed = car.speed(&lab).length();
                match heading == FRAC_PI_2 {
                    true => assert!((1.7..1.95).contains(&speed), "{speed}"),
                    false => assert!(speed < 1.7, "{speed}"),
                }
            }
        }
    }
}

#[test]
fn a_sleeping_car_wakes_when_its_ground_goes_and_when_it_is_driven() {
    for change in 0..3 {
        let mut lab = flat(1.0 / 60.0);
        let floor = lab.spawn((
            RigidBody::Static,
            Collider::cuboid(20.0, 1.0, 20.0),
            raised(0.5),
        ));
        let car = car(&mut lab, plain(), raised(1.0 + height()));
        lab.run(6.0);
        assert!(car.sleeps(&lab));
        match change {
            0 => _ = lab.world.despawn(floor),
            1 => car.each(&mut lab, |_, wheel| wheel.engine = 50.0),
            _ => *lab.world.get_mut::<Transform>(floor).unwrap() = raised(0.6),
        }
        lab.run(1.0);
        assert!(!car.sleeps(&lab), "change {change}");
        let (pose, speed) = (car.pose(&lab).position, car.speed(&lab));
        match change {
            0 => assert!(pose.y < 1.5, "{pose}"),
            1 => assert!(speed.z < -0.2, "{speed}"),
            _ => assert!(pose.y > height() + 1.05, "{pose}"),
        }
    }
}

/// The height of the terrain, m.
fn terrain(x: f32, z: f32) -> f32 {
    0.5 * (0.21 * x).sin() * (0.17 * z).cos() + 0.15 * (0.6 * x + 0.4 * z).sin()
}

/// Sixteen tiles of 16 m, each a height field.
fn tiles(lab: &mut Lab, height: impl Fn(f32, f32) -> f32) {
    const CELLS: usize = 16;
    const SIZE: f32 = 16.0;
    for tile in 0..16 {
        let center = SIZE * Vec3::new((tile % 4) as f32 - 1.5, 0.0, (tile / 4) as f32 - 1.5);
        let place = |i: usize| SIZE * (i as f32 / CELLS as f32 - 0.5);
        let row = |i: usize| {
            let at = |j: usize| height(center.x + place(j), center.z + place(i));
            (0..=CELLS).map(at).collect()
        };
        let rows: Vec<Vec<f32>> = (0..=CELLS).map(row).collect();
        let field = Collider::height_field(&rows, Vec3::new(SIZE, 1.0, SIZE)).unwrap();
        lab.spawn((
            RigidBody::Static,
            field,
            Transform::from_translation(center),
        ));
    }
}

#[test]
fn seams_of_flat_tiles_are_not_felt() {
    // Along a seam with the left wheels in it, across seams, and at an angle.
    for (at, heading) in [(HALF_TRACK, 0.0f32), (3.3, 0.0), (0.0, 0.6)] {
        for dt in RATES {
            let mut lab = Lab::new();
            lab.dt = dt;
            tiles(&mut lab, |_, _| 0.0);
            let turn = Quat::from_rotation_y(heading);
            let start = turn * Vec3::new(at, height(), 26.0);
            let car = car(
                &mut lab,
                plain(),
                Transform::from_translation(start).with_rotation(turn),
            );
            lab.run(0.4);
            car.roll(&mut lab, 12.0);
            let (mut lowest, mut highest) = (f32::MAX, f32::MIN);
            for _ in 0..(4.0 / dt) as usize {
                lab.step();
                lowest = lowest.min(car.pose(&lab).position.y);
                highest = highest.max(car.pose(&lab).position.y);
            }
            let speed = car.speed(&lab).length();
            assert!(
                highest - lowest < 1e-4,
                "{lowest}..{highest}, {at} m, {heading} rad, {dt} s"
            );
            assert!((speed - 12.0).abs() < 0.05, "{speed}");
        }
    }
}

#[test]
fn a_car_drives_over_hills_of_tiles() {
    for dt in RATES {
        for heading in [0.0f32, 0.7, 2.0, 4.0] {
            let mut lab = Lab::new();
            lab.dt = dt;
            tiles(&mut lab, terrain);
            let turn = Quat::from_rotation_y(heading);
            let start = turn * Vec3::new(0.0, 0.0, 24.0);
            let start = start.with_y(terrain(start.x, start.z) + height() + 0.1);
            let car = car(
                &mut lab,
                plain(),
                Transform::from_translation(start).with_rotation(turn),
            );
            lab.run(1.0);
            car.roll(&mut lab, 6.0);
            let steps = (6.0 / dt) as usize;
            let mut last = car.speed(&lab);
            for _ in 0..steps {
                lab.step();
                let speed = -car.speed(&lab).dot(car.pose(&lab).rotation * Vec3::Z);
                // Keeps its speed.
                car.each(&mut lab, |_, wheel| {
                    wheel.engine = (400.0 * (6.0 - speed)).clamp(-500.0, 500.0)
                });
                let at = car.pose(&lab);
                let above = at.position.y - terrain(at.position.x, at.position.z);
                assert!(
                    (0.5..1.2).contains(&above),
                    "{above} m above ground, {heading} rad, {dt} s"
                );
                let up = at.rotation * Vec3::Y;
                assert!(up.y > 0.85, "{up}");
                let jump = (car.speed(&lab) - last).length() / dt;
                assert!(jump < 12.0, "{jump} m/s², {heading} rad, {dt} s");
                last = car.speed(&lab);
            }
            let way = (car.pose(&lab).position - start).xz().length();
            assert!(way > 30.0, "{way} m, {heading} rad, {dt} s");
        }
    }
}

#[test]
fn a_car_drives_over_a_bridge_of_loose_planks_and_presses_on_it() {
    for dt in RATES {
        let mut lab = Lab::new();
        lab.dt = dt;
        // Two banks with a gap of 3 m, and planks over it.
        for z in [-11.5, 11.5] {
            let bank = Collider::cuboid(8.0, 1.0, 20.0);
            lab.spawn((RigidBody::Static, bank, Transform::from_xyz(0.0, -0.5, z)));
        }
        for z in [-12.05, 12.05] {
            let road = (
                Collider::cuboid(8.0, 0.1, 20.0),
                Transform::from_xyz(0.0, 0.05, z),
            );
            lab.spawn((RigidBody::Static, road));
        }
        let planks: Vec<Entity> = (0..8)
            .map(|i| {
                let at = Transform::from_xyz(-1.4 + 0.4 * i as f32, 0.05, 0.0);
                let plank = (
                    RigidBody::Dynamic,
                    Collider::cuboid(0.38, 0.1, 4.0),
                    Density(600.0),
                );
                lab.spawn((plank, Load::default(), at))
            })
            .collect();
        let car = car(
            &mut lab,
            plain(),
            Transform::from_xyz(0.0, 0.1 + height(), 8.0),
        );
        lab.run(2.0);
        car.roll(&mut lab, 4.0);
        let (mut most, mut on_bridge) = (0.0f32, false);
        for _ in 0..(4.0 / dt) as usize {
            lab.step();
            let contacts = car.states(&lab).map(|state| state.contact);
            let bodies = contacts.iter().flatten().map(|contact| contact.body);
            on_bridge |= bodies.into_iter().all(|body| planks.contains(&body));
            let borne = planks
                .iter()
                .map(|plank| borne_by_contacts(&mut lab, *plank));
            most = most.max(borne.sum());
        }
        let own = planks.len() as f32 * 0.38 * 0.1 * 4.0 * 600.0 * G;
        assert!(on_bridge, "{dt} s");
        assert!(
            (most / (own + MASS * G) - 1.0).abs() < 0.1,
            "{most} N of {} N",
            own + MASS * G
        );
        let at = car.pose(&lab).position;
        assert!(
            at.z < -6.0 && (at.y - 0.1 - height()).abs() < 0.02,
            "{at}, {dt} s"
        );
        for plank in planks {
            let at = lab.world.get::<Pose>(plank).unwrap().position;
            assert!(
                (at.y - 0.05).abs() < 0.01 && at.z.abs() < 0.1,
                "{at}, {dt} s"
            );
        }
    }
}

/// The force with which contacts push a body up, N.
fn borne_by_contacts(lab: &mut Lab, body: Entity) -> f32 {
    let faces = contacts(&mut lab.world, |contacts| contacts.on(body)).unwrap();
    faces.iter().map(|face| face.force.y).sum()
}

#[test]
fn a_car_parked_on_a_bridge_sleeps_with_it() {
    let mut lab = Lab::new();
    for z in [-2.0, 2.0] {
        let pier = (
            RigidBody::Static,
            Collider::cuboid(8.0, 1.0, 0.6),
            Transform::from_xyz(0.0, -0.5, z),
        );
        lab.spawn(pier);
    }
    let deck = lab.spawn((
        RigidBody::Dynamic,
        Collider::cuboid(3.0, 0.2, 5.0),
        raised(0.1),
    ));
    let car = car(
        &mut lab,
        Wheel {
            brake: 1000.0,
            ..plain()
        },
        raised(0.2 + height()),
    );
    lab.run(8.0);
    assert!(car.sleeps(&lab));
    assert!(lab.world.get::<Sleeping>(deck).unwrap().asleep);
    // A blow on the deck wakes both.
    lab.world.entity_mut(deck).insert(Velocity::linear(Vec3::Y));
    lab.run(0.1);
    assert!(!car.sleeps(&lab));
    lab.run(8.0);
    assert!(car.sleeps(&lab));
    // The car drives off, and the deck wakes.
    car.each(&mut lab, |_, wheel| {
        (wheel.brake, wheel.engine) = (0.0, 200.0)
    });
    lab.run(0.2);
    assert!(!lab.world.get::<Sleeping>(deck).unwrap().asleep);
}

#[test]
fn an_invalid_wheel_is_reported_once_by_name_and_does_nothing() {
    let mut lab = flat(1.0 / 60.0);
    let car = car(&mut lab, plain(), raised(height()));
    lab.run(4.0);
    lab.world
        .entity_mut(car.wheels[0])
        .insert(Name::new("front left"));
    car.each(&mut lab, |number, wheel| {
        if number == 0 {
            wheel.radius = f32::NAN
        }
    });
    let mut reports = Vec::new();
    for _ in 0..60 {
        lab.step();
        reports.extend(lab.world.resource_mut::<Messages<BodyError>>().drain());
    }
    assert_eq!(reports.len(), 1, "{reports:?}");
    assert_eq!(reports[0].problem, BodyProblem::InvalidWheel);
    assert!(
        reports[0].to_string().contains("`front left`"),
        "{}",
        reports[0]
    );
    let up = car.pose(&lab).rotation * Vec3::Y;
    assert!(up.y < 0.9999, "it stands on three wheels: {up}");
    car.each(&mut lab, |_, wheel| *wheel = plain());
    lab.run(5.0);
    let up = car.pose(&lab).rotation * Vec3::Y;
    assert!(up.y > 0.99999, "{up}");
}

#[test]
fn a_car_goes_on_from_a_snapshot_with_the_same_bits() {
    let mut lab = Lab::new();
    tiles(&mut lab, terrain);
    let car = car(
        &mut lab,
        Wheel {
            engine: 150.0,
            steering: 0.1,
            ..plain()
        },
        raised(1.3),
    );
    lab.run(2.0);
    let snapshot = Snapshot::take(&lab.world);
    let run = |lab: &mut Lab| {
        lab.run(2.0);
        (
            car.pose(lab),
            car.states(lab).map(|state| (state.spin, state.angle)),
        )
    };
    let first = run(&mut lab);
    snapshot.restore(&mut lab.world).unwrap();
    assert_eq!(run(&mut lab), first);
}

#[test]
fn a_wheel_may_be_on_the_body_itself_and_spins_in_the_air() {
    let mut lab = flat(1.0 / 60.0);
    let wheel = Wheel {
        engine: 10.0,
        ..plain()
    };
    let body = (
        RigidBody::Dynamic,
        Mass(10.0),
        LockedAxes::ROTATION_LOCKED,
        wheel,
    );
    let body = lab.spawn((
        body,
        Collider::cuboid(0.2, 0.2, 0.2),
        GravityScale(0.0),
        raised(3.0),
    ));
    lab.run(1.0);
    let state = *lab.world.get::<WheelState>(body).unwrap();
    let inertia = 0.5 * 0.2 * 0.35 * 0.35;
    assert!(
        (state.spin / (10.0 / inertia) - 1.0).abs() < 1e-3,
        "{state:?}"
    );
    assert_eq!(state.contact, None);
    assert_eq!(lab.world.get::<Pose>(body).unwrap().position, Vec3::Y * 3.0);
}

struct Cart {
    body: Entity,
    motors: Vec<Entity>,
}

/// A cart on four cylinders, with motors at the rear axle.
fn cart(lab: &mut Lab, at: Vec3) -> Cart {
    let body = (
        RigidBody::Dynamic,
        Collider::cuboid(1.0, 0.3, 2.0),
        Mass(300.0),
    );
    let body = lab.spawn((body, Transform::from_translation(at)));
    let mut motors = Vec::new();
    for (x, z) in [(-0.7, -0.8), (0.7, -0.8), (-0.7, 0.8), (0.7, 0.8)] {
        let center = at + Vec3::new(x, -0.2, z);
        let turn = Quat::from_rotation_z(FRAC_PI_2);
        let wheel = (
            RigidBody::Dynamic,
            Collider::cylinder(0.4, 0.2),
            Mass(20.0),
            Friction::new(1.0),
        );
        let place = Transform::from_translation(center).with_rotation(turn);
        let wheel = lab.spawn((wheel, RollingFriction::new(0.0), place));
        let joint = RevoluteJoint::new(body, wheel)
            .with_anchor(center)
            .with_hinge_axis(Vec3::X);
        let joint = lab.spawn(joint);
        if z > 0.0 {
            motors.push(joint);
        }
    }
    Cart { body, motors }
}

#[test]
fn a_cart_on_jointed_wheels_rolls_down_and_drives_over_tiles() {
    for dt in RATES {
        // Down a slope of 10 %, without a motor.
        let mut lab = Lab::new();
        lab.dt = dt;
        tiles(&mut lab, |_, z| 0.1 * z);
        let rolling = cart(&mut lab, Vec3::new(0.3, 2.8, 20.0));
        lab.run(3.0);
        let speed = -lab.world.get::<Velocity>(rolling.body).unwrap().linear.z;
        // Cylinders: the energy of their spin is half that of their motion.
        let expected = 3.0 * G * 0.1 * 380.0 / (380.0 + 40.0);
        assert!(
            (0.85..1.05).contains(&(speed / expected)),
            "{speed} m/s of {expected}, {dt} s"
        );
        // Over hills, with the motors on.
        let mut lab = Lab::new();
        lab.dt = dt;
        tiles(&mut lab, terrain);
        let driving = cart(&mut lab, Vec3::new(0.3, terrain(0.3, 24.0) + 0.8, 24.0));
        lab.run(1.0);
        for joint in &driving.motors {
            let motor = JointMotor::velocity(-5.0, 400.0);
            lab.world.get_mut::<RevoluteJoint>(*joint).unwrap().motor = Some(motor);
        }
        let start = lab.world.get::<Pose>(driving.body).unwrap().position;
        let mut steepest = 1.0f32;
        for _ in 0..(12.0 / dt) as usize {
            lab.step();
            let pose = lab.world.get::<Pose>(driving.body).unwrap();
            steepest = steepest.min((pose.rotation * Vec3::Y).y);
            let above = pose.position.y - terrain(pose.position.x, pose.position.z);
            assert!(
                (0.3..1.1).contains(&above),
                "{above} m above ground, {dt} s"
            );
        }
        let way = (lab.world.get::<Pose>(driving.body).unwrap().position - start).length();
        assert!(way > 18.0 && steepest > 0.9, "{way} m, {steepest}, {dt} s");
    }
}

#[test]
fn the_wheels_of_an_axle_aim_at_one_point() {
    for angle in [0.0, 0.2, -0.4] {
        let [left, right] = [-HALF_TRACK, HALF_TRACK].map(|across| ackermann(angle, BASE, across));
        if angle == 0.0 {
            assert_eq!([left, right], [0.0; 2]);
            continue;
        }
        let radius = |steering: f32| BASE / steering.tan();
        assert!(
            (radius(right) - radius(left) - 2.0 * HALF_TRACK).abs() < 1e-4 * radius(angle).abs()
        );
    }
    assert!((ackermann(0.5 * PI * 0.999, BASE, 0.0) - 0.5 * PI * 0.999).abs() < 1e-3);
}

#[test]
fn a_curb_lifts_a_car_and_does_not_throw_it() {
    for dt in RATES {
        let mut lab = flat(dt);
        let curb = (
            Collider::cuboid(10.0, 0.24, 40.0),
            Transform::from_xyz(0.0, 0.0, -25.0),
        );
        lab.spawn((RigidBody::Static, curb));
        let car = car(&mut lab, plain(), raised(height()));
        lab.run(1.0);
        car.roll(&mut lab, 6.0);
        let mut highest = 0.0f32;
        for _ in 0..(4.0 / dt) as usize {
            lab.step();
            highest = highest.max(car.pose(&lab).position.y);
            let up = car.pose(&lab).rotation * Vec3::Y;
            assert!(up.y > 0.98, "{up}, {dt} s");
        }
        let rest = 0.12 + height();
        assert!(highest < rest + 0.1, "{highest} over {rest}, {dt} s");
        assert!((car.pose(&lab).position.y - rest).abs() < 2e-3, "{dt} s");
        assert!(
            (car.speed(&lab).length() - 6.0).abs() < 0.2,
            "{}, {dt} s",
            car.speed(&lab)
        );
    }
}

#[test]
fn a_car_that_falls_lands_on_its_springs() {
    for dt in RATES {
        for fall in [0.5f32, 2.0, 4.0] {
            let mut lab = flat(dt);
            let car = car(&mut lab, plain(), raised(height() + fall));
            let (mut lowest, mut rebound) = (f32::MAX, 0.0f32);
            for step in 0..(8.0 / dt) as usize {
                lab.step();
                let y = car.pose(&lab).position.y;
                lowest = lowest.min(y);
                if step as f32 * dt > (2.0 * fall / G).sqrt() + 0.3 {
                    rebound = rebound.max(y - height());
                }
            }
            // The suspension stops at the end of its travel, and the body does not touch the ground.
            let stop = 0.1 + 0.4 + 0.35 - 0.3;
            assert!(lowest > stop - 0.03, "{lowest} m, {fall} m, {dt} s");
            assert!(rebound < 0.2 * fall, "{rebound} of {fall} m, {dt} s");
            assert!(car.sleeps(&lab), "{fall} m, {dt} s");
        }
    }
}

#[test]
fn a_heavy_front_is_borne_by_the_front_wheels() {
    let mut lab = flat(1.0 / 60.0);
    let car = car(&mut lab, plain(), raised(height()));
    let forward = 0.3;
    lab.world
        .entity_mut(car.body)
        .insert(CenterOfMass(Vec3::new(0.0, -0.1, -forward)));
    lab.run(6.0);
    let states = car.states(&lab);
    let front = states[0].load + states[1].load;
    let expected = MASS * G * (0.5 + forward / BASE);
    assert!(
        (front / expected - 1.0).abs() < 0.02,
        "{front} N instead of {expected}"
    );
    assert!(car.sleeps(&lab));
}

#[test]
fn a_parked_car_goes_along_with_its_platform_and_with_a_belt() {
    for dt in RATES {
        for is_belt in [false, true] {
            let mut lab = Lab::new();
            lab.dt = dt;
            let deck = Collider::cuboid(40.0, 1.0, 40.0);
            let deck = match is_belt {
                true => lab.spawn((
                    RigidBody::Static,
                    deck,
                    SurfaceVelocity(Vec3::X),
                    raised(-0.5),
                )),
                false => lab.spawn((
                    RigidBody::Kinematic,
                    deck,
                    Velocity::linear(Vec3::X),
                    raised(-0.5),
                )),
            };
            let car = car(
                &mut lab,
                Wheel {
                    brake: 3000.0,
                    ..plain()
                },
                raised(height()),
            );
            lab.run(4.0);
            let moved = |lab: &Lab| match is_belt {
                true => 0.0,
                false => lab.world.get::<Pose>(deck).unwrap().position.x,
            };
            let (start, from) = (car.pose(&lab).position.x, moved(&lab));
            lab.run(4.0);
            let way = car.pose(&lab).position.x - start;
            let expected = if is_belt { 4.0 } else { moved(&lab) - from };
            assert!(
                (way - expected).abs() < 2e-3,
                "{way} m instead of {expected}, {is_belt}, {dt} s"
            );
        }
    }
}

/// A car that drives off pushes its sled back.
#[test]
fn wheels_push_their_ground_as_it_pushes_them() {
    for dt in RATES {
        let mut lab = Lab::new();
        lab.dt = dt;
        let ice = Friction::new(0.0).with_rule(CombineRule::Min);
        lab.spawn((RigidBody::Static, Collider::half_space(Vec3::Y), ice));
        let sled = (
            RigidBody::Dynamic,
            Collider::cuboid(4.0, 0.2, 20.0),
            Mass(3000.0),
            ice,
        );
        let sled = lab.spawn((sled, raised(0.1)));
        let car = car(&mut lab, plain(), raised(0.2 + height()));
        lab.run(3.0);
        car.each(&mut lab, |_, wheel| wheel.engine = 150.0);
        lab.run(1.5);
        let speed = lab.world.get::<Velocity>(sled).unwrap().linear.z;
        let momentum = [MASS * car.speed(&lab).z, 3000.0 * speed];
        assert!(momentum[1] > 1000.0, "{momentum:?}");
        assert!(
            (momentum[0] / momentum[1] + 1.0).abs() < 0.01,
            "{momentum:?}, {dt} s"
        );
    }
}

#[test]
fn a_car_stands_on_a_lorry_that_brakes() {
    for dt in RATES {
        let mut lab = flat(dt);
        let lorry = (
            RigidBody::Dynamic,
            Collider::cuboid(2.4, 0.4, 9.0),
            Mass(8000.0),
            raised(1.0),
        );
        let lorry = lab.spawn(lorry);
        let mut wheels = Vec::new();
        for (x, z) in [(-1.0, -3.0), (1.0, -3.0), (-1.0, 3.0), (1.0, 3.0)] {
            let place = Transform::from_xyz(x, -0.1, z);
            wheels.push(lab.spawn((
                Wheel {
                    radius: 0.5,
                    ..plain()
                },
                ChildOf(lorry),
                place,
            )));
        }
        let car = car(
            &mut lab,
            Wheel {
                brake: 3000.0,
                ..plain()
            },
            raised(1.2 + height()),
        );
        lab.run(4.0);
        let local = |lab: &Lab| {
            let under = *lab.world.get::<Pose>(lorry).unwrap();
            under.inverse_transform_point(car.pose(lab).position)
        };
        let before = local(&lab);
        let loads = wheels
            .iter()
            .map(|wheel| lab.world.get::<WheelState>(*wheel).unwrap().load);
        let load: f32 = loads.sum();
        assert!((load / (9200.0 * G) - 1.0).abs() < 0.02, "{load}, {dt} s");
        for wheel in &wheels {
            lab.world.get_mut::<Wheel>(*wheel).unwrap().engine = 1500.0;
        }
        lab.run(3.0);
        assert!(car.speed(&lab).z < -3.5, "{}", car.speed(&lab));
        for wheel in &wheels {
            let mut wheel = lab.world.get_mut::<Wheel>(*wheel).unwrap();
            (wheel.engine, wheel.brake) = (0.0, 4000.0);
        }
        lab.run(6.0);
        let way = (local(&lab) - before).length();
        assert!(way < 0.02, "it moved by {way} m on the lorry, {dt} s");
        assert!(
            car.speed(&lab).length() < 1e-3 && car.sleeps(&lab),
            "{dt} s"
        );
    }
}

/// A body that lies on the ground and has a wheel beside it does not slip, and sleeps.
#[test]
fn a_wheel_on_a_body_that_lies_does_not_keep_it_awake() {
    for dt in RATES {
        let mut lab = flat(dt);
        let body = lab.cube(Vec3::Y * 0.5);
        let wheel = lab.spawn((
            Wheel::default(),
            ChildOf(body),
            Transform::from_xyz(0.8, 0.2, 0.0),
        ));
        lab.run(3.0);
        let state = lab.world.get::<WheelState>(wheel).unwrap();
        assert!(
            state.load > 1000.0 && state.slip.length() < 1e-4,
            "{state:?}"
        );
        assert!(lab.world.get::<Sleeping>(body).unwrap().asleep, "{dt} s");
    }
}
