//! The hill beside the castle, of cells, in which sappers blow holes.

use crate::game::{Clock, Layer, Tally};
use bevy_ecs::prelude::*;
use bevy_reflect::Reflect;
use bevy_transform::components::Transform;
use drystone::prelude::*;

/// The hill.
#[derive(Component, Clone, Copy, Debug, Default, Reflect)]
#[reflect(Component)]
pub struct Hill;

/// Edge of a cell, m, and cells of the hill along x, y and z.
const CELL: f32 = 0.25;
const CELLS: IVec3 = IVec3::new(40, 14, 32);
/// Where its first cell is, m.
const CORNER: Vec3 = Vec3::new(12.0, 0.0, -6.0);
/// Time between two charges, s, and the radius of the hole that one makes, m.
const PERIOD: f32 = 10.0;
const HOLE: f32 = 0.6;
/// What comes off lies about for a while.
const RUBBLE: Debris = Debris {
    lifetime: 8.0,
    fade: 1.0,
    most: 50,
    age: 0.0,
};

/// Height of the hill at a place, cells.
fn height(x: i32, z: i32) -> i32 {
    let from_middle = |of: i32, count: i32| (2 * of - count) as f32 / count as f32;
    let [x, z] = [from_middle(x, CELLS.x), from_middle(z, CELLS.z)];
    let share = (1.0 - x * x) * (1.0 - z * z);
    1 + (share * (CELLS.y - 1) as f32) as i32
}

pub fn build(world: &mut World) {
    let mut cells = Voxels::new(CELL).with_ground(0);
    for x in 0..CELLS.x {
        for z in 0..CELLS.z {
            cells.set_box(
                IVec3::new(x, 0, z),
                IVec3::new(x + 1, height(x, z), z + 1),
                true,
            );
        }
    }
    world.spawn((
        RigidBody::Static,
        cells,
        Density(1800.0),
        CollisionLayers::new(Layer::Things, LayerMask::ALL),
        Transform::from_translation(CORNER),
        Hill,
    ));
}

pub fn step(world: &mut World, clock: Clock) {
    let mut pieces =
        world.query_filtered::<(Entity, &RigidBody), (With<Voxels>, Without<Debris>)>();
    let fresh: Vec<Entity> = pieces
        .iter(world)
        .filter(|(_, kind)| **kind == RigidBody::Dynamic)
        .map(|(piece, _)| piece)
        .collect();
    for piece in fresh {
        world.entity_mut(piece).insert(RUBBLE);
    }
    if !clock.strikes(5.0, PERIOD) {
        return;
    }
    let charge = (clock.seconds() / PERIOD) as i32;
    let (x, z) = (4 + 7 * charge % 32, 4 + 11 * charge % 24);
    let mut hills = world.query_filtered::<&mut Voxels, With<Hill>>();
    let Ok(mut cells) = hills.single_mut(world) else {
        return;
    };
    let at = cells.center_of(IVec3::new(x, height(x, z) - 1, z));
    let dug = cells.set_ball(at, HOLE, false);
    world.resource_mut::<Tally>().dug += dug as u32;
}
