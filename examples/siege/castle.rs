//! The castle: four walls, a gate under a lintel, an arch, a tower of planks, a keep laid with mortar; and a wall beside them that nobody
//! touches.

use crate::game::Layer;
use bevy_ecs::prelude::*;
use bevy_reflect::Reflect;
use bevy_transform::components::Transform;
use drystone::masonry::{Arch, Block, Bond, Opening, Tower, Wall};
use drystone::prelude::*;
use std::f32::consts::FRAC_PI_2;

/// A brick of the castle, and where it was laid.
#[derive(Component, Clone, Copy, Debug, Default, Reflect)]
#[reflect(Component)]
pub struct Brick {
    pub home: Vec3,
    pub turn: Quat,
    /// Whether nothing ever reaches it.
    pub aside: bool,
}

/// The bricks of the front wall break when a stone hits them, and their pieces go after a while.
const BRITTLE: Fracturable = Fracturable {
    energy: 2_000.0,
    pieces: 8,
    again: 0,
    mortar: None,
    debris: Some(Debris {
        lifetime: 8.0,
        fade: 1.0,
        most: 200,
        age: 0.0,
    }),
};

/// Bricks that have broken, which the keeper replaces.
#[derive(Resource, Clone, Debug, Default, Reflect)]
#[reflect(Resource)]
pub struct Broken {
    /// Each with the edges of its collider, m.
    pub bricks: Vec<(Brick, Vec3)>,
}

/// Observer: notes a brick that breaks.
pub fn note_broken(
    fractured: On<Fractured>,
    bricks: Query<(&Brick, &Collider)>,
    mut broken: ResMut<Broken>,
) {
    if let Ok((brick, collider)) = bricks.get(fractured.body) {
        broken.bricks.push((*brick, 2.0 * collider.half_extents()));
    }
}

/// Lays the ground and the castle.
pub fn build(world: &mut World) {
    let layers = CollisionLayers::new(Layer::Things, LayerMask::ALL);
    world.spawn((RigidBody::Static, Collider::half_space(Vec3::Y), layers));
    let at = |x, z, turn: f32| Pose {
        position: Vec3::new(x, 0.0, z),
        rotation: Quat::from_rotation_y(turn),
    };
    let wall = |length, courses| Wall {
        length,
        courses,
        ..Wall::new(Bond::Running)
    };
    let gate = Opening {
        from: 5.0,
        to: 7.0,
        courses: 0..6,
        bearing: 0.5,
    };
    let front = Wall {
        openings: vec![gate],
        ..wall(12.0, 10)
    };
    let front = lay(world, front.blocks(), at(0.0, 0.0, 0.0), false);
    for brick in front {
        world.entity_mut(brick).insert(BRITTLE);
    }
    lay(world, wall(12.0, 10).blocks(), at(0.0, 9.0, 0.0), false);
    lay(world, wall(6.0, 8).blocks(), at(-15.0, 4.0, 0.0), true);
    for x in [-5.75, 5.75] {
        lay(world, wall(8.0, 10).blocks(), at(x, 4.5, FRAC_PI_2), false);
    }
    lay(world, Arch::default().blocks(), at(0.0, 6.5, 0.0), false);
    lay(world, Tower::default().blocks(), at(-4.6, 2.0, 0.0), false);
    let keep = lay(world, wall(3.0, 6).blocks(), at(3.2, 8.0, 0.0), false);
    for brick in keep {
        world.entity_mut(brick).insert(Mortar::default());
    }
}

fn lay(
    world: &mut World,
    blocks: Result<Vec<Block>, drystone::masonry::MasonryError>,
    frame: Pose,
    aside: bool,
) -> Vec<Entity> {
    let blocks = blocks.expect("the lengths fit their bonds");
    let blocks = blocks.into_iter().map(|block| block.moved(&frame));
    let bricks = blocks.map(|block| {
        let Pose {
            position: home,
            rotation: turn,
        } = block.pose;
        let brick = Brick { home, turn, aside };
        world.spawn((block.bundle(), brick, of_the_castle())).id()
    });
    bricks.collect()
}

/// The components that every brick of the castle has.
fn of_the_castle() -> impl Bundle {
    let layers = CollisionLayers::new(Layer::Things, LayerMask::ALL);
    (layers, Watch::default())
}

/// Lays a new brick in the place of one that broke.
pub fn replace(world: &mut World, brick: Brick, collider: Collider) {
    let at = Transform::from_translation(brick.home).with_rotation(brick.turn);
    world.spawn((
        RigidBody::Dynamic,
        collider,
        at,
        brick,
        BRITTLE,
        of_the_castle(),
    ));
}

/// How far a brick is from where it was laid, m.
pub fn moved(brick: &Brick, at: &Transform) -> f32 {
    at.translation.distance(brick.home)
}
