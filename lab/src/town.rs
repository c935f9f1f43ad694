//! Towns: many walls that stand asleep.

use bevy_ecs::prelude::*;
use drystone::body::Pose;
use drystone::masonry::{Bond, MasonryError, Wall};
use drystone::streaming::spawn_asleep;
use glam::Vec3;

/// Distance between streets, m. A wall is shorter.
const STREET: f32 = 50.0;

/// Spawns walls asleep on a square, the first of them at the origin, in running bond. A wall has so many bricks in a course and so many
/// courses; its neighbour in the street stands `apart` m behind it. Returns the bricks, wall by wall.
///
/// # Errors
/// If there is no such wall.
pub fn build(
    world: &mut World,
    [columns, courses]: [u32; 2],
    walls: u32,
    apart: f32,
) -> Result<Vec<Entity>, MasonryError> {
    let wall = Wall {
        length: columns as f32,
        courses,
        ..Wall::new(Bond::Running)
    };
    let blocks = wall.blocks()?;
    let side = f64::from(walls).sqrt().ceil() as u32;
    let town = (0..walls).flat_map(|i| {
        let (street, place) = (i / side, i % side);
        let frame = Pose {
            position: Vec3::new(STREET * street as f32, 0.0, -apart * place as f32),
            ..Pose::default()
        };
        let wall = blocks.iter().cloned();
        wall.map(move |block| block.moved(&frame).bundle())
    });
    let left = blocks.len() * walls as usize;
    Ok(spawn_asleep(world, Counted { left, town }))
}

/// An iterator of known length, so that the ECS makes room once.
struct Counted<I> {
    left: usize,
    town: I,
}

impl<I: Iterator> Iterator for Counted<I> {
    type Item = I::Item;

    fn next(&mut self) -> Option<I::Item> {
        self.left = self.left.saturating_sub(1);
        self.town.next()
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        (self.left, Some(self.left))
    }
}
