//! A chain that hangs between two points.

use super::{Settings, Values};
use crate::Lab;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::body::{Damping, Mass, RigidBody};
use drystone::collider::Collider;
use drystone::joint::{JointForces, SphericalJoint};
use glam::{Quat, Vec3};

/// Distance of the two ends, and length of the chain, m.
const SPAN: f32 = 8.0;
const LENGTH: f32 = 10.0;

/// Mass of the chain, kg.
const MASS: f32 = 40.0;

/// The parameter of the catenary, a with L = 2 a sinh(S/2a), m.
fn parameter() -> f64 {
    let length = |a: f64| 2.0 * a * (0.5 * SPAN as f64 / a).sinh();
    let (mut low, mut high) = (1.0, 100.0);
    for _ in 0..60 {
        let middle: f64 = 0.5 * (low + high);
        // A flatter one is shorter.
        match length(middle) > LENGTH as f64 {
            true => low = middle,
            false => high = middle,
        }
    }
    0.5 * (low + high)
}

/// A chain of rods that starts as a V, and is damped.
fn hang(lab: &mut Lab, links: usize) -> (Vec<Entity>, Entity) {
    let rod = LENGTH / links as f32;
    let depth = (0.25 * (LENGTH * LENGTH - SPAN * SPAN)).sqrt();
    let [left, middle, right] = [
        Vec3::X * -0.5 * SPAN,
        Vec3::NEG_Y * depth,
        Vec3::X * 0.5 * SPAN,
    ];
    let joint_at = |i: usize| {
        let share = 2.0 * i as f32 / links as f32;
        match share <= 1.0 {
            true => left.lerp(middle, share),
            false => middle.lerp(right, share - 1.0),
        }
    };
    let mut last = None;
    let mut first = None;
    let mut bodies = Vec::new();
    for i in 0..links {
        let (from, to) = (joint_at(i), joint_at(i + 1));
        let turn = Quat::from_rotation_arc(Vec3::Y, (to - from).normalize());
        let body = lab.spawn((
            (
                RigidBody::Dynamic,
                Collider::capsule(0.02, 0.5 * rod),
                Mass(MASS / links as f32),
            ),
            Damping {
                linear: 1.0,
                angular: 1.0,
            },
            Transform::from_translation(from.midpoint(to)).with_rotation(turn),
        ));
        let joint = SphericalJoint::new(last, body).with_anchor(from);
        let joint = lab.spawn(joint);
        first.get_or_insert(joint);
        last = Some(body);
        bodies.push(body);
    }
    lab.spawn(SphericalJoint::new(None, last).with_anchor(right));
    (bodies, first.expect("it has links"))
}

/// A chain of 8, 16 and 32 rods: the depth of its middle, and the pull at an end along the span over a second, against the catenary. A
/// polygon of rods of length l differs from the curve by a share of the order of (l/L)²; the chain may be off by 0.5 % and that.
pub fn chain_hangs(settings: Settings, dt: f32) -> Values {
    let mut values = Values::at(dt);
    let a = parameter();
    let depth = (a * ((0.5 * SPAN as f64 / a).cosh() - 1.0)) as f32;
    let pull = MASS * crate::G * a as f32 / LENGTH;
    for links in [8, 16, 32] {
        let mut lab = settings(dt);
        let (bodies, first) = hang(&mut lab, links);
        lab.run(15.0);
        // Damping is applied implicitly: it lessens gravity too, by 1/(1 + c Δt).
        for &body in &bodies {
            lab.world.entity_mut(body).insert(Damping::default());
        }
        let mut force = 0.0;
        let steps = (1.0 / dt).round() as usize;
        for _ in 0..steps {
            lab.step();
            force += lab
                .world
                .get::<JointForces>(first)
                .map_or(f32::NAN, |f| f.force.x.abs());
        }
        force /= steps as f32;
        // The joint in the middle is half a rod before the next rod's centre.
        let next = lab.pose(bodies[links / 2]);
        let half = 0.5 * LENGTH / links as f32;
        let middle = next.transform_point(Vec3::NEG_Y * half);
        let share = 0.005 + 1.0 / (links * links) as f32;
        let what = format!("catenary: chain of {links} rods, depth, m");
        values.add_near(what, (-middle.y, depth), share);
        let what = format!("catenary: chain of {links} rods, pull along the span, N");
        values.add_near(what, (force, pull), share);
    }
    values
}
