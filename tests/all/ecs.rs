//! Drystone in an app: schedules, sets, plugins, events, reports.

use bevy_app::{App, PluginGroup, Update};
use bevy_ecs::message::Messages;
use bevy_ecs::prelude::*;
use bevy_ecs::schedule::{LogLevel, ScheduleBuildSettings};
use bevy_time::{Fixed, Time, TimePlugin, TimeUpdateStrategy};
use bevy_transform::components::Transform;
use drystone::body::{RigidBody, Velocity};
use drystone::collapse::CollapsePlugin;
use drystone::collider::Collider;
use drystone::contact::{
    ContactAnchors, ContactEnded, ContactEvents, ContactStarted, ContactTargets, Manifold,
};
use drystone::grab::HandPlugin;
use drystone::profile::Profile;
use drystone::schedule::{PhysicsSchedule, PhysicsSystems};
use drystone::settings::{ContactSolver, SleepSettings, SolverSettings, StabilizationSettings};
use drystone::solve::SolveReports;
use drystone::solver::{Pgs, PointProblem, PointSolver, SolveReport};
use drystone::{DrystonePlugins, FrictionStabilizationPlugin};
use glam::Vec3;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;
use support::*;

/// An app whose clock goes on by 1/64 s in every frame.
fn app(plugins: impl PluginGroup) -> App {
    let mut app = App::new();
    let frame = Duration::from_secs_f64(1.0 / 64.0);
    app.add_plugins(TimePlugin)
        .add_plugins(plugins)
        .insert_resource(Time::<Fixed>::from_hz(64.0))
        .insert_resource(TimeUpdateStrategy::ManualDuration(frame));
    app
}

fn cube(app: &mut App, position: Vec3) -> Entity {
    let transform = Transform::from_translation(position);
    let cube = Collider::cuboid(1.0, 1.0, 1.0);
    app.world_mut()
        .spawn((RigidBody::Dynamic, cube, transform))
        .id()
}

fn ground(app: &mut App) -> Entity {
    let plane = Collider::half_space(Vec3::Y);
    app.world_mut().spawn((RigidBody::Static, plane)).id()
}

fn height(app: &App, body: Entity) -> f32 {
    app.world().get::<Transform>(body).unwrap().translation.y
}

fn frames(app: &mut App, n: usize) {
    for _ in 0..n {
        app.update();
    }
}

#[test]
fn the_plugins_step_in_fixed_post_update_or_wherever_they_are_asked_to() {
    for plugins in [DrystonePlugins::default(), DrystonePlugins::new(Update)] {
        let mut app = app(plugins);
        let falling = cube(&mut app, Vec3::Y * 10.0);
        frames(&mut app, 65);
        // A second of free fall, give or take a frame.
        let fell = 10.0 - height(&app, falling);
        assert!((fell - 0.5 * G).abs() < 0.25, "{fell}");
    }
}

#[test]
fn fixed_steps_keep_their_length_whatever_the_frame() {
    let mut fell = Vec::new();
    for frame in [1.0 / 128.0, 1.0 / 64.0, 1.0 / 16.0] {
        let mut app = app(DrystonePlugins::default());
        let strategy = TimeUpdateStrategy::ManualDuration(Duration::from_secs_f64(frame));
        app.insert_resource(strategy);
        let falling = cube(&mut app, Vec3::ZERO);
        // The clock starts with the first frame.
        frames(&mut app, 1 + (1.0 / frame) as usize);
        fell.push(height(&app, falling));
    }
    assert!(fell.iter().all(|y| *y == fell[0]), "{fell:?}");
}

#[test]
fn a_users_system_runs_between_the_sets_it_names() {
    let mut app = app(DrystonePlugins::default());
    app.add_systems(
        PhysicsSchedule,
        hold.after(PhysicsSystems::Forces)
            .before(PhysicsSystems::Solve),
    );
    let falling = cube(&mut app, Vec3::Y * 10.0);
    let held = cube(&mut app, Vec3::new(5.0, 10.0, 0.0));
    app.world_mut().entity_mut(held).insert(Held);
    frames(&mut app, 30);
    assert!(height(&app, falling) < 9.5);
    assert_eq!(height(&app, held), 10.0, "gravity has been taken off again");
}

/// Two systems that could run either way round are the user's own business: only drystone's tests make an error of it.
#[test]
fn a_users_system_need_not_say_before_what_it_runs() {
    let mut app = app(DrystonePlugins::default());
    app.add_systems(PhysicsSchedule, hold.after(PhysicsSystems::Solve));
    let falling = cube(&mut app, Vec3::Y * 10.0);
    frames(&mut app, 30);
    assert!(height(&app, falling) < 9.5);
}

#[derive(Component)]
struct Held;

fn hold(mut bodies: Query<&mut Velocity, With<Held>>) {
    for mut velocity in &mut bodies {
        assert!(velocity.linear.y < 0.0, "forces have acted");
        *velocity = Velocity::default();
    }
}

#[derive(Resource, Default)]
struct Deepest(f32);

#[test]
fn a_users_system_reads_fresh_manifolds() {
    let mut app = app(DrystonePlugins::default());
    let look = |manifolds: Query<&Manifold>, mut deepest: ResMut<Deepest>| {
        for point in manifolds.iter().flat_map(|m| &m.points) {
            deepest.0 = deepest.0.min(point.distance);
        }
    };
    let place = PhysicsSystems::Narrowphase;
    app.init_resource::<Deepest>().add_systems(
        PhysicsSchedule,
        look.after(place).before(PhysicsSystems::FrictionError),
    );
    ground(&mut app);
    cube(&mut app, Vec3::Y * 0.4);
    frames(&mut app, 2);
    let deepest = app.world().resource::<Deepest>().0;
    assert!((deepest + 0.1).abs() < 1e-3, "{deepest}");
}

#[test]
fn a_plugin_may_be_taken_out() {
    for taken_out in [false, true] {
        let mut plugins = DrystonePlugins::default().build();
        if taken_out {
            plugins = plugins.disable::<FrictionStabilizationPlugin>();
        }
        let mut app = app(plugins);
        ground(&mut app);
        let cubes = [0.5, 1.5].map(|y| cube(&mut app, Vec3::Y * y));
        frames(&mut app, 64);
        assert!((height(&app, cubes[1]) - 1.5).abs() < 0.01);
        let mut anchors = app.world_mut().query::<&ContactAnchors>();
        let set = |anchors: &ContactAnchors| anchors.patches.iter().any(|a| a.set);
        assert_eq!(anchors.iter(app.world()).any(set), !taken_out);
    }
}

struct Counting(Arc<AtomicUsize>);

impl PointSolver for Counting {
    fn name(&self) -> &str {
        "counting"
    }

    fn warm_start(&self) -> f32 {
        0.3
    }

    fn solve(&self, problem: &mut PointProblem) -> SolveReport {
        self.0
            .fetch_add(problem.constraints.len(), Ordering::Relaxed);
        let pgs = Pgs {
            iterations: 192,
            ..Default::default()
        };
        pgs.solve(problem)
    }
}

#[test]
fn a_users_own_solver_solves() {
    let mut app = app(DrystonePlugins::default());
    let count = Arc::new(AtomicUsize::new(0));
    let mut settings = app.world_mut().resource_mut::<SolverSettings>();
    settings.solver = ContactSolver::Points(Arc::new(Counting(count.clone())));
    settings.outer_substeps = 1;
    ground(&mut app);
    let resting = cube(&mut app, Vec3::Y * 0.5);
    frames(&mut app, 11);
    assert_eq!(
        count.load(Ordering::Relaxed),
        10 * 4,
        "four points in each of ten steps"
    );
    assert!((height(&app, resting) - 0.5).abs() < 0.01);
}

/// Longer than a stage takes in a world of one body.
const NAP: Duration = Duration::from_millis(60);

fn nap() {
    std::thread::sleep(NAP);
}

/// The least time of a stage in three steps.
fn least_time(app: &mut App, stage: &str) -> Duration {
    let times = (0..3).map(|_| {
        frames(app, 1);
        let profile = app.world().resource::<Profile>();
        profile.system(stage).expect("it has a clock")
    });
    times.min().expect("there are three")
}

#[test]
fn the_time_of_a_users_system_is_not_that_of_the_next_stage() {
    let mut app = app(DrystonePlugins::default());
    cube(&mut app, Vec3::ZERO);
    frames(&mut app, 5);
    app.add_systems(
        PhysicsSchedule,
        nap.after(PhysicsSystems::Narrowphase)
            .before(PhysicsSystems::Islands),
    );
    frames(&mut app, 2);
    assert!(least_time(&mut app, "islands") < NAP);
    let step = app.world().resource::<Profile>().step;
    assert!(step >= NAP, "the whole step took {step:?}");
}

#[test]
fn a_run_condition_counts_for_its_stage() {
    let mut app = app(DrystonePlugins::default());
    let condition = || {
        nap();
        true
    };
    app.configure_sets(PhysicsSchedule, PhysicsSystems::Solve.run_if(condition));
    cube(&mut app, Vec3::ZERO);
    frames(&mut app, 5);
    assert!(least_time(&mut app, "solve") >= NAP);
    assert!(least_time(&mut app, "anchors") < NAP);
}

#[test]
fn every_stage_has_its_time() {
    let mut lab = Lab::exact(1.0 / 60.0);
    lab.ground();
    for i in 0..20 {
        lab.cube(Vec3::Y * (0.5 + i as f32));
    }
    lab.run(0.1);
    let profile = lab.world.resource::<Profile>();
    let names = [
        "prepare",
        "joints",
        "broadphase",
        "narrowphase",
        "islands",
        "friction_error",
        "normal_correction",
        "forces",
        "warm_start",
        "solve",
        "anchors",
        "integration",
        "sleeping",
        "sensors",
        "contact_events",
    ];
    assert_eq!(names.len(), PhysicsSystems::ORDER.len());
    let listed: Vec<_> = profile.systems().iter().map(|(name, _)| *name).collect();
    for name in names {
        assert!(listed.contains(&name), "{name} is not in {listed:?}");
        assert!(profile.system(name).unwrap() > Duration::ZERO, "{name}");
    }
    let sum: Duration = profile.systems().iter().map(|(_, time)| *time).sum();
    assert!(sum <= profile.step, "{sum:?} of {:?}", profile.step);
    let parts = profile.solve_parts();
    for (stage, parts) in [
        ("warm_start", [parts.refresh, parts.warm_start]),
        ("solve", [parts.sweeps, parts.store]),
    ] {
        let whole = profile.system(stage).unwrap();
        assert!(parts.iter().all(|part| *part > Duration::ZERO), "{stage}");
        assert!(parts.iter().sum::<Duration>() <= whole, "{stage}");
    }
}

#[test]
fn history_is_kept_on_request() {
    let mut lab = Lab::exact(1.0 / 60.0);
    lab.ground();
    lab.cube(Vec3::Y * 0.5);
    lab.cube(Vec3::Y * 1.5);
    lab.cube(Vec3::new(5.0, 0.5, 0.0));
    lab.step();
    assert!(
        lab.world
            .resource::<SolveReports>()
            .0
            .iter()
            .all(|r| r.report.history.is_empty())
    );
    lab.world.resource_mut::<SolverSettings>().record_history = true;
    lab.step();
    let reports = &lab.world.resource::<SolveReports>().0;
    assert_eq!(reports.len(), 2, "one for each island");
    assert_eq!(reports.iter().map(|r| r.contacts).sum::<usize>(), 12);
    for report in reports {
        let SolveReport {
            sweeps,
            residual,
            history,
            ..
        } = &report.report;
        assert_eq!(history.len(), *sweeps);
        assert_eq!(history.last(), Some(residual));
    }
}

/// The events that observers got.
#[derive(Resource, Default)]
struct Seen {
    started: Vec<(Entity, Entity)>,
    ended: Vec<(Entity, Entity)>,
}

/// A ball that listens, a ball that does not, and the ground.
fn listening() -> (Lab, [Entity; 3]) {
    let mut lab = Lab::new();
    lab.world.init_resource::<Seen>();
    lab.world
        .add_observer(|on: On<ContactStarted>, mut seen: ResMut<Seen>| {
            seen.started.push((on.body, on.other));
        });
    lab.world
        .add_observer(|on: On<ContactEnded>, mut seen: ResMut<Seen>| {
            seen.ended.push((on.body, on.other));
        });
    let ground = lab.ground();
    let listener = lab.body(Collider::ball(0.5), Vec3::Y * 0.6);
    lab.world.entity_mut(listener).insert(ContactEvents);
    let deaf = lab.body(Collider::ball(0.5), Vec3::new(5.0, 0.6, 0.0));
    (lab, [ground, listener, deaf])
}

fn drain<M: Message>(lab: &mut Lab) -> Vec<M> {
    lab.world.resource_mut::<Messages<M>>().drain().collect()
}

#[test]
fn contacts_are_told_once_when_they_start_and_end() {
    let (mut lab, [ground, listener, deaf]) = listening();
    lab.run(1.0);
    let started = drain::<ContactStarted>(&mut lab);
    assert_eq!(started.len(), 2, "everybody's as messages, once each");
    for event in &started {
        assert!([event.body, event.other].contains(&ground));
        assert!(
            lab.world.get::<Manifold>(event.pair).is_some(),
            "the pair is there"
        );
    }
    assert!(drain::<ContactEnded>(&mut lab).is_empty());
    let seen = lab.world.resource::<Seen>();
    assert_eq!(seen.started, [(listener, ground)], "a listener's only");
    assert!(seen.ended.is_empty());

    for ball in [listener, deaf] {
        lab.set_velocity(ball, Vec3::Y * 3.0, Vec3::ZERO);
    }
    lab.run(0.2);
    assert_eq!(drain::<ContactEnded>(&mut lab).len(), 2);
    assert_eq!(lab.world.resource::<Seen>().ended, [(listener, ground)]);
}

#[test]
fn a_contact_ends_with_one_of_its_bodies() {
    let (mut lab, [ground, listener, deaf]) = listening();
    lab.run(0.5);
    lab.world.despawn(deaf);
    lab.step();
    let ended = drain::<ContactEnded>(&mut lab);
    assert_eq!(ended.len(), 1);
    assert!([ended[0].body, ended[0].other].contains(&deaf));
    assert!(lab.world.resource::<Seen>().ended.is_empty());
    lab.world.despawn(ground);
    lab.step();
    assert_eq!(lab.world.resource::<Seen>().ended, [(listener, ground)]);
    assert_eq!(drain::<ContactEnded>(&mut lab).len(), 1);
}

/// Manifolds at rest are kept, and so are their targets.
#[test]
fn friction_stabilization_may_be_turned_off_at_any_time() {
    let mut app = app(DrystonePlugins::default().build());
    ground(&mut app);
    for y in [0.5, 1.5] {
        cube(&mut app, Vec3::Y * y);
    }
    app.world_mut().resource_mut::<SleepSettings>().enabled = false;
    frames(&mut app, 20);
    let held = |app: &mut App| {
        let mut targets = app.world_mut().query::<&ContactTargets>();
        let patches = targets.iter(app.world()).flat_map(|t| &t.patches);
        patches.flatten().count()
    };
    assert_eq!(held(&mut app), 2);
    let mut settings = app.world_mut().resource_mut::<StabilizationSettings>();
    settings.friction.enabled = false;
    frames(&mut app, 2);
    assert_eq!(held(&mut app), 0);
}

#[test]
fn no_system_is_ambiguous_with_a_step() {
    let mut app = app(DrystonePlugins::default());
    app.add_plugins((CollapsePlugin, HandPlugin));
    let strict = ScheduleBuildSettings {
        ambiguity_detection: LogLevel::Error,
        ..Default::default()
    };
    app.configure_schedules(strict);
    frames(&mut app, 3);
}
