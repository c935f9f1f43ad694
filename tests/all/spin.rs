//! Spin as fast as a game can ask for: nothing is lost, nothing is gained.

use bevy_ecs::prelude::*;
use drystone::body::limits;
use drystone::collider::Collider;
use drystone::settings::{Gravity, SpeedLimits};
use drystone_lab::metrics;
use glam::{Quat, Vec3};
use support::*;

fn brick() -> Collider {
    Collider::cuboid(1.0, 0.5, 0.25)
}

fn weightless(dt: f32) -> Lab {
    let mut lab = Lab::shipped(dt);
    lab.world.insert_resource(Gravity(Vec3::ZERO));
    // The cap would take momentum.
    lab.world.insert_resource(SpeedLimits {
        linear: limits::SPEED,
        angular: limits::SPIN,
    });
    lab
}

/// Angular momentum in the world, kg·m²/s.
fn momentum(lab: &Lab, body: Entity) -> Vec3 {
    let mass = lab.mass(body);
    let frame = lab.pose(body).rotation * mass.local_frame;
    frame * ((frame.inverse() * lab.velocity(body).angular) / mass.inverse_inertia)
}

/// The relative errors of a free body after this many steps: that of its momentum, and the largest decrease and increase of its energy.
fn strays(collider: Collider, dt: f32, spin: Vec3, steps: usize) -> (f32, f64, f64) {
    let mut lab = weightless(dt);
    let body = lab.body(collider, Vec3::ZERO);
    // Its mass is known after its first step.
    lab.step();
    lab.set_velocity(body, Vec3::ZERO, spin);
    let (l, e) = (
        momentum(&lab, body),
        metrics::kinetic_energy(&mut lab.world),
    );
    let (mut off, mut falls, mut rises) = (0.0f32, 0.0f64, 0.0f64);
    for _ in 0..steps {
        lab.step();
        assert_eq!(lab.errors(), []);
        off = off.max((momentum(&lab, body) - l).length() / l.length());
        let share = metrics::kinetic_energy(&mut lab.world) / e - 1.0;
        (falls, rises) = (falls.max(-share), rises.max(share));
    }
    (off, falls, rises)
}

fn shapes() -> [Collider; 5] {
    [
        brick(),
        Collider::cuboid(10.0, 0.05, 0.05),
        Collider::cuboid(1.0, 0.01, 1.0),
        Collider::cuboid(10.0, 0.05, 0.04),
        Collider::cylinder(0.5, 0.1),
    ]
}

/// Poses and velocities are kept in f32: a thin body loses and gains 1e-4 of its energy by their rounding.
const ROUNDING: f64 = 3e-4;

/// A little off each axis, and across all of them.
const AXES: [Vec3; 4] = [
    Vec3::new(1.0, 0.01, 0.02),
    Vec3::new(0.01, 1.0, 0.02),
    Vec3::new(0.02, 0.01, 1.0),
    Vec3::new(0.5, 0.6, 0.7),
];

#[test]
fn free_spin_keeps_momentum_and_energy_to_a_hundredth_up_to_one_and_a_half_radians_a_step() {
    for dt in [1.0 / 60.0, 1.0 / 30.0, 0.1] {
        for (axis, turn) in AXES
            .into_iter()
            .flat_map(|a| [0.1, 0.5, 1.0, 1.5].map(|t| (a, t)))
        {
            for shape in shapes() {
                let spin = axis.normalize() * turn / dt;
                let (off, falls, rises) = strays(shape.clone(), dt, spin, 600);
                let what = format!("{shape:?} {turn} rad in {dt} s about {axis}");
                println!("{what}: {off}, -{falls}, +{rises}");
                assert!(off < 1e-2 && falls < 1e-2, "{what}: {off}, {falls}");
                assert!(rises < ROUNDING, "{what}: gains {rises}");
            }
        }
    }
}

#[test]
fn free_spin_gains_nothing_at_any_speed() {
    for dt in [1e-3, 1.0 / 60.0, 1.0 / 30.0, 0.1] {
        for spin in [20.0, 50.0, 100.0, 200.0, 1e3, 1e4, 1e5] {
            for (axis, shape) in AXES.into_iter().flat_map(|a| shapes().map(|s| (a, s))) {
                let (off, _, rises) = strays(shape.clone(), dt, axis.normalize() * spin, 200);
                let what = format!("{shape:?} {spin} rad/s about {axis}, Δt {dt}");
                println!("{what}: {off}, +{rises}");
                assert!(off < 1e-3, "{what}: momentum off by {off}");
                assert!(rises < ROUNDING, "{what}: gains {rises}");
            }
        }
    }
}

/// Steps of 1.5 rad against a hundred times finer ones.
#[test]
fn a_tumbling_brick_turns_over_when_it_should() {
    let turned_over = |dt: f32| {
        let mut lab = weightless(dt);
        let body = lab.body(brick(), Vec3::ZERO);
        // About the middle axis, y being 0.5 m.
        lab.set_velocity(body, Vec3::ZERO, Vec3::new(0.1, 30.0, 0.0));
        let mut time = 0.0;
        while (lab.pose(body).rotation * Vec3::Y).y > 0.0 && time < 5.0 {
            lab.step();
            time += dt;
        }
        time
    };
    let (found, expected) = (turned_over(0.05), turned_over(0.0005));
    println!("after {found} s, expected {expected} s");
    assert!((found - expected).abs() < 0.1, "{found} {expected}");
}

/// The rotation of bodies that touch, or may touch, is that of the solver.
#[test]
fn bodies_that_spin_into_the_ground_or_another_gain_nothing() {
    let mut rng = fastrand::Rng::with_seed(3);
    let mut random = move || {
        let mut one = || 2.0 * rng.f32() - 1.0;
        Vec3::new(one(), one(), one())
    };
    let mut worst = 0.0f64;
    for spin in [10.0, 30.0, 100.0, 300.0, 1000.0] {
        for dt in [1.0 / 60.0, 0.1] {
            for grounded in [true, false] {
                let mut lab = weightless(dt);
                if grounded {
                    lab.ground();
                    lab.world.insert_resource(Gravity::default());
                }
                let bodies = [-0.7, 0.7].map(|x| lab.body(brick(), Vec3::new(x, 0.65, 0.0)));
                for body in bodies {
                    let turn = Quat::from_scaled_axis(random());
                    let mut at = lab
                        .world
                        .get_mut::<bevy_transform::components::Transform>(body)
                        .unwrap();
                    at.rotation = turn;
                    lab.set_velocity(body, random(), random() * spin);
                }
                let mut last = f64::INFINITY;
                for i in 0..200 {
                    lab.step();
                    assert_eq!(lab.errors(), []);
                    let energy = metrics::energy(&mut lab.world);
                    if i > 0 {
                        worst = worst.max((energy - last) / last);
                    }
                    assert!(
                        energy < last * 1.002,
                        "{spin} rad/s, Δt {dt}, {grounded}: {last} to {energy} J in step {i}"
                    );
                    last = energy;
                }
            }
        }
    }
    println!("gains {worst:.1e} at most");
}
