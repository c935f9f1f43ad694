//! Compares the simulation with closed-form solutions. Numbers in names are rows of the table of reference values.
//!
//! Rows with contacts run twice: with [`Lab::exact`], whose solver converges, so that only the errors of the method and of Δt remain, and with
//! [`Lab::shipped`], which has the default solver and its sweeps. The tolerances follow from the step and are the same for both: the error of
//! semi-implicit Euler is the motion of one step, and a threshold can only be found as accurately as motion beyond it differs from rest in the
//! given time.

use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::body::{Density, GravityScale, RigidBody, Velocity};
use drystone::collider::{Collider, Restitution};
use drystone::settings::Gravity;
use glam::{Quat, Vec3};
use std::f32::consts::FRAC_PI_2;
use support::accuracy::*;
use support::*;

/// The rows with contacts, as tests under both settings of [`Lab`]. An attribute in parentheses is that of the test under [`Lab::shipped`].
macro_rules! rows {
    ($($row:ident $(($shipped:meta))?),+ $(,)?) => {
        mod exact {
            $(
                #[test]
                fn $row() {
                    super::$row(super::Lab::exact);
                }
            )+
        }

        mod shipped {
            $(
                #[test]
                $(#[$shipped])?
                fn $row() {
                    super::$row(super::Lab::shipped);
                }
            )+
        }
    };
}

rows!(
    row_1_a_box_starts_to_slide_where_the_tangent_of_the_slope_is_the_friction,
    row_2_a_box_slides_down_with_g_sin_minus_mu_g_cos,
    row_3_a_sliding_box_stops_after_v_squared_over_two_mu_g,
    row_4_spheres_and_cylinders_roll_without_slip_while_friction_suffices,
    row_4_beyond_the_limit_they_slip,
    row_5_a_sliding_sphere_rolls_at_five_sevenths_of_its_speed,
    row_6_a_tower_topples_where_the_tangent_of_the_slope_is_width_over_height,
    row_10_blocks_hang_over_by_half_the_harmonic_number,
    row_10_blocks_whose_edges_lie_exactly_on_each_other_do_too,
    row_16_a_ladder_slips_below_its_angle,
    row_17_a_ball_bounces_to_e_squared_of_its_height_and_comes_to_rest_in_time,
    row_18_every_interface_carries_the_weight_above_it(
        ignore =
            "missed: friction jitters by 0.11 % of the weight under 4 cubes at 8°, wanted 0.1 %"
    ),
    row_20_collisions_keep_the_momentum_of_a_closed_group(
        ignore = "missed: arms are frozen for a step, and angular momentum is off by 3e-3 (2e-3 to 7e-3 with other seeds), wanted 1e-4"
    ),
    a_cube_that_falls_flat_stays_where_it_lands,
);

fn row_1_a_box_starts_to_slide_where_the_tangent_of_the_slope_is_the_friction(settings: Settings) {
    for friction in [0.2, 0.5, 0.9] {
        let (found, expected) = slide_angle(settings, 1.0 / 60.0, friction, 0.01);
        let found = found.expect("the threshold is within 2°");
        println!("μ {friction}: found {found}°, expected {expected}°");
        assert!((found - expected).abs() < 0.1, "{found} {expected}");
    }
}

fn row_2_a_box_slides_down_with_g_sin_minus_mu_g_cos(settings: Settings) {
    for (degrees, friction) in [(28.0f32, 0.5), (35.0, 0.5), (20.0, 0.1), (50.0, 0.0)] {
        let (gained, expected) = slide_acceleration(settings, 1.0 / 60.0, degrees, friction);
        let what = format!("{degrees}°, μ {friction}");
        assert_near(gained, expected, 0.005, &what);
    }
}

/// Semi-implicit Euler brakes one half step early: v Δt/2 = 1 cm.
fn row_3_a_sliding_box_stops_after_v_squared_over_two_mu_g(settings: Settings) {
    let (went, expected) = stop_distance(settings, 1.0 / 240.0);
    let went = went.expect("it stops");
    assert_near(went, expected, 0.006, "stop distance");
}

struct Roller {
    name: &'static str,
    collider: Collider,
    /// I/(m r²)
    inertia: f32,
}

fn rollers() -> [Roller; 2] {
    [
        Roller {
            name: "sphere",
            collider: Collider::ball(0.5),
            inertia: 0.4,
        },
        Roller {
            name: "cylinder",
            collider: Collider::cylinder(0.5, 1.0),
            inertia: 0.5,
        },
    ]
}

/// Velocity and spin gained in a second, after half a second to settle.
fn roll(settings: Settings, roller: &Roller, degrees: f32, friction: f32) -> (f32, f32) {
    let mut lab = settings(1.0 / 120.0);
    let angle = degrees.to_radians();
    lab.slope(angle, friction);
    let lying = Quat::from_rotation_x(FRAC_PI_2);
    let body = on_slope(
        &mut lab,
        angle,
        roller.collider.clone(),
        0.5,
        lying,
        friction,
    );
    lab.run(0.5);
    let before = lab.velocity(body);
    lab.run(1.0);
    let after = lab.velocity(body);
    let downhill = Quat::from_rotation_z(-angle) * Vec3::X;
    (
        (after.linear - before.linear).dot(downhill),
        -(after.angular - before.angular).z,
    )
}

fn row_4_spheres_and_cylinders_roll_without_slip_while_friction_suffices(settings: Settings) {
    for roller in rollers() {
        // μ/tan θ must exceed c/(1 + c): 2/7 and 1/3.
        for (degrees, friction) in [(15.0f32, 0.1), (30.0, 0.5)] {
            let (a, alpha) = roll(settings, &roller, degrees, friction);
            let expected = G * degrees.to_radians().sin() / (1.0 + roller.inertia);
            let name = roller.name;
            assert_near(a, expected, 0.01, &format!("{name} at {degrees}°"));
            assert_near(
                0.5 * alpha,
                a,
                0.01,
                &format!("{name} at {degrees}°, rolling"),
            );
        }
    }
}

fn row_4_beyond_the_limit_they_slip(settings: Settings) {
    for roller in rollers() {
        let (degrees, friction) = (30.0f32, 0.1);
        let (a, alpha) = roll(settings, &roller, degrees, friction);
        let (sin, cos) = degrees.to_radians().sin_cos();
        let name = roller.name;
        let expected = G * (sin - friction * cos);
        assert_near(a, expected, 0.01, &format!("{name} slips"));
        let expected = friction * G * cos / (roller.inertia * 0.5);
        assert_near(alpha, expected, 0.01, &format!("{name} spins up"));
    }
}

fn row_5_a_sliding_sphere_rolls_at_five_sevenths_of_its_speed(settings: Settings) {
    let found = slide_into_rolling(settings, 1.0 / 480.0);
    let (time, way) = found.rolls_at.expect("it rolls in the end");
    let (v, mu) = (5.0, 0.5);
    assert_near(found.speed, v * 5.0 / 7.0, 0.002, "speed");
    // Within a step or two of the time, and their way.
    assert_near(time, 2.0 * v / (7.0 * mu * G), 0.015, "time");
    assert_near(way, 12.0 * v * v / (49.0 * mu * G), 0.015, "distance");
}

fn row_6_a_tower_topples_where_the_tangent_of_the_slope_is_width_over_height(settings: Settings) {
    for n in [2u32, 4] {
        let (found, expected) = topple_angle(settings, 1.0 / 60.0, n, 0.05);
        let found = found.expect("the threshold is within 3°");
        println!("{n} cubes: found {found}°, expected {expected}°");
        assert!((found - expected).abs() < 0.4, "{found} {expected}");
    }
}

/// The best overhang of n blocks, and how it scales: at 98 % the margin of every interface is 1 cm, and beyond it none.
fn overhang(settings: Settings, depth: impl Fn(i32) -> f32) {
    for n in 1..=4 {
        let stands = |share: f32| {
            let mut lab = settings(1.0 / 60.0);
            lab.spawn((
                RigidBody::Static,
                Collider::cuboid(4.0, 1.0, 1.0),
                Transform::from_xyz(-2.0, -0.5, 0.0),
            ));
            let mut right = 0.0;
            let mut blocks = Vec::new();
            for course in 0..n {
                right += share / (2 * (n - course)) as f32;
                let position = Vec3::new(right - 0.5, 0.125 + 0.25 * course as f32, 0.0);
                blocks.push((
                    lab.body(Collider::cuboid(1.0, 0.25, depth(course)), position),
                    position,
                ));
            }
            lab.run(4.0);
            println!("{n} blocks: overhang {right}");
            let moved = |&(body, start): &(Entity, Vec3)| (lab.position(body) - start).length();
            blocks.iter().all(|block| moved(block) < 0.02)
        };
        assert!(stands(0.98), "{n} blocks just under");
        assert!(!stands(1.02), "{n} blocks just over");
    }
}

fn row_10_blocks_hang_over_by_half_the_harmonic_number(settings: Settings) {
    overhang(settings, |course| 0.5 - 0.02 * course as f32);
}

/// In this case parry loses corners to rounding.
fn row_10_blocks_whose_edges_lie_exactly_on_each_other_do_too(settings: Settings) {
    overhang(settings, |_| 0.5);
}

fn row_16_a_ladder_slips_below_its_angle(settings: Settings) {
    for (wall, floor) in [(0.5f32, 0.5f32), (0.0, 0.5), (0.3, 0.6)] {
        let (found, expected) = ladder_angle(settings, 1.0 / 120.0, wall, floor, 0.05);
        let found = found.expect("the threshold is within 3°");
        println!("μ {wall} {floor}: found {found}°, expected {expected}°");
        assert!((found - expected).abs() < 0.4, "{found} {expected}");
    }
}

/// A bounce happens a step early or late, which changes the speed by up to gΔt of each: Δt is small, as heights are squares.
fn row_17_a_ball_bounces_to_e_squared_of_its_height_and_comes_to_rest_in_time(settings: Settings) {
    let dt = 1.0 / 1000.0;
    let (e, h) = (0.8f32, 1.0f32);
    let mut lab = settings(dt);
    lab.spawn((
        RigidBody::Static,
        Collider::half_space(Vec3::Y),
        Restitution::new(e),
    ));
    let ball = lab.spawn((
        RigidBody::Dynamic,
        Collider::ball(0.1),
        Restitution::new(e),
        Transform::from_xyz(0.0, h + 0.1, 0.0),
    ));
    let (mut apexes, mut last, mut rose_at) = (Vec::new(), 0.0, 0.0);
    let total = (2.0 * h / G).sqrt() * (1.0 + e) / (1.0 - e);
    for i in 0..6000 {
        lab.step();
        let (v, y) = (lab.velocity(ball).linear.y, lab.position(ball).y - 0.1);
        if last > 0.0 && v <= 0.0 {
            apexes.push(y);
        }
        if v > 0.05 {
            rose_at = i as f32 * dt;
        }
        last = v;
    }
    for (n, &apex) in apexes.iter().take(6).enumerate() {
        let n = n as i32 + 1;
        assert_near(
            apex,
            e.powi(2 * n) * h,
            0.01 * n as f32,
            &format!("apex {n}"),
        );
    }
    // Bounces below 5 cm/s, the last 2v/g/(1 − e) = 0.05 s, are not told from rest.
    assert_near(rose_at, total, 0.03, "total time");
    assert!(lab.velocity(ball).linear.length() < 1e-3);
    assert!(lab.position(ball).y - 0.1 < 0.002);
}

/// Averaged over a second, since anchors undo slips of 10 μm at once, with 5e-4 m/s.
fn row_18_every_interface_carries_the_weight_above_it(settings: Settings) {
    for degrees in [0.0f32, 8.0] {
        let (angle, n) = (degrees.to_radians(), 5);
        let mut lab = settings(1.0 / 60.0);
        let mut bodies = vec![lab.slope(angle, 0.5)];
        let cube = Collider::cuboid(1.0, 1.0, 1.0);
        for i in 0..n {
            let (height, upright) = (i as f32 + 0.5, Quat::IDENTITY);
            bodies.push(on_slope(
                &mut lab,
                angle,
                cube.clone(),
                height,
                upright,
                0.5,
            ));
        }
        lab.run(3.0);
        let mut sums = vec![(0.0, Vec3::ZERO); n];
        for _ in 0..60 {
            lab.step();
            for (i, sum) in sums.iter_mut().enumerate() {
                let (normal, tangential) = lab.impulse(bodies[i + 1], bodies[i]);
                *sum = (sum.0 + normal / 60.0, sum.1 + tangential / 60.0);
            }
        }
        for (i, (normal, tangential)) in sums.into_iter().enumerate() {
            let weight = (n - i) as f32 * 1000.0 * G * lab.dt;
            let what = format!("under {} cubes at {degrees}°", n - i);
            assert_near(normal, weight * angle.cos(), 1e-3, &what);
            // Without slope nothing but what a change of speed of 1e-4 m/s needs.
            let uphill = Vec3::new(-angle.cos(), angle.sin(), 0.0) * angle.sin();
            let off = (tangential - weight * uphill).length();
            println!("  tangential {tangential}, off by {off}");
            assert!(off < 1e-3 * weight, "{what}: {tangential}");
        }
    }
}

/// A brick spun about its middle axis turns over and back, and keeps its angular momentum and energy all the while.
#[test]
fn row_19_a_free_brick_keeps_momentum_and_energy_while_it_tumbles() {
    let mut lab = Lab::exact(1.0 / 60.0);
    lab.world.insert_resource(Gravity(Vec3::ZERO));
    // The middle moment of inertia is about the middle length, y.
    let brick = lab.body(Collider::cuboid(1.0, 0.5, 0.2), Vec3::ZERO);
    lab.set_velocity(brick, Vec3::X, Vec3::new(0.005, 5.0, 0.0));
    lab.step();
    let momentum = |lab: &Lab| {
        let inverse = lab
            .mass(brick)
            .world_inverse_inertia(lab.pose(brick).rotation);
        inverse.inverse() * lab.velocity(brick).angular
    };
    let energy = |lab: &Lab| {
        let (pose, velocity) = (lab.pose(brick), lab.velocity(brick));
        lab.mass(brick).kinetic_energy(pose.rotation, &velocity)
    };
    let (momentum_0, energy_0) = (momentum(&lab), energy(&lab));
    let (mut lowest, mut worst_momentum, mut worst_energy) = (1.0f32, 0.0f32, 0.0f32);
    for _ in 0..3600 {
        lab.step();
        assert!(lab.pose(brick).is_finite() && lab.velocity(brick).is_finite());
        let off = (momentum(&lab) - momentum_0).length() / momentum_0.length();
        worst_momentum = worst_momentum.max(off);
        worst_energy = worst_energy.max((energy(&lab) / energy_0 - 1.0).abs());
        lowest = lowest.min((lab.pose(brick).rotation * Vec3::Y).y);
    }
    println!("momentum off by {worst_momentum}, energy by {worst_energy}, lowest {lowest}");
    // Rounding of 3600 steps, a few units in the last place (1e-7) each; energy is a square.
    assert!(worst_momentum < 2e-3 && worst_energy < 4e-3);
    assert!(lowest < -0.9, "the middle axis is unstable");
}

/// Semi-implicit Euler is exact in the velocity, and one half step of falling ahead in the height: gTΔt/2.
#[test]
fn row_20_a_projectile_flies_a_parabola() {
    let mut lab = Lab::exact(1.0 / 240.0);
    let brick = lab.body(Collider::cuboid(0.3, 0.2, 0.1), Vec3::Y);
    lab.set_velocity(brick, Vec3::new(3.0, 8.0, -1.0), Vec3::new(1.0, 2.0, 3.0));
    let time = 1.5;
    lab.run(time);
    let truth = Vec3::new(3.0 * time, 1.0 + 8.0 * time - 0.5 * G * time * time, -time);
    let off = (lab.position(brick) - truth).length();
    println!("off by {off} m");
    assert!(off < 0.5 * G * time * lab.dt + 1e-3, "{off}");
    let speed = Vec3::new(3.0, 8.0 - G * time, -1.0);
    assert!((lab.velocity(brick).linear - speed).length() < 1e-4);
}

/// Boxes and balls of many weights fly into each other: contact only hands momentum on, linear and angular.
fn row_20_collisions_keep_the_momentum_of_a_closed_group(settings: Settings) {
    let mut lab = settings(1.0 / 60.0);
    let mut rng = fastrand::Rng::with_seed(7);
    let mut random = |size: f32| {
        let mut one = || (2.0 * rng.f32() - 1.0) * size;
        Vec3::new(one(), one(), one())
    };
    let mut bodies = Vec::new();
    for i in 0..24 {
        let at = Vec3::new((i % 3) as f32, (i / 3 % 3) as f32, (i / 9) as f32) * 1.5 - 1.5;
        let collider = match i % 2 {
            0 => Collider::cuboid(0.8, 0.5, 0.6),
            _ => Collider::ball(0.4),
        };
        bodies.push(lab.spawn((
            RigidBody::Dynamic,
            collider,
            Restitution::new(0.5),
            Density(500.0 * (1 + i % 4) as f32),
            GravityScale(0.0),
            Velocity {
                linear: -1.5 * at + random(1.0),
                angular: random(3.0),
            },
            Transform::from_translation(at),
        )));
    }
    let momentum = |lab: &Lab| {
        let (mut linear, mut angular, mut size) = (Vec3::ZERO, Vec3::ZERO, 0.0);
        for &body in &bodies {
            let (pose, v, mass) = (lab.pose(body), lab.velocity(body), lab.mass(body));
            let spin = mass.world_inverse_inertia(pose.rotation).inverse() * v.angular;
            let push = v.linear * mass.mass();
            linear += push;
            angular += pose.transform_point(mass.local_center).cross(push) + spin;
            size += push.length();
        }
        (linear, angular, size)
    };
    lab.step();
    let (linear, angular, size) = momentum(&lab);
    let energy = drystone_lab::metrics::kinetic_energy(&mut lab.world);
    lab.run(3.0);
    let (linear_after, angular_after, _) = momentum(&lab);
    let spent = 1.0 - drystone_lab::metrics::kinetic_energy(&mut lab.world) / energy;
    let off = (linear_after - linear).length() / size;
    let turned = (angular_after - angular).length() / size;
    println!("linear off by {off}, angular by {turned}, of {size}; energy spent {spent}");
    assert!(spent > 0.1, "they must have collided");
    // Rounding of 180 steps over 24 bodies.
    assert!(off < 2e-5 && turned < 1e-4, "{off} {turned}");
}

/// By symmetry. Nothing bounces (e = 0): up to 1 % of the speed with which it came.
fn a_cube_that_falls_flat_stays_where_it_lands(settings: Settings) {
    for height in [0.1f32, 1.0, 3.0] {
        let mut lab = settings(1.0 / 60.0);
        lab.ground();
        let cube = lab.cube(Vec3::Y * (0.5 + height));
        let (mut up, mut aside) = (0.0f32, 0.0f32);
        for _ in 0..180 {
            lab.step();
            assert!(lab.pose(cube).is_finite() && lab.velocity(cube).is_finite());
            up = up.max(lab.velocity(cube).linear.y);
            aside = aside.max(lab.position(cube).with_y(0.0).length());
        }
        println!("from {height} m: up {up} m/s, {aside} m aside");
        assert!(up < 0.01 * (2.0 * G * height).sqrt(), "{up} m/s up");
        assert!(aside < 1e-3, "{aside} m aside");
    }
}
