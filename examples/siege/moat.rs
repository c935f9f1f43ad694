//! The moat: two basins beside the drawbridge, with barrels that float in them.

use crate::game::{Clock, Layer, Tally};
use bevy_ecs::prelude::*;
use bevy_reflect::Reflect;
use bevy_transform::components::Transform;
use drystone::prelude::*;

/// A basin.
#[derive(Component, Clone, Copy, Debug, Default, Reflect)]
#[reflect(Component)]
pub struct Basin;

/// What floats.
#[derive(Component, Clone, Copy, Debug, Default, Reflect)]
#[reflect(Component)]
pub struct Barrel;

/// Length along the wall, depth and width of a basin, m, and the middle of the right one.
const SIZE: Vec3 = Vec3::new(4.6, 0.8, 3.2);
const MIDDLE: Vec3 = Vec3::new(3.6, 0.4, -2.4);
/// Thickness of its banks, m.
const BANK: f32 = 0.2;

pub fn build(world: &mut World) {
    let layers = CollisionLayers::new(Layer::Things, LayerMask::ALL);
    for side in [-1.0, 1.0] {
        let middle = MIDDLE * Vec3::new(side, 1.0, 1.0);
        let mut bank = |size: Vec3, at: Vec3| {
            let shape = Collider::cuboid(size.x, size.y, size.z);
            let at = Transform::from_translation(middle + at);
            world.spawn((RigidBody::Static, shape, layers, at));
        };
        for end in [-0.5, 0.5] {
            bank(SIZE.with_x(BANK), Vec3::X * (end * (SIZE.x + BANK)));
            let along = SIZE.with_z(BANK) + Vec3::X * (2.0 * BANK);
            bank(along, Vec3::Z * (end * (SIZE.z + BANK)));
        }
        let water = Collider::cuboid(SIZE.x, SIZE.y - 0.1, SIZE.z);
        let at = Transform::from_translation(middle + Vec3::NEG_Y * 0.05);
        world.spawn((water, Fluid::water(), layers, at, Basin));
        for i in 0..3 {
            let at = middle + Vec3::new(1.3 * (i as f32 - 1.0), 0.6, 0.3 * i as f32);
            let lying = Quat::from_rotation_z(std::f32::consts::FRAC_PI_2);
            world.spawn((
                RigidBody::Dynamic,
                Collider::cylinder(0.25, 0.7),
                Density(400.0),
                layers,
                Transform::from_translation(at).with_rotation(lying),
                Barrel,
            ));
        }
    }
}

/// Counts the barrels that float in their basins.
pub fn step(world: &mut World, clock: Clock) {
    if !clock.strikes(5.0, 1.0) {
        return;
    }
    let mut barrels = world.query_filtered::<(Entity, &Transform), With<Barrel>>();
    let found: Vec<Entity> = barrels
        .iter(world)
        .filter(|(_, at)| at.translation.y > 0.4)
        .map(|(barrel, _)| barrel)
        .collect();
    let mut basins = world.query_filtered::<&SensorOverlaps, With<Basin>>();
    let mut inside = |barrel: &Entity| basins.iter(world).any(|basin| basin.contains(*barrel));
    let afloat = found.iter().filter(|barrel| inside(barrel)).count();
    world.resource_mut::<Tally>().afloat = afloat as u32;
}
