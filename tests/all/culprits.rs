//! One bad brick in a wall: it alone is taken out, under its name; its neighbours lose a neighbour and nothing else, and who stands
//! apart loses not a bit.

use bevy_ecs::message::Messages;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::body::{
    Damping, ExternalForce, ExternalImpulse, GravityScale, Pose, Quarantined, RigidBody, Velocity,
};
use drystone::collider::{Collider, Restitution};
use drystone::diagnosis::{BodyProblem, StepError};
use drystone::grab::Grab;
use drystone::settings::{
    ContactSolver, Gravity, SleepSettings, SolverSettings, SpeedLimits, StabilizationSettings,
};
use drystone::solver::{Nncg, PatchProblem, PatchSolver, Pgs, SoftStep, SolveReport};
use glam::{Quat, Vec3};
use std::sync::Arc;
use support::*;

/// A wall of 24 bricks, and a stack that stands apart from it.
struct Site {
    lab: Lab,
    bricks: Vec<Entity>,
    apart: Vec<Entity>,
}

impl Site {
    fn new() -> Self {
        let mut lab = Lab::new();
        lab.world.resource_mut::<SleepSettings>().enabled = false;
        lab.ground();
        let bricks = (0..24)
            .map(|i| {
                let (x, y) = ((i % 6) as f32, (i / 6) as f32);
                let at = Vec3::new(x + 0.25 * (y % 2.0), 0.25 + 0.5 * y, 0.0);
                lab.body(Collider::cuboid(0.99, 0.5, 0.5), at)
            })
            .collect();
        let apart = (0..4)
            .map(|i| lab.cube(Vec3::new(20.0 + 0.1 * i as f32, 0.5 + i as f32, 0.0)))
            .collect();
        lab.run(0.5);
        assert_eq!(lab.errors(), []);
        Self { lab, bricks, apart }
    }

    fn poses(&self, of: &[Entity]) -> Vec<Pose> {
        of.iter().map(|&body| self.lab.pose(body)).collect()
    }
}

/// Brick 20 is the second from the left in the top course: nothing stands on it.
const BAD: usize = 20;

/// Spoils a brick of the top course; it alone goes, with one message.
#[track_caller]
fn spoil(what: &str, problem: BodyProblem, spoil: impl Fn(&mut Lab, Entity)) {
    let mut quiet = Site::new();
    let mut site = Site::new();
    let bad = site.bricks[BAD];
    let start = site.poses(&site.bricks);
    spoil(&mut site.lab, bad);
    site.lab.run(1.0);
    quiet.lab.run(1.0);
    let errors = site.lab.errors();
    assert_eq!(errors.len(), 1, "{what}: {errors:?}");
    assert_eq!(
        (errors[0].entity, &errors[0].problem),
        (bad, &problem),
        "{what}"
    );
    let mut quarantined = site.lab.world.query_filtered::<Entity, With<Quarantined>>();
    let quarantined: Vec<_> = quarantined.iter(&site.lab.world).collect();
    assert_eq!(quarantined, [bad], "{what}");
    for (i, start) in start.iter().enumerate().filter(|(i, _)| *i != BAD) {
        let moved = (site.lab.position(site.bricks[i]) - start.position).length();
        assert!(moved < 1e-3, "{what}: brick {i} moved by {moved} m");
    }
    assert_eq!(
        site.poses(&site.apart),
        quiet.poses(&quiet.apart),
        "{what}: apart"
    );
}

fn insert<B: Bundle + Clone>(bundle: B) -> impl Fn(&mut Lab, Entity) {
    move |lab, body| _ = lab.world.entity_mut(body).insert(bundle.clone())
}

#[test]
fn damping_that_is_none() {
    for bad in [f32::NAN, -60.0, f32::INFINITY, 1e30] {
        let linear = Damping {
            linear: bad,
            angular: 0.0,
        };
        let angular = Damping {
            linear: 0.0,
            angular: bad,
        };
        for damping in [linear, angular] {
            spoil(
                &format!("{damping:?}"),
                BodyProblem::InvalidDamping,
                insert(damping),
            );
        }
    }
}

#[test]
fn gravity_scales_that_are_none() {
    for bad in [f32::NAN, f32::INFINITY, -f32::INFINITY, 1e30, -1e30] {
        let what = format!("gravity scale {bad}");
        spoil(
            &what,
            BodyProblem::InvalidGravityScale,
            insert(GravityScale(bad)),
        );
    }
}

#[test]
fn hands_that_pull_nowhere() {
    let hand = |change: fn(&mut Grab)| {
        move |lab: &mut Lab, body: Entity| {
            let mut grab = Grab::gentle(250.0, Vec3::ZERO, lab.position(body));
            change(&mut grab);
            lab.world.entity_mut(body).insert(grab);
        }
    };
    let changes: [fn(&mut Grab); 9] = [
        |grab| grab.local_point.x = f32::NAN,
        |grab| grab.target.y = f32::INFINITY,
        |grab| grab.response = f32::NAN,
        |grab| grab.response = f32::INFINITY,
        |grab| grab.response = -1.0,
        |grab| grab.max_speed = f32::NAN,
        |grab| grab.max_force = f32::NAN,
        |grab| grab.max_torque = -1.0,
        |grab| grab.rotation = Some(Quat::from_xyzw(0.0, 0.0, 0.0, 0.0)),
    ];
    for (i, change) in changes.into_iter().enumerate() {
        spoil(&format!("hand {i}"), BodyProblem::InvalidGrab, hand(change));
    }
}

#[test]
fn forces_beyond_all_bounds() {
    for strong in [1e38, 1e19] {
        let force = ExternalForce {
            force: Vec3::X * strong,
            torque: Vec3::ZERO,
            ..Default::default()
        };
        let torque = ExternalForce {
            force: Vec3::ZERO,
            torque: Vec3::Z * strong,
            ..Default::default()
        };
        let impulse = ExternalImpulse {
            linear: Vec3::X * strong,
            angular: Vec3::ZERO,
        };
        let problem = BodyProblem::NonFiniteForce;
        spoil(&format!("force {strong}"), problem.clone(), insert(force));
        spoil(&format!("torque {strong}"), problem.clone(), insert(torque));
        spoil(&format!("impulse {strong}"), problem, insert(impulse));
    }
}

#[test]
fn velocities_beyond_all_bounds() {
    for fast in [1e10, 1e20, 3e38] {
        let linear = Velocity::linear(Vec3::X * fast);
        let angular = Velocity {
            linear: Vec3::ZERO,
            angular: Vec3::Y * fast,
        };
        for velocity in [linear, angular] {
            let what = format!("velocity {fast}");
            spoil(&what, BodyProblem::NonFiniteVelocity, insert(velocity));
            let kinematic = (RigidBody::Kinematic, velocity);
            spoil(&what, BodyProblem::NonFiniteVelocity, insert(kinematic));
        }
    }
}

#[test]
fn sizes_and_surfaces_beyond_all_bounds() {
    let surface = BodyProblem::InvalidMaterial;
    spoil("restitution", surface, insert(Restitution::new(100.0)));
    for (what, shape) in [
        ("radius", Collider::ball(3e38)),
        ("border −1", Collider::round_cuboid(1.0, 1.0, 1.0, -1.0)),
        (
            "border NaN",
            Collider::round_cuboid(1.0, 1.0, 1.0, f32::NAN),
        ),
        ("border 1e20", Collider::round_cuboid(1.0, 1.0, 1.0, 1e20)),
        ("capsule", Collider::capsule(0.5, f32::INFINITY)),
    ] {
        spoil(what, BodyProblem::DegenerateShape, insert(shape));
    }
    let far = Transform::from_xyz(1e30, 0.0, 0.0);
    spoil("far away", BodyProblem::NonFinitePose, insert(far));
}

/// It is fast, but not too fast: it is slowed down to the limit.
#[test]
fn speed_is_capped() {
    let mut lab = Lab::new();
    lab.world.insert_resource(SpeedLimits {
        linear: 20.0,
        angular: 5.0,
    });
    let cube = lab.cube(Vec3::Y * 50.0);
    let kick = ExternalImpulse {
        linear: Vec3::X * 1e6,
        angular: Vec3::Y * 1e6,
    };
    lab.world.entity_mut(cube).insert(kick);
    lab.step();
    let velocity = lab.velocity(cube);
    assert!((velocity.linear.length() - 20.0).abs() < 1e-3);
    assert!((velocity.angular.length() - 5.0).abs() < 1e-3);
    assert_eq!(lab.errors(), []);
}

/// Wrong in one island only.
struct Wrong;

impl PatchSolver for Wrong {
    fn name(&self) -> &str {
        "wrong"
    }

    fn solve(&self, problem: &mut PatchProblem) -> SolveReport {
        let report = SoftStep::default().solve(problem);
        if problem.bodies.len() > 10 {
            problem.bodies[3].linear.x = f32::NAN;
            problem.points[0].normal_impulse = f32::NAN;
        }
        report
    }
}

#[test]
fn an_island_whose_solve_goes_wrong_keeps_its_poses_and_recovers() {
    let mut quiet = Site::new();
    let mut site = Site::new();
    let before = site.poses(&site.bricks);
    let sound = site.lab.world.resource::<SolverSettings>().clone();
    let wrong = SolverSettings {
        solver: ContactSolver::Patches(Arc::new(Wrong)),
        ..sound.clone()
    };
    site.lab.world.insert_resource(wrong);
    site.lab.run(0.2);
    quiet.lab.run(0.2);
    let errors = site.lab.errors();
    assert_eq!(errors.len(), 1, "said once");
    assert_eq!(errors[0].problem, BodyProblem::Diverged);
    assert_eq!(before, site.poses(&site.bricks));
    assert_eq!(site.poses(&site.apart), quiet.poses(&quiet.apart));
    let mut quarantined = site.lab.world.query::<&Quarantined>();
    assert_eq!(quarantined.iter(&site.lab.world).count(), 0);
    site.lab.world.insert_resource(sound);
    site.lab.run(1.0);
    for (now, before) in site.poses(&site.bricks).iter().zip(&before) {
        assert!((now.position - before.position).length() < 2e-3);
    }
}

/// Invalid settings are reported once, and the last valid ones stay in force.
#[track_caller]
fn refuse(resource: &str, spoil: impl Fn(&mut World)) {
    let mut quiet = Site::new();
    let mut site = Site::new();
    spoil(&mut site.lab.world);
    site.lab.run(0.5);
    quiet.lab.run(0.5);
    let mut errors = site.lab.world.resource_mut::<Messages<StepError>>();
    let errors: Vec<StepError> = errors.drain().collect();
    assert_eq!(errors.len(), 1, "{resource}: {errors:?}");
    assert!(errors[0].to_string().contains(resource), "{}", errors[0]);
    assert_eq!(site.lab.errors(), []);
    assert_eq!(
        site.poses(&site.bricks),
        quiet.poses(&quiet.bricks),
        "{resource}"
    );
}

#[test]
fn settings_that_cannot_be() {
    for bad in [f32::NAN, f32::INFINITY, 1e30] {
        refuse("Gravity", |world| {
            world.insert_resource(Gravity(Vec3::X * bad))
        });
    }
    refuse("Gravity", |world| _ = world.remove_resource::<Gravity>());
    for bad in [f32::NAN, 0.0, -1.0] {
        refuse("SpeedLimits", |world| {
            world.resource_mut::<SpeedLimits>().linear = bad;
        });
        refuse("SpeedLimits", |world| {
            world.resource_mut::<SpeedLimits>().angular = bad;
        });
    }
    refuse("SolverSettings", |world| {
        world.resource_mut::<SolverSettings>().solver = Pgs {
            iterations: 0,
            ..Default::default()
        }
        .into();
    });
    refuse("SolverSettings", |world| {
        world.resource_mut::<SolverSettings>().solver = SoftStep {
            max_sweeps: 0,
            ..Default::default()
        }
        .into();
    });
    refuse("SolverSettings", |world| {
        world.resource_mut::<SolverSettings>().outer_substeps = 0;
    });
    refuse("SolverSettings", |world| {
        world.resource_mut::<SolverSettings>().solver = Nncg {
            warm_start: f32::NAN,
            ..Default::default()
        }
        .into();
    });
    for bad in [f32::NAN, -1.0, f32::INFINITY] {
        refuse("SolverSettings", |world| {
            world.resource_mut::<SolverSettings>().solver = SoftStep {
                damping_ratio: bad,
                ..Default::default()
            }
            .into();
        });
    }
    refuse("StabilizationSettings", |world| {
        world
            .resource_mut::<StabilizationSettings>()
            .max_correction_speed = f32::NAN;
    });
    refuse("StabilizationSettings", |world| {
        world.resource_mut::<StabilizationSettings>().envelope = -0.1;
    });
    refuse("SleepSettings", |world| {
        world.resource_mut::<SleepSettings>().delay = f32::NAN;
    });
}

// 6: not as heavy as it seems

/// A body of ten thousand times the mass squeezes out the body below; this is reported when they touch.
#[test]
fn a_great_mass_ratio_is_said() {
    let mut lab = Lab::new();
    lab.ground();
    lab.cube(Vec3::Y * 0.5);
    let heavy = lab.cube(Vec3::Y * 1.5);
    lab.world.entity_mut(heavy).insert((
        drystone::body::Density(1e7),
        Transform::from_xyz(0.0, 1.5, 0.0).with_rotation(Quat::IDENTITY),
    ));
    lab.step();
    let errors = lab.errors();
    assert_eq!(errors.len(), 1);
    assert!(matches!(
        errors[0].problem,
        BodyProblem::ExtremeMassRatio { .. }
    ));
}
