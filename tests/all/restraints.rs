//! Bodies that may not move as they would: locked axes, dominance, speed limits; and forces in their own axes.

use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::body::*;
use drystone::collider::{Collider, Friction, Restitution};
use drystone::diagnosis::BodyProblem;
use drystone::prelude::{Grab, SolverSettings};
use drystone::settings::{ContactSolver, Preset};
use drystone::solve::SolveReports;
use drystone::solver::{Nncg, Pgs, SoftStep};
use glam::{BVec3, Quat, Vec3};
use support::{G, Lab, assert_near};

fn weightless() -> Lab {
    let lab = Lab::new();
    let mut lab = lab;
    lab.world.resource_mut::<drystone::settings::Gravity>().0 = Vec3::ZERO;
    lab
}

/// The solvers that a lock has to hold under.
fn labs() -> Vec<Lab> {
    let solvers: [fn() -> SolverSettings; 3] = [
        || Preset::Default.solver(),
        || {
            SolverSettings::new(Pgs {
                iterations: 40,
                ..Default::default()
            })
        },
        || {
            SolverSettings::new(Nncg {
                iterations: 40,
                ..Default::default()
            })
        },
    ];
    solvers
        .into_iter()
        .map(|solver| {
            let mut lab = Lab::new();
            lab.world.insert_resource(solver());
            lab
        })
        .collect()
}

#[test]
fn locked_axes_keep_every_bit_in_a_heap() {
    for mut lab in labs() {
        lab.ground();
        let locks = LockedAxes::new()
            .lock_translation_z()
            .lock_rotation_x()
            .lock_rotation_y();
        let flat: Vec<Entity> = (0..30)
            .map(|i| {
                let at = Vec3::new(
                    (i % 5) as f32 * 0.9,
                    0.6 + (i / 5) as f32 * 1.1,
                    0.1 * (i % 3) as f32,
                );
                let body = lab.body(Collider::cuboid(1.0, 0.5, 0.5), at);
                lab.world
                    .entity_mut(body)
                    .insert((locks, Restitution::new(0.3)));
                lab.set_velocity(body, Vec3::new(1.0, 0.0, 3.0), Vec3::ONE);
                body
            })
            .collect();
        // Free bodies that hit them from the side.
        for i in 0..4 {
            let ball = lab.body(Collider::ball(0.4), Vec3::new(i as f32, 1.5, 4.0));
            lab.set_velocity(ball, Vec3::NEG_Z * 12.0, Vec3::ZERO);
        }
        let depth: Vec<f32> = flat.iter().map(|&body| lab.position(body).z).collect();
        for _ in 0..300 {
            lab.step();
            for (&body, &depth) in flat.iter().zip(&depth) {
                let pose = lab.pose(body);
                let velocity = lab.velocity(body);
                let name = lab
                    .world
                    .resource::<SolverSettings>()
                    .solver
                    .name()
                    .to_owned();
                assert!(lab.errors().is_empty(), "{name}");
                assert!(pose.is_finite());
                assert_eq!((pose.position.z, velocity.linear.z), (depth, 0.0));
                assert_eq!((velocity.angular.x, velocity.angular.y), (0.0, 0.0));
                assert!(pose.rotation.x == 0.0 && pose.rotation.y == 0.0, "{pose:?}");
            }
        }
        assert!(
            flat.iter().all(|&body| lab.position(body).y > 0.2),
            "they lie on the ground"
        );
        let errors = lab.errors();
        assert_eq!(
            errors,
            [],
            "{}",
            lab.world.resource::<SolverSettings>().solver.name()
        );
    }
}

/// Two boxes meet at a slant. What the lock does not allow, the other body must do.
#[test]
fn momentum_along_free_axes_is_kept() {
    for mut lab in labs() {
        lab.world.resource_mut::<drystone::settings::Gravity>().0 = Vec3::ZERO;
        let rail = lab.body(Collider::ball(0.5), Vec3::ZERO);
        lab.world.entity_mut(rail).insert((
            LockedAxes::ROTATION_LOCKED
                .lock_translation_y()
                .lock_translation_z(),
            Friction::new(0.0),
        ));
        let ball = lab.body(Collider::ball(0.5), Vec3::new(-0.8, 1.5, 0.0));
        lab.world.entity_mut(ball).insert(Friction::new(0.0));
        lab.set_velocity(ball, Vec3::new(0.0, -2.0, 0.0), Vec3::ZERO);
        lab.run(1.0);
        let (a, b) = (lab.velocity(rail).linear, lab.velocity(ball).linear);
        assert!(a.x > 0.3, "it was pushed along its rail: {a}");
        assert!((a.x + b.x).abs() < 1e-4, "{a} {b}");
        assert_eq!((a.y, a.z), (0.0, 0.0));
        // Without bounce the two part with no speed along the normal.
        let normal = (lab.position(rail) - lab.position(ball)).normalize();
        assert!(normal.dot(a - b) > -1e-3);
    }
}

#[test]
fn a_body_with_all_axes_locked_stands_like_a_static_one() {
    for mut lab in labs() {
        let held = lab.cube(Vec3::Y * 3.0);
        lab.world.entity_mut(held).insert(LockedAxes::ALL_LOCKED);
        let on_top = lab.cube(Vec3::Y * 4.0);
        lab.run(1.0);
        assert_eq!(lab.position(held), Vec3::Y * 3.0);
        assert!((lab.position(on_top).y - 4.0).abs() < 1e-3);
        // Unlocked again, both fall.
        lab.world.entity_mut(held).remove::<LockedAxes>();
        lab.run(0.5);
        assert_near(3.0 - lab.position(held).y, 0.5 * G * 0.25, 0.05, "fall");
    }
}

/// A wheel on a fixed axle, that a weight drives by friction, and a hand turns.
#[test]
fn a_wheel_turns_on_its_locked_centre() {
    let mut lab = weightless();
    let wheel = lab.body(Collider::cylinder(0.5, 0.2), Vec3::ZERO);
    let axle = LockedAxes::ALL_LOCKED.unlock_rotation_y();
    lab.world.entity_mut(wheel).insert((
        axle,
        ExternalForce {
            torque: Vec3::new(5.0, 2.0, 1.0),
            ..Default::default()
        },
    ));
    lab.run(1.0);
    let inertia = 1.0 / lab.mass(wheel).inverse_inertia.y;
    let expected = 2.0 / inertia;
    assert_near(lab.velocity(wheel).angular.y, expected, 0.01, "τ t/I");
    assert_eq!(lab.position(wheel), Vec3::ZERO);
    lab.world.entity_mut(wheel).remove::<ExternalForce>();
    lab.set_velocity(wheel, Vec3::ZERO, Vec3::ZERO);
    let grab = Grab {
        target: Vec3::new(0.35, 0.0, 0.35),
        turn_axes: BVec3::FALSE,
        ..Grab::gentle(100.0, Vec3::X * 0.5, Vec3::ZERO)
    };
    lab.world.entity_mut(wheel).insert(grab);
    lab.run(3.0);
    assert_eq!(lab.position(wheel), Vec3::ZERO);
    let rim = lab.pose(wheel).transform_point(Vec3::X * 0.5);
    assert!(rim.distance(grab.target) < 0.02, "{rim}");
}

/// The lock of one rotation changes what a torque about another axis does.
#[test]
fn a_locked_rotation_is_a_bearing() {
    let mut lab = weightless();
    let plank = lab.body(Collider::cuboid(2.0, 0.2, 0.1), Vec3::ZERO);
    let at = Transform::from_rotation(Quat::from_rotation_z(0.6));
    lab.world
        .entity_mut(plank)
        .insert((at, LockedAxes::new().lock_rotation_y().lock_rotation_z()));
    let force = ExternalForce {
        torque: Vec3::X,
        ..Default::default()
    };
    lab.world.entity_mut(plank).insert(force);
    lab.step();
    let mass = lab.mass(plank);
    let inertia = mass.world_inverse_inertia(at.rotation).inverse();
    let expected = lab.dt / inertia.x_axis.x;
    assert_near(lab.velocity(plank).angular.x, expected, 1e-4, "τ t/Ixx");
    lab.run(1.0);
    let v = lab.velocity(plank).angular;
    assert_eq!((v.y, v.z), (0.0, 0.0));
}

#[test]
fn the_dominant_body_is_not_moved() {
    for mut lab in labs() {
        lab.ground();
        let light = lab.body(Collider::cuboid(1.0, 1.0, 1.0), Vec3::new(0.0, 0.5, 0.0));
        lab.world
            .entity_mut(light)
            .insert((Mass(1.0), Dominance(2)));
        let heavy = lab.body(Collider::cuboid(1.0, 1.0, 1.0), Vec3::new(0.0, 1.5, 0.0));
        lab.world
            .entity_mut(heavy)
            .insert((Mass(1e5), Dominance(1)));
        lab.run(2.0);
        assert!(
            (lab.position(light).y - 0.5).abs() < 1e-3,
            "nothing presses on it"
        );
        assert!((lab.position(heavy).y - 1.5).abs() < 1e-3);
        let (of_heavy, _) = lab.impulse(heavy, light);
        assert_near(of_heavy, 1e5 * G * lab.dt, 0.01, "weight");
        // In one group, the heavy one rolls or presses as any other.
        lab.world.entity_mut(heavy).insert(Dominance(2));
        lab.set_velocity(light, Vec3::X * 2.0, Vec3::ZERO);
        lab.run(1.0);
        assert_eq!(
            lab.errors()
                .iter()
                .filter(|error| error.problem.is_fatal())
                .count(),
            0
        );
    }
}

#[test]
fn a_dominant_body_pushes_at_its_own_speed() {
    let mut lab = weightless();
    let pusher = lab.cube(Vec3::ZERO);
    lab.world
        .entity_mut(pusher)
        .insert((Mass(0.1), Dominance(1)));
    lab.set_velocity(pusher, Vec3::X, Vec3::ZERO);
    let crates: Vec<Entity> = (0..5)
        .map(|i| lab.cube(Vec3::X * (1.5 + 1.1 * i as f32)))
        .collect();
    lab.run(5.0);
    assert_eq!(lab.velocity(pusher).linear, Vec3::X);
    for found in crates {
        assert!(
            lab.velocity(found).linear.x > 0.95,
            "{}",
            lab.velocity(found).linear
        );
    }
}

#[test]
fn speeds_are_limited_by_body() {
    let mut lab = Lab::new();
    let slow = lab.cube(Vec3::ZERO);
    lab.world
        .entity_mut(slow)
        .insert((MaxLinearSpeed(3.0), MaxAngularSpeed(1.0)));
    let free = lab.cube(Vec3::X * 5.0);
    for body in [slow, free] {
        lab.set_velocity(body, Vec3::ZERO, Vec3::Y * 10.0);
    }
    lab.run(1.0);
    assert_near(lab.velocity(slow).linear.length(), 3.0, 1e-5, "limit");
    assert_near(lab.velocity(slow).angular.length(), 1.0, 1e-5, "limit");
    assert_near(lab.velocity(free).linear.length(), G, 1e-3, "fall");
    // The limit is of the way too.
    let before = lab.position(slow);
    lab.step();
    assert!(lab.position(slow).distance(before) <= 3.0 * lab.dt * 1.001);
}

#[test]
fn a_limit_that_is_no_number_is_reported() {
    let mut lab = Lab::new();
    let body = lab.cube(Vec3::ZERO);
    lab.world.entity_mut(body).insert(MaxLinearSpeed(f32::NAN));
    lab.step();
    let errors = lab.errors();
    assert_eq!(errors[0].problem, BodyProblem::InvalidMaxSpeed);
    assert!(errors[0].to_string().contains("MaxLinearSpeed"));
    lab.world.entity_mut(body).insert(MaxLinearSpeed(1.0));
    lab.run(1.0);
    assert!(lab.world.get::<Quarantined>(body).is_none());
    assert_near(lab.velocity(body).linear.length(), 1.0, 1e-5, "limit");
}

#[test]
fn forces_in_the_axes_of_the_body_turn_with_it() {
    let mut lab = weightless();
    let rocket = lab.body(Collider::ball(0.5), Vec3::ZERO);
    let mut thrust = ExternalForce::default();
    thrust.add_local_at(Vec3::X * 2.0, Vec3::Y * 0.5);
    assert_eq!(
        (thrust.local_force, thrust.local_torque),
        (Vec3::X * 2.0, Vec3::Z * -1.0)
    );
    thrust.local_torque = Vec3::ZERO;
    let turned = Transform::from_rotation(Quat::from_rotation_z(0.5));
    lab.world
        .entity_mut(rocket)
        .insert((Mass(1.0), thrust, turned));
    lab.run(1.0);
    let expected = 2.0 * (turned.rotation * Vec3::X);
    assert!(lab.velocity(rocket).linear.distance(expected) < 1e-4);
    // A change of it wakes a sleeping body.
    let mut sleeping = lab.world.get_mut::<Sleeping>(rocket).unwrap();
    sleeping.asleep = true;
    lab.set_velocity(rocket, Vec3::ZERO, Vec3::ZERO);
    lab.world
        .get_mut::<ExternalForce>(rocket)
        .unwrap()
        .local_force = Vec3::Z;
    lab.run(0.1);
    assert!(lab.velocity(rocket).linear.z > 0.05);
}

#[test]
fn impulses_act_at_points() {
    let mut lab = weightless();
    let body = lab.cube(Vec3::ONE);
    let at = Transform::from_translation(Vec3::ONE).with_rotation(Quat::from_rotation_y(1.0));
    lab.world.entity_mut(body).insert(at);
    lab.step();
    let dt = lab.dt;
    let mut forces = lab.world.query::<Forces>();
    let mut of = forces.get_mut(&mut lab.world, body).unwrap();
    assert_eq!(of.center_of_mass(), Vec3::ONE);
    of.apply_force_at_point(Vec3::X * 100.0 / dt, Vec3::ONE + Vec3::Z * 0.5, dt);
    of.apply_local_linear_impulse(Vec3::Y * 50.0);
    of.apply_local_angular_impulse(Vec3::Y * 7.0);
    lab.step();
    let v = lab.velocity(body);
    assert!(v.linear.distance(Vec3::new(0.1, 0.05, 0.0)) < 1e-5, "{v:?}");
    assert_near(v.angular.y, (50.0 + 7.0) * 6.0 / 1000.0, 1e-4, "r J/I");
}

/// Whatever the island is kept from, a lock that is set while it stands takes effect at once.
#[test]
fn locks_are_set_while_bodies_touch() {
    let mut lab = Lab::shipped(1.0 / 60.0);
    lab.slope(0.7, 0.0);
    let at = |s: f32| Quat::from_rotation_z(-0.7) * Vec3::new(s, 0.5, 0.0);
    let bodies = [lab.cube(at(0.0)), lab.cube(at(-1.0))];
    for body in bodies {
        let mut transform = lab.world.get_mut::<Transform>(body).unwrap();
        transform.rotation = Quat::from_rotation_z(-0.7);
        lab.world.entity_mut(body).insert(Friction::new(0.0));
    }
    lab.run(0.5);
    assert!(lab.velocity(bodies[0]).linear.x > 1.0);
    lab.world
        .entity_mut(bodies[0])
        .insert(LockedAxes::ALL_LOCKED);
    lab.step();
    let held = lab.position(bodies[0]);
    lab.run(1.0);
    assert_eq!(lab.position(bodies[0]), held);
    assert!(
        lab.velocity(bodies[1]).linear.length() < 0.01,
        "it leans on the one that is held"
    );
}

/// A light brick between two heavy ones gets the sweeps that it asks for, and so does all that it touches; others do not.
#[test]
fn effort_is_for_what_needs_it() {
    for solver in [
        ContactSolver::from(SoftStep::default()),
        Pgs::default().into(),
        Nncg::default().into(),
    ] {
        let mut lab = Lab::new();
        lab.world.insert_resource(SolverSettings::new(solver));
        lab.ground();
        let tower = |lab: &mut Lab, x: f32| {
            let place = |i: usize| Transform::from_xyz(x, 0.5 + i as f32, 0.0);
            let cube = |i| {
                (
                    RigidBody::Dynamic,
                    Collider::cuboid(1.0, 1.0, 1.0),
                    place(i),
                )
            };
            let bodies: Vec<Entity> = (0..3).map(|i| lab.spawn(cube(i))).collect();
            lab.world.entity_mut(bodies[1]).insert(Mass(1.0));
            bodies
        };
        let bodies = tower(&mut lab, 0.0);
        tower(&mut lab, 9.0);
        let sweeps = |lab: &mut Lab| {
            lab.step();
            let reports = &lab.world.resource::<SolveReports>().0;
            let sweeps = reports.iter().map(|island| island.report.sweeps);
            sweeps.collect::<Vec<usize>>()
        };
        sweeps(&mut lab);
        let usual = sweeps(&mut lab);
        assert_eq!(usual[0], usual[1]);
        lab.world.entity_mut(bodies[1]).insert(SolverEffort(4.0));
        let more = sweeps(&mut lab);
        assert_eq!(more[1], usual[1]);
        // Whole rounds of sweeps; and PGS and NNCG may be content earlier.
        assert!(
            more[0] >= 2 * usual[0] && more[0] <= 4 * usual[0] + 4,
            "{usual:?}, {more:?}"
        );
        lab.world.entity_mut(bodies[1]).remove::<SolverEffort>();
        assert_eq!(sweeps(&mut lab)[0], usual[0]);
        lab.world.entity_mut(bodies[1]).insert(SolverEffort(0.5));
        lab.step();
        let errors = lab.errors();
        assert_eq!(errors[0].problem, BodyProblem::InvalidSolverEffort);
    }
}
