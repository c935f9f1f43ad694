//! Heavy traffic on arches: a sled is drawn over the crown. What limit analysis lets stand stands, and what it does not falls
//! (`docs/arches.md`).

use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::body::{Mass, RigidBody, Velocity};
use drystone::collider::{Collider, CombineRule, Friction};
use drystone::grab::Grab;
use drystone::masonry::Arch;
use drystone::stability::{Trial, stability};
use glam::{BVec3, Quat, Vec2, Vec3};
use std::f32::consts::PI;
use support::*;

/// Along the arch, up and across, m.
const SLED: Vec3 = Vec3::new(0.4, 0.3, 0.8);

const VOUSSOIRS: u32 = 15;

/// It is drawn from −1.2 to 1.2 m.
const WAY: f32 = 1.2;

/// Inner and outer, m.
const RADII: [[f32; 2]; 3] = [[2.7, 3.3], [2.6, 3.4], [2.4, 3.6]];

fn arch([inner, outer]: [f32; 2], dt: f32) -> (Lab, Vec<Entity>) {
    let mut lab = Lab::shipped(dt);
    lab.ground();
    let arch = Arch {
        radius: 0.5 * (inner + outer),
        thickness: outer - inner,
        voussoirs: VOUSSOIRS,
        ..Default::default()
    };
    let blocks = arch.blocks().unwrap().into_iter();
    let bodies = blocks.map(|block| lab.spawn(block.bundle())).collect();
    (lab, bodies)
}

/// The corners of the extrados, from right to left.
fn corners(outer: f32) -> Vec<Vec2> {
    let angle = |i| PI * i as f32 / VOUSSOIRS as f32;
    (0..=VOUSSOIRS)
        .map(|i| outer * Vec2::from_angle(angle(i)))
        .collect()
}

/// The places at which the sled may press: its centre, the voussoir, the point and the normal. Nothing holds it upright and it has no
/// friction, so its force goes through its centre. It lies flat on a face, or over a ridge at any angle between the two faces.
fn rests(outer: f32) -> Vec<(Vec2, usize, Vec2, Vec2)> {
    let corners = corners(outer);
    let normal = |i: usize| (corners[i] - corners[i + 1]).perp().normalize();
    let mut rests = Vec::new();
    let mut rest = |voussoir: usize, point: Vec2, normal: Vec2| {
        let middle = point + 0.5 * SLED.y * normal;
        if middle.x.abs() <= WAY {
            rests.push((middle, voussoir, point, normal));
        }
    };
    for i in 0..VOUSSOIRS as usize {
        for share in 0..=8 {
            let point = corners[i].lerp(corners[i + 1], share as f32 / 8.0);
            rest(i, point, normal(i));
        }
        if i + 1 < VOUSSOIRS as usize {
            for share in 1..4 {
                let turned = normal(i).lerp(normal(i + 1), share as f32 / 4.0);
                for voussoir in [i, i + 1] {
                    rest(voussoir, corners[i + 1], turned.normalize());
                }
            }
        }
    }
    rests
}

/// The heaviest sled that the arch bears at every place, kg, and its centre at the worst place. The pulling force balances the horizontal
/// component, so the sled presses with m g / cos θ along the normal.
fn bears(radii: [f32; 2], along: impl Fn(Vec2) -> Vec2) -> (f32, f32) {
    let (mut lab, bodies) = arch(radii, 1.0 / 60.0);
    lab.step();
    let mass = |(middle, voussoir, point, normal): (Vec2, usize, Vec2, Vec2)| {
        let direction = along(normal);
        let trial = Trial::Pull {
            body: bodies[voussoir],
            point: point.extend(0.0),
            direction: -direction.extend(0.0),
        };
        let most = stability(&lab.world, &bodies, &trial).unwrap().limit;
        (most * direction.y / G, middle.x)
    };
    let masses = rests(radii[1]).into_iter().map(mass);
    masses.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap()
}

/// How the sled is drawn.
#[derive(Clone, Copy, Debug)]
enum Drawn {
    /// Its velocity along x is set before each step.
    Set,
    /// And it is kept level: its angular velocity is set to zero.
    SetLevel,
    /// By a [`Grab`] along x, as strong as it takes, that lets it turn.
    Hand,
    /// By one that keeps it level.
    HandLevel,
}

const ALL: [Drawn; 4] = [Drawn::Set, Drawn::SetLevel, Drawn::Hand, Drawn::HandLevel];

/// The largest displacement of a voussoir at the end, m, at most 1 m.
fn goes(radii: [f32; 2], mass: f32, drawn: Drawn, speed: f32, rate: f32) -> f32 {
    let (mut lab, bodies) = arch(radii, 1.0 / rate);
    let level = matches!(drawn, Drawn::SetLevel | Drawn::HandLevel);
    // Flat on its face, or level on its front edge.
    let corners = corners(radii[1]);
    let face = |x: f32| {
        let left = corners.iter().position(|corner| corner.x < x).unwrap();
        let slope = corners[left - 1] - corners[left];
        (corners[left], slope.y / slope.x)
    };
    let height = |x: f32, (corner, slope): (Vec2, f32)| corner.y + slope * (x - corner.x);
    let (height, turn) = match level {
        true => {
            let front = 0.5 * SLED.x - WAY;
            (height(front, face(front)) + 0.5 * SLED.y, 0.0)
        }
        false => {
            let (sin, cos) = face(-WAY).1.atan().sin_cos();
            let foot = -WAY + 0.5 * SLED.y * sin;
            (
                height(foot, face(-WAY)) + 0.5 * SLED.y * cos,
                face(-WAY).1.atan(),
            )
        }
    };
    let sled = lab.spawn((
        RigidBody::Dynamic,
        Collider::cuboid(SLED.x, SLED.y, SLED.z),
        Mass(mass),
        // The average with the arch's would be half as rough as that.
        Friction::new(0.0).with_rule(CombineRule::Min),
        Transform::from_xyz(-WAY, height, 0.0).with_rotation(Quat::from_rotation_z(turn)),
    ));
    let begin: Vec<Vec3> = bodies.iter().map(|&body| lab.position(body)).collect();
    let far = |lab: &Lab| {
        let far = bodies.iter().zip(&begin);
        let far = far.map(|(&body, at)| lab.position(body).distance(*at));
        far.fold(0.0, f32::max)
    };
    // A second at rest, half a second in which it gathers speed, and a second at rest at the end.
    let mut target = -WAY;
    for step in 0..((2.5 + 2.0 * WAY / speed) * rate) as usize {
        let now = step as f32 / rate;
        let speed = match target < WAY {
            true => speed * ((now - 1.0) / 0.5).clamp(0.0, 1.0),
            false => 0.0,
        };
        target += speed / rate;
        match drawn {
            Drawn::Set | Drawn::SetLevel => {
                let mut velocity = lab.world.get_mut::<Velocity>(sled).unwrap();
                velocity.linear.x = speed;
                if level {
                    velocity.angular = Vec3::ZERO;
                }
            }
            Drawn::Hand | Drawn::HandLevel => {
                let grab = Grab {
                    target: Vec3::X * target,
                    local_point: Vec3::ZERO,
                    axes: BVec3::new(true, false, false),
                    turn_axes: if level { BVec3::TRUE } else { BVec3::FALSE },
                    rotation: level.then_some(Quat::IDENTITY),
                    response: 0.0,
                    max_speed: f32::INFINITY,
                    max_force: f32::INFINITY,
                    max_torque: f32::INFINITY,
                };
                lab.world.entity_mut(sled).insert(grab);
            }
        }
        lab.step();
        if far(&lab) > 1.0 {
            break;
        }
    }
    far(&lab)
}

/// An arch that bears a sled of 1.5 or 2 times this weight also bears this sled, however it is pulled.
#[test]
fn an_arch_bears_the_sled_that_statics_lets_it_bear() {
    let load = 1000.0;
    for radii in [[2.6, 3.4], [2.4, 3.6]] {
        let (most, at) = bears(radii, |normal| normal);
        println!("{radii:?} bears {most} kg, the least at {at} m");
        assert!(most > 1.4 * load, "{most} kg");
        for drawn in ALL {
            for (speed, rate) in [(0.5, 60.0), (0.5, 240.0), (0.1, 60.0)] {
                let far = goes(radii, load, drawn, speed, rate);
                println!("{drawn:?} at {speed} m/s, {rate} Hz: {far} m");
                assert!(far < 0.01, "{radii:?}, {drawn:?} at {speed} m/s: {far} m");
            }
        }
    }
}

/// Slowly, so that there is hardly a blow.
#[test]
fn an_arch_bears_a_slow_sled_near_the_limit() {
    let radii = [2.4, 3.6];
    let (most, _) = bears(radii, |normal| normal);
    assert!((2200.0..2500.0).contains(&most), "{most} kg");
    for drawn in [Drawn::Hand, Drawn::HandLevel] {
        let far = goes(radii, 2000.0, drawn, 0.1, 60.0);
        println!("{drawn:?}: {far} m");
        assert!(far < 0.01, "{drawn:?}: {far} m");
    }
}

#[test]
fn an_arch_falls_under_the_sled_that_statics_does_not_let_it_bear() {
    for (radii, load) in [
        ([2.7, 3.3], 2000.0),
        ([2.6, 3.4], 2000.0),
        ([2.4, 3.6], 3000.0),
    ] {
        let (most, _) = bears(radii, |normal| normal);
        assert!(most < 0.8 * load, "{most} kg");
        for drawn in ALL {
            for rate in [60.0, 240.0] {
                let far = goes(radii, load, drawn, 0.5, rate);
                assert!(
                    far > 0.25,
                    "{radii:?}, {load} kg, {drawn:?}, {rate} Hz: {far} m"
                );
            }
        }
    }
}

/// The table of `docs/arches.md`.
#[test]
#[ignore = "long"]
fn arches_under_traffic_stand_or_fall() {
    for radii in RADII {
        let (most, at) = bears(radii, |normal| normal);
        let (upright, above) = bears(radii, |_| Vec2::Y);
        println!(
            "{radii:?}: bears {most} kg, least at {at} m; straight down {upright} kg, at {above} m"
        );
        for load in [1000.0, 2000.0, 3000.0] {
            for drawn in ALL {
                for speed in [0.5, 0.1] {
                    let far =
                        [60.0, 240.0, 960.0].map(|rate| goes(radii, load, drawn, speed, rate));
                    let far = far.map(|far| match far > 0.25 {
                        true => "falls".into(),
                        false => format!("{:.1} mm", 1e3 * far),
                    });
                    println!("  {load} kg, {drawn:?}, {speed} m/s: {}", far.join(", "));
                }
            }
        }
    }
}
