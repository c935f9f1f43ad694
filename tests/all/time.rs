//! Steps of any length, in any order, and cut into any number of substeps.

use bevy_ecs::message::Messages;

use drystone::body::Mass;
use drystone::collider::Collider;
use drystone::contact::{ContactEnded, ContactPair, ContactStarted};
use drystone::diagnosis::BodyError;
use drystone::grab::Grab;
use drystone::settings::{SleepSettings, SolverSettings};
use drystone::solver::{Nncg, Pgs};
use drystone_lab::scenes::{Scene, SceneOptions};
use glam::Vec3;
use support::*;

/// The three solvers at settings that hold the scenes here with even steps.
fn solvers() -> [SolverSettings; 3] {
    let pgs = Pgs {
        iterations: 400,
        warm_start: 0.3,
        ..Default::default()
    };
    let nncg = Nncg {
        iterations: 300,
        warm_start: 0.3,
        ..Default::default()
    };
    [
        SolverSettings::default(),
        SolverSettings::new(pgs),
        SolverSettings::new(nncg),
    ]
}

/// Steps a scene by lengths, and asserts that nothing drifts, jumps or hurries on the way.
#[track_caller]
fn holds(settings: SolverSettings, scene: &str, lengths: impl Iterator<Item = f32>) {
    let solver = settings.solver.name().to_owned();
    let mut lab = Lab::new();
    lab.world.resource_mut::<SleepSettings>().enabled = false;
    lab.world.insert_resource(settings);
    let built = scene
        .parse::<Scene>()
        .unwrap()
        .build(&mut lab.world, &SceneOptions::default());
    let start: Vec<Vec3> = built.bodies.iter().map(|&b| lab.position(b)).collect();
    let (mut drift, mut speed) = (0f32, 0f32);
    for (i, dt) in lengths.enumerate() {
        lab.dt = dt;
        lab.step();
        for (&body, start) in built.bodies.iter().zip(&start) {
            let moved = (lab.position(body) - *start).length();
            assert!(moved < 0.2, "{solver}: falls after {i} steps");
            drift = drift.max(moved);
            speed = speed.max(lab.velocity(body).linear.length());
        }
    }
    println!("{solver}, {scene}: {} mm, {speed} m/s", 1e3 * drift);
    assert!(drift < 5e-3, "{solver}: drift {drift} m");
    assert!(speed < 0.05, "{solver}: {speed} m/s");
}

fn alternating(a: f32, b: f32) -> impl Iterator<Item = f32> {
    (0..600).map(move |i| if i % 2 == 0 { a } else { b })
}

#[test]
fn a_stack_stands_long_and_short_steps_in_turn() {
    for settings in solvers() {
        for short in [1e-3, 1e-4] {
            holds(settings.clone(), "stack:5", alternating(1.0 / 60.0, short));
        }
    }
}

#[test]
fn a_stack_stands_a_long_step_after_many_short_ones() {
    for settings in solvers() {
        let lengths = (0..612).map(|i| if i % 51 == 50 { 0.1 } else { 1e-3 });
        holds(settings, "stack:5", lengths);
    }
}

#[test]
fn a_wall_stands_a_hitch() {
    for settings in solvers() {
        let lengths = (0..400).map(|i| if i % 100 == 60 { 0.25 } else { 0.016 });
        holds(settings, "wall:8x6", lengths);
    }
}

#[test]
fn a_wall_stands_uneven_frames() {
    for settings in solvers() {
        holds(settings, "wall:8x6", alternating(0.002, 0.033));
    }
}

// 12: substeps

#[test]
fn impulses_are_the_whole_steps_whatever_the_substeps() {
    for solver in solvers() {
        let name = solver.solver.name();
        for substeps in [1, 2, 4] {
            let mut lab = Lab::new();
            lab.world.resource_mut::<SleepSettings>().enabled = false;
            lab.world.insert_resource(SolverSettings {
                outer_substeps: substeps,
                ..solver.clone()
            });
            let ground = lab.ground();
            let cube = lab.cube(Vec3::Y * 0.5);
            lab.run(1.0);
            let (normal, _) = lab.impulse(cube, ground);
            let what = format!("{name}, {substeps} substeps: weight");
            assert_near(normal, 1000.0 * G / 60.0, 0.01, &what);
            // Sliding: friction is the whole step's as well.
            lab.set_velocity(cube, Vec3::X * 5.0, Vec3::ZERO);
            lab.run(0.2);
            let (_, tangential) = lab.impulse(cube, ground);
            let what = format!("{name}, {substeps} substeps: friction");
            assert_near(-tangential.x, 0.5 * 1000.0 * G / 60.0, 0.02, &what);
        }
    }
}

#[test]
fn held_bodies_do_not_sag_at_any_step_length() {
    for dt in [1.0 / 240.0, 1.0 / 60.0, 1.0 / 30.0, 0.1] {
        let mut lab = Lab::shipped(dt);
        let cube = lab.cube(Vec3::Y * 5.0);
        lab.world
            .entity_mut(cube)
            .insert(Grab::gentle(1000.0, Vec3::ZERO, Vec3::Y * 5.0));
        lab.run(4.0);
        let low = 5.0 - lab.position(cube).y;
        assert!(low.abs() < 1e-4, "{low} m low at {dt} s");
    }
}

// 13: memory without an app

/// A world that is stepped by hand, where bodies come and go in every step, one of them bad now and then.
fn churn(lab: &mut Lab, steps: usize, mut look: impl FnMut(&mut Lab)) {
    for i in 0..steps {
        let ball = lab.body(Collider::ball(0.5), Vec3::new(0.0, 0.5, 0.0));
        if i % 7 == 0 {
            lab.world.entity_mut(ball).insert(Mass(f32::NAN));
        }
        drystone::step(&mut lab.world, lab.dt).unwrap();
        lab.world.despawn(ball);
        look(lab);
    }
}

#[test]
fn a_world_stepped_by_hand_keeps_no_messages() {
    let mut lab = Lab::new();
    lab.ground();
    let mut most = [0; 4];
    churn(&mut lab, 3000, |lab| {
        let counts = [
            lab.world.resource::<Messages<ContactStarted>>().len(),
            lab.world.resource::<Messages<ContactEnded>>().len(),
            lab.world.resource::<Messages<BodyError>>().len(),
            lab.world
                .removed_components()
                .iter()
                .map(|(_, removed)| removed.len())
                .sum(),
        ];
        for (most, count) in most.iter_mut().zip(counts) {
            *most = count.max(*most);
        }
    });
    println!("at most {most:?} messages");
    assert!(most.iter().all(|&count| count < 100), "{most:?}");
    lab.step();
    let mut pairs = lab.world.query::<&ContactPair>();
    assert_eq!(pairs.iter(&lab.world).count(), 0);
}

/// Resident memory of this process, in kB; of Linux alone.
fn resident() -> usize {
    let status = std::fs::read_to_string("/proc/self/status").expect("Linux tells");
    let line = status.lines().find(|line| line.starts_with("VmRSS:"));
    let number = line.and_then(|line| line.split_whitespace().nth(1));
    number
        .and_then(|kb| kb.parse().ok())
        .expect("a number of kB")
}

#[test]
#[ignore = "long"]
fn memory_is_flat_over_a_million_steps_with_churn() {
    let mut lab = Lab::new();
    lab.ground();
    churn(&mut lab, 100_000, |_| ());
    let before = resident();
    churn(&mut lab, 1_000_000, |_| ());
    let after = resident();
    println!("{before} kB before, {after} kB after");
    assert!(
        after < before + 1000,
        "{before} kB before, {after} kB after"
    );
}
