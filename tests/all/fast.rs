//! Fast things do not pass through thin ones, at 60 Hz and at steps of 0.1 s.

use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::body::*;
use drystone::collider::Collider;
use drystone::contact::ContactPair;
use fastrand::Rng;
use glam::{Quat, Vec3};
use support::Lab;

/// Speed, m/s, and thickness of what is hit, m.
const SPEED: f32 = 300.0;
const THICK: f32 = 0.05;
const SHOTS: usize = 200;

/// A lab without gravity, so that whatever passes goes on.
fn lab(dt: f32) -> Lab {
    let mut lab = Lab::new();
    lab.dt = dt;
    lab.world.resource_mut::<drystone::settings::Gravity>().0 = Vec3::ZERO;
    lab
}

/// Shoots along +x at something about the origin from random places. Returns the number of shots that end beyond it.
fn through(shoot: impl Fn(&mut Lab, &mut Rng) -> Entity, dt: f32) -> usize {
    let mut rng = Rng::with_seed(7);
    let passed = (0..SHOTS).filter(|_| {
        let mut lab = lab(dt);
        let shot = shoot(&mut lab, &mut rng);
        let ahead = 10.0 + 60.0 * rng.f32();
        let at = Vec3::new(-ahead, rng.f32() - 0.5, rng.f32() - 0.5);
        let turned = Quat::from_axis_angle(
            Vec3::new(rng.f32(), rng.f32(), 0.1).normalize(),
            6.0 * rng.f32(),
        );
        let mut transform = lab.world.get_mut::<Transform>(shot).unwrap();
        (transform.translation, transform.rotation) = (at, turned);
        let spin = lab.velocity(shot).angular;
        lab.set_velocity(shot, Vec3::X * SPEED, spin);
        lab.run(ahead / SPEED + 4.0 * dt);
        lab.position(shot).x > 1.0
    });
    passed.count()
}

fn check(what: &str, shoot: impl Fn(&mut Lab, &mut Rng) -> Entity) {
    for dt in [1.0 / 60.0, 0.1] {
        let passed = through(&shoot, dt);
        println!("{what} at Δt {dt:.3} s: {passed} of {SHOTS} through");
        assert_eq!(passed, 0, "{what} at Δt {dt}");
    }
}

fn plate(lab: &mut Lab) {
    lab.spawn((RigidBody::Static, Collider::cuboid(THICK, 4.0, 4.0)));
}

#[test]
fn balls_do_not_pass_a_thin_wall() {
    check("balls of 5 cm", |lab, _| {
        plate(lab);
        lab.body(Collider::ball(0.025), Vec3::ZERO)
    });
}

#[test]
fn boxes_do_not_pass_a_thin_wall() {
    check("boxes", |lab, rng| {
        plate(lab);
        let size = |rng: &mut Rng| 0.05 + 0.3 * rng.f32();
        let shape = Collider::cuboid(size(rng), size(rng), size(rng));
        lab.body(shape, Vec3::ZERO)
    });
}

/// The first end that hits stops, and the contact of the other one keeps the middle of the rod from going on.
#[test]
fn spinning_rods_do_not_pass_a_thin_wall() {
    for most in [0.0, 60.0] {
        check(
            &format!("rods with spins up to {most} rad/s"),
            |lab, rng| {
                plate(lab);
                let rod = lab.body(Collider::cuboid(0.05, 1.0, 0.05), Vec3::ZERO);
                let spin = Vec3::new(rng.f32(), rng.f32(), rng.f32()) - 0.5;
                lab.set_velocity(rod, Vec3::ZERO, most * spin);
                rod
            },
        );
    }
}

#[test]
fn balls_do_not_pass_a_mesh() {
    check("balls onto a mesh", |lab, _| {
        let corner = |y: f32, z: f32| Vec3::new(0.0, y, z);
        let corners = vec![
            corner(-2.0, -2.0),
            corner(2.0, -2.0),
            corner(2.0, 2.0),
            corner(-2.0, 2.0),
        ];
        let mesh = Collider::trimesh(corners, vec![[0, 2, 1], [0, 3, 2]]).unwrap();
        lab.spawn((RigidBody::Static, mesh));
        lab.body(Collider::ball(0.05), Vec3::ZERO)
    });
}

#[test]
fn bodies_do_not_pass_bodies() {
    check("balls onto a heavy plate that is free", |lab, _| {
        let plate = lab.body(Collider::cuboid(THICK, 4.0, 4.0), Vec3::ZERO);
        lab.world.entity_mut(plate).insert(Mass(1e4));
        let ball = lab.body(Collider::ball(0.05), Vec3::ZERO);
        lab.world.entity_mut(ball).insert(Mass(1.0));
        ball
    });
}

/// The boxes of fast bodies overlap far around them, but only bodies that may touch within a step need a pair.
#[test]
fn bodies_that_fly_beside_each_other_have_no_pair_until_one_turns_to_the_other() {
    let mut lab = lab(1.0 / 60.0);
    let cube = Collider::cuboid(0.5, 0.5, 0.5);
    let [a, b] = [-0.5, 0.5].map(|x| lab.body(cube.clone(), Vec3::X * x));
    let pairs = |lab: &mut Lab| lab.world.query::<&ContactPair>().iter(&lab.world).count();
    for body in [a, b] {
        lab.set_velocity(body, Vec3::NEG_Y * 20.0, Vec3::ZERO);
    }
    for _ in 0..10 {
        lab.step();
        assert_eq!(pairs(&mut lab), 0);
    }
    lab.set_velocity(a, Vec3::new(20.0, -20.0, 0.0), Vec3::ZERO);
    let mut met = false;
    for _ in 0..10 {
        lab.step();
        met |= pairs(&mut lab) == 1;
        let gap = lab.position(b).x - lab.position(a).x - 0.5;
        assert!(gap > -0.005, "the cubes overlap by {} m", -gap);
    }
    assert!(met);
    let [one, other] = [a, b].map(|body| lab.velocity(body).linear.x);
    assert!(
        (one - 10.0).abs() < 0.1 && (other - 10.0).abs() < 0.1,
        "{one} {other}"
    );
}
