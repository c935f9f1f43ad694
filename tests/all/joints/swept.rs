//! Joints that are relaxed in sweeps: nets and ragdolls.

use super::scenes::joints_apart;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::prelude::*;
use drystone::solver::SoftStep;
use drystone_lab::metrics;
use drystone_lab::scenes::{Scene, SceneOptions};
use support::{G, Lab, assert_near};

/// The radius of the balls of a net, m, and their distance.
const RADIUS: f32 = 0.4;
const STEP: f32 = 1.0;

/// A net of balls on ball joints, column by column, that hangs from those balls of its first row of which `is_fixed` is true.
fn net(lab: &mut Lab, size: usize, is_fixed: impl Fn(usize) -> bool) -> Vec<Entity> {
    let mut balls: Vec<Entity> = Vec::new();
    let mut joints = Vec::new();
    for column in 0..size {
        for row in 0..size {
            let at = Vec3::new(column as f32 * STEP, -(row as f32) * STEP, 0.0);
            let kind = match row == 0 && is_fixed(column) {
                true => RigidBody::Static,
                false => RigidBody::Dynamic,
            };
            let ball = (
                kind,
                Collider::ball(RADIUS),
                Transform::from_translation(at),
            );
            let ball = lab.world.spawn(ball).id();
            let mut join = |other: Entity, anchor: Vec3| {
                let joint = SphericalJoint::new(other, ball).with_anchor(anchor);
                joints.push((lab.world.spawn(joint).id(), row));
            };
            if row > 0 {
                join(balls[balls.len() - 1], at + Vec3::Y * (0.5 * STEP));
            }
            if column > 0 {
                join(balls[balls.len() - size], at - Vec3::X * (0.5 * STEP));
            }
            balls.push(ball);
        }
    }
    balls
}

/// The largest change of the distance of two neighbours that hang straight, m.
fn stretch(lab: &Lab, balls: &[Entity], size: usize) -> f32 {
    let place = |ball: Entity| lab.world.get::<Transform>(ball).unwrap().translation;
    let columns = balls.chunks(size);
    let pairs = columns.flat_map(|column| column.windows(2));
    pairs
        .map(|pair| (place(pair[0]).distance(place(pair[1])) - STEP).abs())
        .fold(0.0, f32::max)
}

#[test]
fn a_net_hangs_still_and_bears_its_weight() {
    let size = 12;
    let mut lab = Lab::shipped(1.0 / 60.0);
    let balls = net(&mut lab, size, |_| true);
    let mut widest = 0.0f32;
    for _ in 0..60 * 6 {
        lab.step();
        widest = widest.max(stretch(&lab, &balls, size));
    }
    assert!(widest < 1e-3, "{widest}");
    assert!(stretch(&lab, &balls, size) < 1e-4);
    let fastest = balls.iter().map(|&ball| lab.velocity(ball).linear.length());
    let fastest = fastest.fold(0.0, f32::max);
    assert!(fastest < 1e-3, "{fastest}");
    // The joints under the first row bear all balls below it.
    let mass = lab.world.get::<MassProperties>(balls[1]).unwrap().mass();
    let weight = mass * G * (size * (size - 1)) as f32;
    let mut joints = lab.world.query::<(&SphericalJoint, &JointForces)>();
    let hung = joints.iter(&lab.world).filter(|(joint, _)| {
        let own = balls.iter().position(|&ball| Some(ball) == joint.body2);
        let other = balls.iter().position(|&ball| Some(ball) == joint.body1);
        own.is_some_and(|own| own % size == 1) && other.is_some_and(|other| other % size == 0)
    });
    let borne: f32 = hung.map(|(_, forces)| forces.force.y).sum();
    assert_near(borne, weight, 0.01, "weight");
}

/// A net that swings by a corner gains no energy, and loses little.
#[test]
fn a_net_that_swings_keeps_its_energy() {
    for dt in [1.0 / 60.0, 1.0 / 120.0] {
        let size = 12;
        let mut lab = Lab::shipped(dt);
        let balls = net(&mut lab, size, |column| column == 0);
        lab.step();
        let start = metrics::energy(&mut lab.world);
        let mass = lab.world.get::<MassProperties>(balls[1]).unwrap().mass();
        // What it would lose if it came to rest, hanging by its corner.
        let scale = (mass * G * 0.5 * (size * size * size) as f32) as f64;
        let (mut most, mut widest) = (0.0f64, 0.0f32);
        for _ in 0..(4.0 / dt) as usize {
            lab.step();
            most = most.max(metrics::energy(&mut lab.world) - start);
            widest = widest.max(joints_apart(&mut lab));
        }
        let left = metrics::energy(&mut lab.world) - start;
        println!("{dt}: {} {} {widest}", most / scale, left / scale);
        assert!(most < 0.02 * scale, "{dt}: {}", most / scale);
        assert!(left > -0.3 * scale, "{dt}: {}", left / scale);
        assert!(widest < 0.1, "{dt}: {widest}");
    }
}

fn ragdoll(lab: &mut Lab, sweeps_joints: bool) -> Vec<Entity> {
    lab.world.resource_mut::<SolverSettings>().solver = SoftStep {
        sweeps_joints,
        ..Default::default()
    }
    .into();
    let scene: Scene = "ragdolls:1".parse().unwrap();
    scene.build(&mut lab.world, &SceneOptions::default()).bodies
}

/// The momentum of bodies, and their angular momentum about the origin.
fn momenta(lab: &Lab, bodies: &[Entity]) -> [Vec3; 2] {
    let mut sums = [Vec3::ZERO; 2];
    for &body in bodies {
        let mass = lab.world.get::<MassProperties>(body).unwrap();
        let pose = lab.world.get::<Pose>(body).unwrap();
        let velocity = lab.velocity(body);
        let push = mass.mass() * velocity.linear;
        sums[0] += push;
        sums[1] += pose.transform_point(mass.local_center).cross(push)
            + mass.world_inverse_inertia(pose.rotation).inverse() * velocity.angular;
    }
    sums
}

/// A ragdoll that tumbles without gravity keeps its momentum and, nearly, its angular momentum.
#[test]
fn a_ragdoll_in_flight_keeps_its_momentum() {
    for sweeps_joints in [false, true] {
        let mut lab = Lab::shipped(1.0 / 60.0);
        lab.world.insert_resource(Gravity(Vec3::ZERO));
        let bodies = ragdoll(&mut lab, sweeps_joints);
        let spin = Vec3::new(2.0, 1.0, -3.0);
        for (number, &body) in bodies.iter().enumerate() {
            let at = lab.world.get::<Transform>(body).unwrap().translation;
            // Limbs also turn against each other.
            let own = Vec3::new(0.0, 0.0, if number % 2 == 0 { 1.0 } else { -1.0 });
            lab.world.entity_mut(body).insert(Velocity {
                linear: spin.cross(at - Vec3::Y * 3.0),
                angular: spin + own,
            });
        }
        lab.step();
        let [push, turn] = momenta(&lab, &bodies);
        for _ in 0..120 {
            lab.step();
        }
        let [later, turned] = momenta(&lab, &bodies);
        println!("{sweeps_joints}: {} {}", later - push, turned - turn);
        assert!((later - push).length() < 1e-3 * push.length().max(10.0));
        assert!((turned - turn).length() < 0.002 * turn.length());
    }
}

/// Knees and elbows bend one way only, swept or not.
#[test]
fn limits_of_swept_joints_hold() {
    let mut lab = Lab::shipped(1.0 / 60.0);
    let _ = ragdoll(&mut lab, true);
    let mut worst = 0.0f32;
    for _ in 0..180 {
        lab.step();
        let mut hinges = lab.world.query::<(&RevoluteJoint, &JointForces)>();
        for (hinge, forces) in hinges.iter(&lab.world) {
            let (Some(limits), Some(angle)) = (hinge.limits, forces.angle()) else {
                continue;
            };
            worst = worst.max(angle - limits.max).max(limits.min - angle);
        }
    }
    assert!(worst < 0.15, "{worst}");
}
