//! Raiders: upright capsules that run for the yard in waves, and the zone that captures them.

use crate::game::{Clock, Layer, Tally};
use bevy_ecs::prelude::*;
use bevy_reflect::Reflect;
use bevy_transform::components::Transform;
use drystone::prelude::*;

/// A raider.
#[derive(Component, Clone, Copy, Debug, Default, Reflect)]
#[reflect(Component)]
#[require(ExternalForce)]
pub struct Raider;

/// The zone in the yard.
#[derive(Component, Clone, Copy, Debug, Default, Reflect)]
#[reflect(Component)]
pub struct Yard;

/// Where they run to, and how fast, m/s.
const GOAL: Vec3 = Vec3::new(0.0, 0.0, 3.0);
const SPEED: f32 = 2.5;
const MASS: f32 = 80.0;
/// Largest force of a raider, N: enough to climb the edge of the bridge.
const STRENGTH: f32 = 1_600.0;
/// Half the distance of the files in which they run, m.
const FILE: f32 = 0.45;
/// Raiders of a wave, and time between two waves, s. A raider gives up after two.
const WAVE: i32 = 6;
const PERIOD: f32 = 30.0;

pub fn build(world: &mut World) {
    world.spawn((
        Collider::cuboid(9.0, 3.0, 6.0),
        Sensor,
        // It looks for raiders only.
        CollisionLayers::new(LayerMask::ALL, Layer::Raiders),
        Transform::from_xyz(0.0, 1.5, 4.5),
        Yard,
    ));
}

pub fn step(world: &mut World, clock: Clock) {
    capture(world);
    if clock.strikes(2.0, PERIOD) {
        let mut raiders = world.query_filtered::<Entity, With<Raider>>();
        let known: Vec<Entity> = raiders.iter(world).collect();
        if known.len() >= 2 * WAVE as usize {
            known
                .into_iter()
                .for_each(|raider| _ = world.despawn(raider));
        }
        for i in 0..WAVE {
            // In two files.
            let (x, z) = (FILE * (2 * (i % 2) - 1) as f32, -12.0 - (i / 2) as f32);
            world.spawn((
                RigidBody::Dynamic,
                Collider::capsule(0.3, 1.0),
                Mass(MASS),
                LockedAxes::ROTATION_LOCKED,
                CollisionLayers::new(Layer::Raiders, LayerMask::ALL),
                Friction::new(0.2),
                Transform::from_xyz(x, 0.8, z),
                Raider,
            ));
        }
        world.resource_mut::<Tally>().raiders += WAVE as u32;
    }
    let mut raiders =
        world.query_filtered::<(&Transform, &Velocity, &mut ExternalForce), With<Raider>>();
    for (at, velocity, mut force) in raiders.iter_mut(world) {
        let goal = GOAL.with_x(FILE.copysign(at.translation.x));
        let way = (goal - at.translation).with_y(0.0).normalize_or_zero();
        let change = (SPEED * way - velocity.linear).with_y(0.0);
        force.force = (12.0 * MASS * change).clamp_length_max(STRENGTH);
    }
}

/// Whoever is in the yard is captured.
fn capture(world: &mut World) {
    let mut zones = world.query_filtered::<&SensorOverlaps, With<Yard>>();
    let inside: Vec<Entity> = zones.iter(world).flat_map(|zone| zone.bodies()).collect();
    world.resource_mut::<Tally>().captured += inside.len() as u32;
    inside
        .into_iter()
        .for_each(|raider| _ = world.despawn(raider));
}
