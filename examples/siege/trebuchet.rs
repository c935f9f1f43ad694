//! The trebuchet: a beam on a hinge, a counterweight, and a sling that opens by itself. A winch pulls the beam back between two shots.

use crate::game::{Clock, Layer, Tally};
use bevy_ecs::prelude::*;
use bevy_reflect::Reflect;
use bevy_transform::components::Transform;
use drystone::prelude::*;

/// The hinge of the beam.
#[derive(Component, Clone, Copy, Debug, Default, Reflect)]
#[reflect(Component)]
pub struct Winch;

/// The beam.
#[derive(Component, Clone, Copy, Debug, Default, Reflect)]
#[reflect(Component)]
pub struct Beam;

/// The rope between the beam and a stone.
#[derive(Component, Clone, Copy, Debug, Default, Reflect)]
#[reflect(Component)]
pub struct Sling;

/// A stone, and when it was thrown, s.
#[derive(Component, Clone, Copy, Debug, Default, Reflect)]
#[reflect(Component)]
pub struct Stone {
    pub thrown: f32,
}

/// The hinge of the beam, m.
const HINGE: Vec3 = Vec3::new(3.2, 4.0, -24.0);
/// Lengths of its long and its short arm, m.
const LONG: f32 = 4.5;
const SHORT: f32 = 1.5;
/// Length of the sling, m.
const SLING: f32 = 2.8;
/// Time between two shots, and from a shot to the next pull of the winch, s.
const PERIOD: f32 = 20.0;
const SWINGS: f32 = 8.0;
/// Torque of the winch, N·m.
const TORQUE: f32 = 120_000.0;
/// How long a stone lies about, s.
const LIES: f32 = 30.0;

fn layers() -> CollisionLayers {
    CollisionLayers::new(Layer::Things, LayerMask::ALL)
}

pub fn build(world: &mut World) {
    let at = HINGE - Vec3::Z * (0.5 * (LONG - SHORT));
    let beam = (
        RigidBody::Dynamic,
        Collider::cuboid(0.2, 0.2, LONG + SHORT),
        Mass(80.0),
        layers(),
    );
    let beam = world
        .spawn((beam, Transform::from_translation(at), Beam))
        .id();
    let hinge = RevoluteJoint::new(None, beam)
        .with_anchor(HINGE)
        .with_hinge_axis(Vec3::X);
    world.spawn((hinge.with_motor(JointMotor::servo(0.0, TORQUE)), Winch));
    let hung = HINGE + Vec3::Z * (SHORT - 0.1);
    let weight = (
        RigidBody::Dynamic,
        Collider::cuboid(0.8, 0.8, 0.8),
        Mass(4000.0),
        layers(),
    );
    let weight = world
        .spawn((weight, Transform::from_translation(hung - Vec3::Y * 0.6)))
        .id();
    world.spawn(
        RevoluteJoint::new(beam, weight)
            .with_anchor(hung)
            .with_hinge_axis(Vec3::X),
    );
}

pub fn step(world: &mut World, clock: Clock) {
    if clock.strikes(5.0, PERIOD) {
        shoot(world, clock);
    }
    if clock.strikes(5.0 + SWINGS, PERIOD) {
        set_motor(world, Some(JointMotor::servo(0.0, TORQUE)));
    }
    open_sling(world);
    clear(world, clock);
}

fn set_motor(world: &mut World, motor: Option<JointMotor>) {
    let mut winches = world.query_filtered::<&mut RevoluteJoint, With<Winch>>();
    for mut winch in winches.iter_mut(world) {
        winch.motor = motor;
    }
}

fn shoot(world: &mut World, clock: Clock) {
    let mut beams = world.query_filtered::<(Entity, &Pose), With<Beam>>();
    let Ok((beam, pose)) = beams.single(world) else {
        return;
    };
    let tip = Vec3::NEG_Z * (0.5 * (LONG + SHORT));
    let at = pose.transform_point(tip) + Vec3::new(0.0, -0.72 * SLING, 0.7 * SLING);
    let stone = (
        RigidBody::Dynamic,
        Collider::ball(0.25),
        Mass(80.0),
        Damping {
            linear: 0.0,
            angular: 2.0,
        },
        layers(),
    );
    let thrown = clock.seconds();
    let stone = world
        .spawn((stone, Transform::from_translation(at), Stone { thrown }))
        .id();
    let sling = DistanceJoint::new(beam, stone)
        .with_local_anchor1(tip)
        .with_local_anchor2(Vec3::ZERO)
        .with_max_distance(SLING);
    world.spawn((sling, Sling));
    set_motor(world, None);
    world.resource_mut::<Tally>().shots += 1;
}

/// The sling opens when the stone flies down towards the castle.
fn open_sling(world: &mut World) {
    let mut slings = world.query_filtered::<(Entity, &DistanceJoint), With<Sling>>();
    let mut opened = Vec::new();
    for (sling, joint) in slings.iter(world) {
        let stone = joint.body2.and_then(|stone| world.get::<Velocity>(stone));
        let Some(Velocity { linear, .. }) = stone else {
            continue;
        };
        if linear.z > 8.0 && linear.y < -0.12 * linear.z {
            opened.push(sling);
        }
    }
    opened
        .into_iter()
        .for_each(|sling| _ = world.despawn(sling));
}

/// Notes how far the stones came, and takes old ones away.
fn clear(world: &mut World, clock: Clock) {
    let mut stones = world.query::<(Entity, &Stone, &Transform)>();
    let mut farthest = 0.0f32;
    let mut old = Vec::new();
    for (entity, stone, at) in stones.iter(world) {
        farthest = farthest.max(at.translation.z - HINGE.z);
        if clock.seconds() - stone.thrown > LIES {
            old.push(entity);
        }
    }
    let mut tally = world.resource_mut::<Tally>();
    tally.range = tally.range.max(farthest);
    old.into_iter().for_each(|stone| _ = world.despawn(stone));
}
