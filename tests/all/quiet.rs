//! An island in which nothing moves gets one round of sweeps in a step, and any other island gets all of them.

use bevy_ecs::prelude::*;
use drystone::body::{ExternalImpulse, Pose};
use drystone::settings::{PhysicsThreads, Preset};
use drystone::solve::SolveReports;
use drystone_lab::experiment::{Experiment, Outcome};
use glam::Vec3;
use support::Lab;

/// The number of sweeps of each island in the next step.
fn sweeps(lab: &mut Lab) -> Vec<usize> {
    lab.step();
    let reports = &lab.world.resource::<SolveReports>().0;
    reports.iter().map(|island| island.report.sweeps).collect()
}

/// A tower of cubes on the ground.
fn tower(lab: &mut Lab, cubes: usize, x: f32) -> Vec<Entity> {
    let cube = |i: usize| lab.cube(Vec3::new(x, 0.5 + i as f32, 0.0));
    (0..cubes).map(cube).collect()
}

fn push(lab: &mut Lab, body: Entity, impulse: Vec3) {
    let impulse = ExternalImpulse {
        linear: impulse,
        ..Default::default()
    };
    lab.world.entity_mut(body).insert(impulse);
}

#[test]
fn an_island_at_rest_gets_one_round_of_sweeps() {
    for dt in [1.0 / 60.0, 0.1] {
        let mut lab = Lab::shipped(dt);
        lab.ground();
        let towers = [0.0, 9.0].map(|x| tower(&mut lab, 5, x));
        lab.run(2.0);
        let at_rest = sweeps(&mut lab);
        assert_eq!(at_rest, [4, 4], "{dt} s");
        let poses = |lab: &Lab| -> Vec<Pose> {
            let bodies = towers.iter().flatten();
            bodies.map(|&body| lab.pose(body)).collect()
        };
        let before = poses(&lab);
        lab.run(10.0);
        assert_eq!(poses(&lab), before, "{dt} s");
        // A tenth of what a cube weighs, for one step.
        push(&mut lab, towers[1][2], Vec3::X * 981.0 * dt);
        let pushed = sweeps(&mut lab);
        assert!(pushed[0] == 4 && pushed[1] >= 16, "{dt} s: {pushed:?}");
    }
}

/// Runs a scene without sleeping for twenty seconds. Returns the number of steps of the last ten in which a body moved, and the outcome.
fn stand(scene: &str) -> (usize, Outcome) {
    let mut experiment = Experiment::new(scene.parse().expect("a scene"), Preset::Default);
    experiment.sleeping.enabled = false;
    experiment.threads = PhysicsThreads::new(1).expect("one thread can be had");
    let mut run = experiment.start();
    let mut steps = 0;
    let mut poses = Vec::new();
    for step in 0..1200 {
        run.step();
        let bodies = run.bodies.iter();
        let now: Vec<Pose> = bodies
            .map(|&body| *run.world.get(body).expect("a body"))
            .collect();
        steps += usize::from(step >= 600 && now != poses);
        poses = now;
    }
    (steps, run.outcome())
}

/// Their poses are rounded by more than their springs stretch, which would make them tremble by some µm/s for ever.
#[test]
fn an_arch_and_a_house_of_cards_get_one_round_of_sweeps_and_stand_still() {
    for scene in ["arch:15", "cardhouse:5", "dome:4"] {
        let (steps, outcome) = stand(scene);
        let drift = outcome.displacement.drift;
        println!("{scene}: moved in {steps} of 600 steps, drift {drift:e} m");
        assert_eq!(outcome.sweeps_median, 4, "{scene}");
        assert!(steps < 60, "{scene} moved in {steps} of 600 steps");
        assert!(drift < 1e-5, "{scene}: {drift} m");
    }
}

fn has_small_velocities(scene: &str) {
    let speed = stand(scene).1.rms_speed;
    println!("{scene}: {speed:e} m/s");
    assert!(speed < 9e-6, "{scene}: {speed} m/s");
}

#[test]
fn a_house_of_cards_has_small_velocities() {
    has_small_velocities("cardhouse:5");
}

#[test]
#[ignore = "missed since bodies of quiet islands do not move: 11 µm/s, though nothing moves with them"]
fn an_arch_has_small_velocities() {
    has_small_velocities("arch:15");
}

/// Cubes that lie alone are solved together. Those at rest get one round of sweeps even if others in their problem move, and the same bits.
#[test]
fn cubes_at_rest_do_not_notice_others_that_move() {
    let run = |moves: bool| {
        let mut lab = Lab::shipped(1.0 / 60.0);
        lab.ground();
        let cubes: Vec<Entity> = (0..20)
            .flat_map(|i| tower(&mut lab, 1, 3.0 * i as f32))
            .collect();
        lab.run(1.0);
        let mut counts = Vec::new();
        for step in 0..60 {
            if moves && step % 7 == 0 {
                push(&mut lab, cubes[step % 5], Vec3::new(20.0, 0.0, 10.0));
            }
            counts = sweeps(&mut lab);
        }
        let others: Vec<Pose> = cubes[5..].iter().map(|&cube| lab.pose(cube)).collect();
        (counts[5..].to_vec(), others)
    };
    let (at_rest, beside) = (run(false), run(true));
    assert!(at_rest.0.iter().all(|&count| count == 4), "{at_rest:?}");
    assert_eq!(at_rest, beside);
}
