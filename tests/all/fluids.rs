//! Water and wind: what floats floats as deep as Archimedes says, bobs and rolls in time, and drifts.

use bevy_ecs::message::Messages;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::body::Sleeping;
use drystone::diagnosis::{BodyError, BodyProblem};
use drystone::fluid::{FluidPoint, FluidState};
use drystone::prelude::*;
use drystone::settings::SleepSettings;
use drystone::snapshot::Snapshot;
use std::f32::consts::{FRAC_PI_2, PI, TAU};
use support::*;

const G: f32 = 9.81;

/// A lake whose surface is at a height of zero.
fn lake(fluid: Fluid) -> (Lab, Entity) {
    let mut lab = Lab::new();
    let lake = lab.spawn((Collider::half_space(Vec3::Y), fluid, Transform::default()));
    (lab, lake)
}

fn still() -> Fluid {
    Fluid {
        damping: 0.0,
        drag: 0.0,
        ..Fluid::water()
    }
}

fn steps(lab: &mut Lab, count: usize) {
    (0..count).for_each(|_| lab.step());
}

fn body(shape: Collider, density: f32, at: Transform) -> impl Bundle {
    (RigidBody::Dynamic, shape, Density(density), at)
}

fn lying(at: Vec3) -> Transform {
    Transform::from_translation(at).with_rotation(Quat::from_rotation_z(FRAC_PI_2))
}

/// The draft of a horizontal cylinder of which a share is below the surface, m.
fn draft_of_cylinder(radius: f32, share: f32) -> f32 {
    let (mut low, mut high) = (0.0f32, 2.0 * radius);
    for _ in 0..50 {
        let draft = 0.5 * (low + high);
        let angle = 2.0 * ((radius - draft) / radius).acos();
        let below = (angle - angle.sin()) / TAU;
        if below < share {
            low = draft
        } else {
            high = draft
        }
    }
    low
}

/// The draft of a ball of which a share is below the surface, m.
fn draft_of_ball(radius: f32, share: f32) -> f32 {
    let (mut low, mut high) = (0.0f32, 2.0 * radius);
    for _ in 0..50 {
        let draft = 0.5 * (low + high);
        let below = draft * draft * (3.0 * radius - draft) / (4.0 * radius.powi(3));
        if below < share {
            low = draft
        } else {
            high = draft
        }
    }
    low
}

#[test]
fn bodies_float_as_deep_as_archimedes_says() {
    let flat = |at: f32| Transform::from_xyz(0.0, at, 0.0);
    // Its shape and density, its start, and the height of its centre of mass at rest.
    let cases = [
        (
            "raft",
            Collider::cuboid(2.0, 0.3, 1.5),
            600.0,
            flat(0.1),
            0.15 - 0.3 * 0.6,
        ),
        (
            "cork",
            Collider::cuboid(0.5, 0.2, 0.5),
            200.0,
            flat(0.3),
            0.1 - 0.2 * 0.2,
        ),
        (
            "barrel",
            Collider::cylinder(0.3, 1.0),
            700.0,
            lying(Vec3::ZERO),
            0.3 - draft_of_cylinder(0.3, 0.7),
        ),
        (
            "buoy",
            Collider::ball(0.5),
            350.0,
            flat(0.3),
            0.5 - draft_of_ball(0.5, 0.35),
        ),
        ("disc", Collider::cylinder(0.8, 0.3), 500.0, flat(0.2), 0.0),
    ];
    for (name, shape, density, at, height) in cases {
        for dt in [1.0 / 60.0, 1.0 / 30.0] {
            let (mut lab, _) = lake(Fluid::water());
            let size = shape.half_extents().min_element();
            let of = lab.spawn(body(shape.clone(), density, at));
            for _ in 0..(30.0 / dt) as usize {
                step(&mut lab.world, dt).unwrap();
            }
            let found = lab.world.get::<Pose>(of).unwrap().position.y;
            // Within a hundredth of its draft.
            assert!(
                (found - height).abs() < 0.01 * (size - height),
                "{name}: {found} instead of {height}"
            );
            assert!(
                lab.world.get::<Sleeping>(of).unwrap().asleep,
                "{name} is awake: {:?}",
                lab.world.get::<Velocity>(of).unwrap()
            );
        }
    }
}

/// A hull of planks, each a collider of its own, with a keel of lead.
fn ship(lab: &mut Lab, at: Transform) -> Entity {
    let plank = |x: f32, y: f32, z: f32, place: Vec3, density: f32| {
        (
            Collider::cuboid(x, y, z),
            Density(density),
            Transform::from_translation(place),
        )
    };
    let ship = lab.spawn((RigidBody::Dynamic, at));
    let parts = [
        plank(3.0, 0.1, 1.0, Vec3::ZERO, 700.0),
        plank(3.0, 0.6, 0.1, Vec3::new(0.0, 0.35, 0.45), 700.0),
        plank(3.0, 0.6, 0.1, Vec3::new(0.0, 0.35, -0.45), 700.0),
        plank(0.1, 0.6, 0.8, Vec3::new(1.45, 0.35, 0.0), 700.0),
        plank(0.1, 0.6, 0.8, Vec3::new(-1.45, 0.35, 0.0), 700.0),
        plank(2.0, 0.2, 0.02, Vec3::new(0.0, -0.15, 0.0), 2000.0),
    ];
    for part in parts {
        let part = lab.spawn(part);
        lab.world.entity_mut(ship).add_child(part);
    }
    ship
}

#[test]
fn a_ship_of_planks_floats_as_deep_as_its_planks_say_and_rights_itself() {
    let (mut lab, _) = lake(Fluid::water());
    let turned = Quat::from_rotation_x(0.4);
    let of = ship(
        &mut lab,
        Transform::from_xyz(0.0, 0.1, 0.0).with_rotation(turned),
    );
    steps(&mut lab, 1800);
    let mass = lab.mass(of).mass();
    // Wet up to a height h above the bottom plank's middle: planks of 0.72 m² in plan above the bottom and the keel.
    let walls = 2.0 * 3.0 * 0.1 + 2.0 * 0.1 * 0.8;
    let below = 3.0 * 0.1 * 1.0 + 2.0 * 0.2 * 0.02;
    let draft = (mass / 1000.0 - below) / walls;
    let pose = *lab.world.get::<Pose>(of).unwrap();
    let found = -pose.position.y - 0.05;
    assert!(
        (found - draft).abs() < 0.01 * (draft + 0.1),
        "{found} instead of {draft}"
    );
    let up = pose.rotation * Vec3::Y;
    assert!(up.y > 0.9999, "{up}");
    assert!(lab.world.get::<Sleeping>(of).unwrap().asleep);
}

/// The mean time between upward passages of a value through its mean, s.
fn period(values: &[f32], dt: f32) -> f32 {
    let mean = values.iter().sum::<f32>() / values.len() as f32;
    let rising = |i: usize| values[i] < mean && values[i + 1] >= mean;
    let passages: Vec<f32> = (0..values.len() - 1)
        .filter(|&i| rising(i))
        .map(|i| i as f32 + (mean - values[i]) / (values[i + 1] - values[i]))
        .collect();
    assert!(passages.len() > 3, "{}", passages.len());
    (passages[passages.len() - 1] - passages[0]) / (passages.len() - 1) as f32 * dt
}

#[test]
fn a_block_bobs_with_the_period_of_its_draft() {
    let (mut lab, _) = lake(still());
    let draft = 0.5 * 0.6;
    let of = lab.spawn(body(
        Collider::cuboid(2.0, 0.5, 2.0),
        600.0,
        Transform::from_xyz(0.0, 0.25 - draft + 0.05, 0.0),
    ));
    let dt = 1.0 / 60.0;
    let heights: Vec<f32> = (0..1200)
        .map(|_| {
            lab.step();
            lab.world.get::<Pose>(of).unwrap().position.y
        })
        .collect();
    let expected = TAU * (draft / G).sqrt();
    let found = period(&heights, dt);
    assert!(
        (found / expected - 1.0).abs() < 0.01,
        "{found} instead of {expected}"
    );
    // Nothing takes its energy.
    let highest = |of: &[f32]| of.iter().copied().fold(f32::MIN, f32::max);
    let [early, late] = [&heights[..300], &heights[900..]].map(highest);
    assert!((late - early).abs() < 0.002, "{early} {late}");
}

#[test]
fn a_barrel_with_ballast_rolls_with_the_period_of_its_pendulum() {
    let (mut lab, _) = lake(still());
    let radius = 0.4;
    // Its centre of mass is a tenth of a metre beside the axis: it starts a little off the lowest place.
    let arm = 0.1;
    let of = lab.spawn((
        body(Collider::cylinder(radius, 1.0), 500.0, Transform::default()),
        CenterOfMass(Vec3::new(arm, 0.0, 0.0)),
        AngularInertia {
            principal: Vec3::new(30.0, 20.0, 30.0),
            local_frame: Quat::IDENTITY,
        },
    ));
    let mass = 500.0 * PI * radius * radius;
    // The axis of the barrel along z, and its centre of mass nearly straight below.
    let turned = Quat::from_rotation_x(FRAC_PI_2) * Quat::from_rotation_y(0.15 - FRAC_PI_2);
    lab.world
        .entity_mut(of)
        .insert(Transform::from_rotation(turned));
    let dt = 1.0 / 60.0;
    let angles: Vec<f32> = (0..1800)
        .map(|_| {
            lab.step();
            let out = lab.world.get::<Pose>(of).unwrap().rotation * Vec3::X;
            (out.x).atan2(-out.y)
        })
        .collect();
    // About the axis, which the water holds at its height; the barrel is free to shift, so it turns about its centre of mass.
    let expected = TAU * (20.0 / (mass * G * arm)).sqrt();
    let found = period(&angles, dt);
    assert!(
        (found / expected - 1.0).abs() < 0.01,
        "{found} instead of {expected}"
    );
    let largest = angles.iter().map(|angle| angle.abs()).fold(0.0, f32::max);
    assert!((largest - 0.15).abs() < 0.01, "{largest}");
}

#[test]
fn bodies_sink_with_the_speed_at_which_drag_bears_them() {
    let water = Fluid {
        damping: 0.0,
        ..Fluid::water()
    };
    let cases = [
        ("cube", Collider::cuboid(0.3, 0.3, 0.3), 0.027, 0.09),
        (
            "ball",
            Collider::ball(0.2),
            4.0 / 3.0 * PI * 0.008,
            0.5 * PI * 0.04,
        ),
    ];
    for (name, shape, volume, seen) in cases {
        let (mut lab, _) = lake(water);
        let of = lab.spawn(body(shape, 1800.0, Transform::from_xyz(0.0, -2.0, 0.0)));
        steps(&mut lab, 600);
        let expected = (2.0 * 800.0 * volume * G / (1000.0 * seen)).sqrt();
        let found = -lab.world.get::<Velocity>(of).unwrap().linear.y;
        assert!(
            (found / expected - 1.0).abs() < 0.01,
            "{name}: {found} instead of {expected}"
        );
    }
}

/// A tall block of half the density of water lies down on its side. A flat one rights itself.
#[test]
fn what_is_too_tall_tips_over() {
    let (mut lab, _) = lake(Fluid::water());
    let tall = lab.spawn(body(
        Collider::cuboid(0.4, 1.2, 0.4),
        500.0,
        Transform::from_rotation(Quat::from_rotation_z(0.02)),
    ));
    let flat = lab.spawn(body(
        Collider::cuboid(1.2, 0.4, 1.2),
        500.0,
        Transform::from_xyz(5.0, 0.0, 0.0).with_rotation(Quat::from_rotation_z(0.3)),
    ));
    steps(&mut lab, 1200);
    let up = |lab: &Lab, of: Entity| {
        (lab.world.get::<Pose>(of).unwrap().rotation * Vec3::Y)
            .y
            .abs()
    };
    assert!(up(&lab, tall) < 0.1, "{}", up(&lab, tall));
    assert!(up(&lab, flat) > 0.999, "{}", up(&lab, flat));
}

#[test]
fn what_drifts_takes_the_velocity_of_the_flow() {
    let (mut lab, _) = lake(Fluid {
        flow: Vec3::new(2.0, 0.0, -1.0),
        ..Fluid::water()
    });
    let log = lab.spawn(body(Collider::cylinder(0.2, 2.0), 600.0, lying(Vec3::ZERO)));
    steps(&mut lab, 1200);
    let velocity = lab.world.get::<Velocity>(log).unwrap().linear;
    assert!(
        (velocity - Vec3::new(2.0, 0.0, -1.0)).length() < 0.02,
        "{velocity}"
    );
    // A wind of 20 m/s presses on a wall of 2 m² with 480 N, which tips a thin one and not a thick one.
    let mut lab = Lab::new();
    lab.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
    lab.spawn((
        Collider::half_space(Vec3::Y),
        Fluid::air(Vec3::X * 20.0),
        Transform::from_xyz(0.0, 100.0, 0.0),
    ));
    let wall = |thick: f32, z: f32| {
        let at = Transform::from_xyz(0.0, 1.0, z);
        (
            body(Collider::cuboid(thick, 2.0, 1.0), 1000.0, at),
            Friction::new(2.0),
        )
    };
    // It tips if 480 N · 1 m exceed the weight times half the thickness: below 0.22 m.
    let (thin, thick) = (lab.spawn(wall(0.19, 0.0)), lab.spawn(wall(0.25, 5.0)));
    steps(&mut lab, 300);
    let up = |lab: &Lab, of: Entity| (lab.world.get::<Pose>(of).unwrap().rotation * Vec3::Y).y;
    assert!(up(&lab, thin) < 0.1, "{}", up(&lab, thin));
    assert!(up(&lab, thick) > 0.9999, "{}", up(&lab, thick));
}

#[test]
fn light_bodies_float_still() {
    for (shape, density) in [
        (Collider::ball(0.2), 8.0),
        (Collider::cuboid(0.05, 0.05, 0.05), 10.0),
        (Collider::cuboid(2.0, 0.01, 2.0), 300.0),
    ] {
        let (mut lab, _) = lake(Fluid::water());
        let of = lab.spawn(body(
            shape.clone(),
            density,
            Transform::from_xyz(0.0, 0.3, 0.0),
        ));
        steps(&mut lab, 1200);
        let velocity = lab.world.get::<Velocity>(of).unwrap();
        assert!(
            velocity.linear.length() < 0.01 && velocity.angular.length() < 0.05,
            "{shape:?} {velocity:?}"
        );
    }
}

#[test]
fn floating_bodies_sleep_until_something_changes() {
    type Change = fn(&mut World, Entity, Entity);
    let changes: [(&str, Change); 5] = [
        ("level", |world, lake, _| {
            world.get_mut::<Fluid>(lake).unwrap().level = Some(-0.5)
        }),
        ("surface", |world, lake, _| {
            world.get_mut::<Transform>(lake).unwrap().translation.y = 0.4
        }),
        ("removed", |world, lake, _| {
            _ = world.entity_mut(lake).remove::<Fluid>()
        }),
        ("despawned", |world, lake, _| _ = world.despawn(lake)),
        ("load", |world, _, raft| {
            let at = world.get::<Transform>(raft).unwrap().translation + Vec3::Y * 0.5;
            world.spawn(body(
                Collider::cuboid(0.5, 0.3, 0.5),
                3000.0,
                Transform::from_translation(at),
            ));
        }),
    ];
    for (name, change) in changes {
        let (mut lab, lake) = lake(Fluid::water());
        let raft = lab.spawn(body(
            Collider::cuboid(2.0, 0.3, 2.0),
            500.0,
            Transform::default(),
        ));
        steps(&mut lab, 900);
        assert!(lab.world.get::<Sleeping>(raft).unwrap().asleep, "{name}");
        let before = lab.world.get::<Pose>(raft).unwrap().position.y;
        change(&mut lab.world, lake, raft);
        let mut way = 0.0f32;
        for _ in 0..60 {
            lab.step();
            way = way.max((lab.position(raft).y - before).abs());
        }
        assert!(way > 0.02, "{name}: {way}");
        if name == "load" {
            steps(&mut lab, 1200);
            let sunk = before - lab.world.get::<Pose>(raft).unwrap().position.y;
            let expected = 3000.0 * 0.075 / 4000.0;
            assert!(
                (sunk / expected - 1.0).abs() < 0.05,
                "{sunk} instead of {expected}"
            );
        }
    }
}

#[test]
fn waves_lift_what_floats() {
    // The sensor reaches over the crests.
    let (mut lab, lake) = lake(Fluid {
        level: Some(0.0),
        ..Fluid::water()
    });
    lab.world
        .entity_mut(lake)
        .insert(Transform::from_xyz(0.0, 1.0, 0.0));
    let waves = |at: Vec3, seconds: f32| FluidPoint {
        rise: 0.3 * (0.2 * at.x - 1.0 * seconds).sin(),
        ..Default::default()
    };
    lab.world.entity_mut(lake).insert(FluidField::new(waves));
    let raft = lab.spawn(body(
        Collider::cuboid(1.0, 0.2, 1.0),
        500.0,
        Transform::default(),
    ));
    steps(&mut lab, 600);
    let mut error = 0.0f32;
    let mut highest = 0.0f32;
    for _ in 0..600 {
        lab.step();
        let at = lab.world.get::<Pose>(raft).unwrap().position;
        let surface = waves(at, lab.world.get::<FluidState>(lake).unwrap().age).rise;
        error = error.max((at.y - surface).abs());
        highest = highest.max(at.y);
        assert!(!lab.world.get::<Sleeping>(raft).unwrap().asleep);
    }
    assert!(error < 0.03 && highest > 0.27, "{error} {highest}");
}

#[test]
fn an_invalid_fluid_is_reported_once_by_name_and_does_nothing() {
    let mut lab = Lab::new();
    let lake = lab.spawn((
        Collider::half_space(Vec3::Y),
        Fluid {
            density: f32::NAN,
            ..Fluid::water()
        },
        Name::new("lake"),
        Transform::default(),
    ));
    let stone = lab.spawn(body(Collider::ball(0.2), 500.0, Transform::default()));
    let mut reports = Vec::new();
    for _ in 0..30 {
        lab.step();
        let mut messages = lab.world.resource_mut::<Messages<BodyError>>();
        reports.extend(messages.drain());
    }
    assert_eq!(reports.len(), 1, "{reports:?}");
    assert_eq!(reports[0].problem, BodyProblem::InvalidFluid);
    assert!(reports[0].to_string().contains("`lake`"), "{}", reports[0]);
    assert!(lab.world.get::<Pose>(stone).unwrap().position.y < -1.0);
    lab.world.entity_mut(lake).insert(Fluid::water());
    steps(&mut lab, 300);
    assert!(lab.world.get::<Pose>(stone).unwrap().position.y > -0.3);
}

/// Two fluids over one body, parts in one of them, another order of the archetypes: the same bits go on after a snapshot.
#[test]
fn a_world_with_fluids_goes_on_from_a_snapshot_with_the_same_bits() {
    let (mut lab, _) = lake(Fluid {
        flow: Vec3::X,
        ..Fluid::water()
    });
    lab.spawn((
        Collider::half_space(Vec3::Y),
        Fluid::air(Vec3::Z * 8.0),
        Transform::from_xyz(0.0, 50.0, 0.0),
    ));
    let of = ship(&mut lab, Transform::from_xyz(0.0, 0.3, 0.0));
    steps(&mut lab, 50);
    let snapshot = Snapshot::take(&lab.world);
    let run = |lab: &mut Lab| {
        steps(lab, 100);
        (
            *lab.world.get::<Pose>(of).unwrap(),
            *lab.world.get::<Velocity>(of).unwrap(),
        )
    };
    let first = run(&mut lab);
    snapshot.restore(&mut lab.world).unwrap();
    assert_eq!(run(&mut lab), first);
}

#[test]
#[ignore = "measures time"]
fn a_thousand_bodies_that_float_take_less_than_three_milliseconds() {
    for (name, shape) in [
        ("crates", Collider::cuboid(0.5, 0.5, 0.5)),
        ("barrels", Collider::cylinder(0.25, 0.6)),
    ] {
        let (mut lab, _) = lake(Fluid::water());
        lab.world.resource_mut::<SleepSettings>().enabled = false;
        for i in 0..1000 {
            let at = Transform::from_xyz(2.0 * (i % 40) as f32, 0.1, 2.0 * (i / 40) as f32);
            lab.spawn(body(shape.clone(), 500.0, at));
        }
        steps(&mut lab, 60);
        let start = std::time::Instant::now();
        steps(&mut lab, 60);
        let mean = start.elapsed().as_secs_f64() / 60.0;
        println!("{name}: {:.2} ms a step", 1e3 * mean);
        assert!(mean < 3e-3, "{name}");
    }
}
