//! The solvers from the literature against closed forms: on problems of the traits, and in worlds.

use super::{Apgd, Avbd};
use crate::experiment::{Experiment, Run};
use crate::metrics;
use crate::scenes::Scene;
use crate::tilt::Tilted;
use drystone::contact::{ContactImpulses, ContactPair, Manifold};
use drystone::settings::{AnchorRule, ContactSolver, PhysicsThreads, Preset};

/// Friction of every scene.
const FRICTION: f32 = 0.5;
/// kg·m/s²: the weight of a cube of 1 m.
const WEIGHT: f32 = 1000.0 * 9.81;

/// AVBD with the default's contacts, and APGD with the paper's stabilization and pair-pose anchors, both at 60 Hz and awake.
fn both(scene: &str) -> [Experiment; 2] {
    let scene: Scene = scene.parse().unwrap();
    let avbd: ContactSolver = Avbd::default().into();
    let apgd: ContactSolver = Apgd::default().into();
    [(Preset::Default, avbd), (Preset::Paper, apgd)].map(|(preset, solver)| {
        let mut experiment = Experiment::new(scene, Preset::Default);
        experiment.stabilization = preset.stabilization();
        experiment.stabilization.friction.anchors = AnchorRule::PairPose;
        experiment.solver.solver = solver;
        experiment.sleeping.enabled = false;
        experiment.threads = PhysicsThreads::new(1).unwrap();
        experiment
    })
}

/// The normal and the friction impulse of every patch, N·s, with the friction's limit.
fn impulses(run: &mut Run) -> Vec<(f32, f32)> {
    let mut pairs = run
        .world
        .query::<(&ContactPair, &Manifold, &ContactImpulses)>();
    let mut found = Vec::new();
    for (_, manifold, impulses) in pairs.iter(&run.world) {
        for (number, patch) in manifold.patches.iter().enumerate() {
            let range = manifold.range(patch);
            let normal: f32 = range.clone().map(|i| impulses.points[i].normal).sum();
            let tangential = range.map(|i| impulses.tangential_at(patch, number, i));
            found.push((normal, tangential.sum::<glam::Vec3>().length()));
        }
    }
    found
}

#[test]
fn a_box_at_rest_stays_where_it_is_and_is_carried() {
    for experiment in both("stack:1") {
        let name = experiment.solver.solver.name().to_owned();
        let mut run = experiment.start();
        for _ in 0..120 {
            run.step();
        }
        let outcome = run.outcome();
        let carried: f32 = impulses(&mut run).iter().map(|found| found.0).sum();
        let weight = WEIGHT * experiment.dt;
        println!(
            "{name}: {:?}, {carried} of {weight} N s",
            outcome.displacement
        );
        assert!(outcome.displacement.drift < 1e-5, "{name}");
        assert!(outcome.displacement.sag < 1e-4, "{name}");
        assert!(
            (carried / weight - 1.0).abs() < 1e-3,
            "{name}: {carried} {weight}"
        );
    }
}

#[test]
fn every_interface_of_a_stack_carries_the_weight_above_it() {
    for mut experiment in both("stack:5") {
        let name = experiment.solver.solver.name().to_owned();
        if name == "apgd" {
            let more = Apgd {
                iterations: 300,
                ..Default::default()
            };
            experiment.solver.solver = more.into();
        }
        let mut run = experiment.start();
        for _ in 0..300 {
            run.step();
        }
        let mut carried: Vec<f32> = impulses(&mut run).iter().map(|found| found.0).collect();
        carried.sort_by(f32::total_cmp);
        assert_eq!(carried.len(), 5, "{name}");
        for (above, carried) in (1..).zip(carried) {
            let weight = above as f32 * WEIGHT * experiment.dt;
            println!("{name}: {carried} of {weight} N s");
            assert!(
                (carried / weight - 1.0).abs() < 5e-3,
                "{name}: {carried} {weight}"
            );
        }
        let outcome = run.outcome();
        assert!(outcome.displacement.drift < 1e-3, "{name}: {outcome:?}");
        assert!(outcome.displacement.sag < 2e-3, "{name}: {outcome:?}");
        assert!(outcome.rms_speed < 2e-3, "{name}: {outcome:?}");
    }
}

#[test]
fn a_box_slides_where_the_tangent_of_the_slope_exceeds_the_friction() {
    for experiment in both("stack:1") {
        let name = experiment.solver.solver.name();
        let limit = Tilted::SLIDING.limit();
        assert!((limit - FRICTION.atan().to_degrees()).abs() < 1e-4);
        assert!(Tilted::SLIDING.stands(&experiment, limit - 0.5), "{name}");
        assert!(!Tilted::SLIDING.stands(&experiment, limit + 0.5), "{name}");
    }
}

/// Way of a slab down a slope of 30° in two seconds, ½ g (sin θ − μ cos θ) t². The first step accelerates it whole, so its end is half a
/// step ahead.
#[test]
fn a_slab_slides_down_with_g_sin_minus_mu_g_cos() {
    for experiment in both("incline:30") {
        let name = experiment.solver.solver.name().to_owned();
        let mut run = experiment.start();
        let start = run.poses()[0].position;
        for _ in 0..120 {
            run.step();
        }
        let way = run.poses()[0].position.distance(start);
        let (sin, cos) = 30f32.to_radians().sin_cos();
        let expected = 0.5 * 9.81 * (sin - FRICTION * cos) * 2.0 * (2.0 + experiment.dt);
        println!("{name}: {way} of {expected} m");
        assert!(
            (way / expected - 1.0).abs() < 0.02,
            "{name}: {way} {expected}"
        );
    }
}

/// While a wall with noise settles, and while a slab slides.
#[test]
fn friction_stays_inside_its_cone_and_normals_push() {
    for scene in ["wall:4x4", "sliding", "heap:12"] {
        for mut experiment in both(scene) {
            let name = experiment.solver.solver.name().to_owned();
            experiment.options.noise_position = 0.002;
            experiment.options.noise_angle = 0.01;
            let mut run = experiment.start();
            let mut at_limit = 0;
            for _ in 0..60 {
                run.step();
                for (normal, friction) in impulses(&mut run) {
                    let limit = FRICTION * normal;
                    assert!(normal >= 0.0, "{name}, {scene}: {normal}");
                    assert!(
                        friction <= limit * (1.0 + 1e-4) + 1e-3,
                        "{name}, {scene}: {friction} of {limit} N s"
                    );
                    at_limit += usize::from(normal > 0.0 && friction > 0.99 * limit);
                }
            }
            assert!(
                scene != "sliding" || at_limit > 20,
                "{name}: the slab was braked with all friction in {at_limit} steps"
            );
        }
    }
}

#[test]
fn runs_are_equal_to_the_bit_on_any_number_of_threads() {
    for experiment in both("heap:40") {
        let name = experiment.solver.solver.name().to_owned();
        let bits = |threads: usize| {
            let mut experiment = experiment.clone();
            experiment.threads = PhysicsThreads::new(threads).unwrap();
            let mut run = experiment.start();
            for _ in 0..90 {
                run.step();
            }
            let numbers = run.poses().into_iter().flat_map(|pose| {
                let turn = pose.rotation.to_array();
                pose.position.to_array().into_iter().chain(turn)
            });
            numbers.map(f32::to_bits).collect::<Vec<u32>>()
        };
        let first = bits(1);
        assert!(bits(1) == first, "{name}: another run, other bits");
        assert!(
            bits(2) == first,
            "{name}: another number of threads, other bits"
        );
    }
}

#[test]
fn a_wall_stands() {
    for mut experiment in both("wall:8x6") {
        experiment.options.noise_position = 0.002;
        experiment.options.noise_angle = 0.01;
        experiment.options.lateral_gap = 0.036;
        let outcome = experiment.run_seconds(5.0);
        println!("{}: {outcome:?}", experiment.solver.solver.name());
        assert!(outcome.stands, "{}", experiment.solver.solver.name());
    }
}

/// The cone complementarity problem parts what slips, at μ times the speed of the slip: a slab that slides at v rises by at least Δt μ v.
/// Half of it may be missing, as the slab is braked.
#[test]
fn a_sliding_slab_rises_under_apgd_and_not_under_avbd() {
    for experiment in both("sliding") {
        let name = experiment.solver.solver.name().to_owned();
        let mut run = experiment.start();
        let start = run.poses()[0].position;
        let mut rise = 0f32;
        for _ in 0..60 {
            run.step();
            rise = rise.max(run.poses()[0].position.y - start.y);
        }
        let at_first = experiment.dt * FRICTION * 3.0;
        println!("{name}: {rise} m, Δt μ v is {at_first}");
        match &*name {
            "apgd" => assert!((0.5 * at_first..5.0 * at_first).contains(&rise), "{rise}"),
            _ => assert!(rise < 1e-4, "{rise}"),
        }
    }
}

/// With joints, which are relaxed in between, a hanging chain holds its ball.
#[test]
fn apgd_has_joints() {
    let [_, mut experiment] = both("chain:4");
    experiment.stabilization = Preset::Default.stabilization();
    let mut run = experiment.start();
    let start = run.poses();
    for _ in 0..60 {
        run.step();
    }
    let fallen = metrics::Displacement::between(&start, &run.poses());
    println!("{fallen:?}");
    assert!(fallen.sag < 0.15, "{fallen:?}");
}

#[test]
fn invalid_settings_are_described() {
    let solver = |avbd: Avbd| ContactSolver::from(avbd).problem();
    assert_eq!(solver(Avbd::default()), None);
    let wrong = Avbd {
        alpha: 1.5,
        ..Default::default()
    };
    assert!(solver(wrong).unwrap().starts_with("alpha is 1.5"));
    let wrong = Apgd {
        tolerance: f32::NAN,
        ..Default::default()
    };
    let problem = ContactSolver::from(wrong).problem();
    assert!(problem.unwrap().starts_with("tolerance is NaN"));
}
