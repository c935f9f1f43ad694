//! Settling: where bodies fall asleep, a tall structure that was hit stops swaying, and nothing else is slowed down.

use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::body::{RigidBody, Sleeping, Velocity};
use drystone::collider::{Collider, CombineRule, Friction, RollingFriction};
use drystone::joint::DistanceJoint;
use drystone::settings::{Gravity, Preset, SleepSettings};
use drystone_lab::experiment::{Experiment, Run};
use glam::Vec3;
use support::Lab;

/// Lets a wall of 25 courses sway across for four seconds, from a speed that grows with the height up to 4 cm/s. Returns whether all of it
/// sleeps then, and how far the top has moved, m.
fn sway(settling: f32) -> (bool, f32) {
    let mut experiment = Experiment::new("wall:6x25".parse().expect("a scene"), Preset::Default);
    experiment.sleeping.settling = settling;
    let mut run = experiment.start();
    let place = |run: &Run, body| run.world.get::<Transform>(body).unwrap().translation;
    let before: Vec<Vec3> = run.bodies.iter().map(|&body| place(&run, body)).collect();
    for (&body, at) in run.bodies.iter().zip(&before) {
        let mut velocity = run.world.get_mut::<Velocity>(body).unwrap();
        velocity.linear.z = 0.04 * at.y / 12.5;
    }
    for _ in 0..240 {
        run.step();
    }
    let sleeps = |&body: &Entity| run.world.get::<Sleeping>(body).unwrap().asleep;
    let moved = run.bodies.iter().zip(&before);
    let moved = moved.map(|(&body, at)| (place(&run, body) - at).length());
    (run.bodies.iter().all(sleeps), moved.fold(0.0, f32::max))
}

#[test]
fn a_wall_that_was_hit_stops_swaying_and_sleeps() {
    let (sleeps, moved) = sway(1.0);
    assert!(sleeps && moved < 0.01, "moved {moved} m");
    let (sleeps, moved) = sway(0.0);
    assert!(!sleeps && moved > 0.03, "moved {moved} m");
}

/// The bits of a scene after two seconds with this rate of settling.
fn bits(settling: f32, scene: fn(&mut Lab)) -> Vec<[u32; 13]> {
    let mut lab = Lab::new();
    lab.world.resource_mut::<SleepSettings>().settling = settling;
    scene(&mut lab);
    lab.run(2.0);
    lab.bits()
}

fn is_slowed(scene: fn(&mut Lab)) -> bool {
    bits(1.0, scene) != bits(0.0, scene)
}

/// A tower of twelve cubes, all but the lowest of which move at first, up to 5 cm/s.
fn tower(lab: &mut Lab) -> Vec<Entity> {
    let cubes = (0..12).map(|i| lab.cube(Vec3::Y * (i as f32 + 0.5)));
    let cubes: Vec<Entity> = cubes.collect();
    for (i, &cube) in cubes.iter().enumerate() {
        lab.set_velocity(cube, Vec3::X * 0.05 * i as f32 / 11.0, Vec3::ZERO);
    }
    cubes
}

#[test]
fn a_tall_tower_that_was_hit_is_slowed() {
    assert!(is_slowed(|lab| {
        lab.ground();
        tower(lab);
    }));
}

#[test]
fn a_tower_on_ice_is_not_slowed() {
    assert!(!is_slowed(|lab| {
        let ice = lab.ground();
        let cubes = tower(lab);
        for smooth in [ice, cubes[0]] {
            lab.world.entity_mut(smooth).insert(Friction::new(0.0));
        }
        for cube in cubes {
            lab.set_velocity(cube, Vec3::X * 0.05, Vec3::ZERO);
        }
    }));
}

#[test]
fn a_ball_that_rolls_on_a_tower_is_not_slowed() {
    let mut lab = Lab::new();
    lab.ground();
    for cube in tower(&mut lab) {
        lab.set_velocity(cube, Vec3::ZERO, Vec3::ZERO);
    }
    let ball = lab.body(Collider::ball(0.25), Vec3::Y * 12.25);
    let smooth = RollingFriction::new(0.0).with_rule(CombineRule::Min);
    lab.world.entity_mut(ball).insert(smooth);
    lab.set_velocity(ball, Vec3::X * 0.05, Vec3::Z * -0.2);
    lab.run(2.0);
    let speed = lab.velocity(ball).linear.x;
    assert!((speed - 0.05).abs() < 1e-3, "{speed} m/s");
}

#[test]
fn a_tower_on_a_moving_platform_is_not_slowed() {
    assert!(!is_slowed(|lab| {
        lab.spawn((
            RigidBody::Kinematic,
            Collider::cuboid(4.0, 1.0, 4.0),
            Transform::from_xyz(0.0, -0.5, 0.0),
            Velocity::linear(Vec3::X * 0.04),
        ));
        tower(lab);
    }));
}

#[test]
fn a_tower_without_ground_is_not_slowed() {
    assert!(!is_slowed(|lab| {
        lab.world.insert_resource(Gravity(Vec3::ZERO));
        tower(lab);
    }));
}

#[test]
fn a_tower_with_a_joint_is_not_slowed() {
    assert!(!is_slowed(|lab| {
        lab.ground();
        let cubes = tower(lab);
        let rope = DistanceJoint::new(cubes[10], cubes[11]).with_max_distance(3.0);
        lab.spawn(rope);
    }));
}

#[test]
fn a_low_tower_is_not_slowed() {
    assert!(!is_slowed(|lab| {
        lab.ground();
        let top = tower(lab)[11];
        lab.world.despawn(top);
    }));
}

#[test]
fn without_sleeping_nothing_is_slowed() {
    assert!(!is_slowed(|lab| {
        lab.world.resource_mut::<SleepSettings>().enabled = false;
        lab.ground();
        tower(lab);
    }));
}

/// The time after which a leaning tower of 24 bricks, of which 22 would stand, has fallen by half a metre, s.
fn topples_after(settling: f32) -> f32 {
    let mut lab = Lab::new();
    lab.world.resource_mut::<SleepSettings>().settling = settling;
    lab.ground();
    let bricks = (0..24).map(|i| {
        let at = Vec3::new(0.045 * i as f32, 0.25 + 0.5 * i as f32, 0.0);
        lab.body(Collider::cuboid(1.0, 0.5, 0.5), at)
    });
    let top = bricks.last().expect("there are some");
    let steps = (0..1200).take_while(|_| {
        lab.step();
        lab.position(top).y > 11.25
    });
    steps.count() as f32 * lab.dt
}

#[test]
fn a_tower_that_topples_is_hardly_slowed() {
    let [without, with] = [0.0, 1.0].map(topples_after);
    println!("{without} s without, {with} s with");
    assert!(
        with < 20.0 && (with / without - 1.0).abs() < 0.1,
        "{without} s, {with} s"
    );
}
