//! Pyramids, towers and houses of cards.

use super::{Block, MasonryError, error, level, quarter_turn, side_by_side};
use bevy_math::ops;
use glam::{Quat, Vec3};

/// A pyramid of cubes in rows along x, each row with one cube fewer than the row below.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pyramid {
    /// Number of cubes in the lowest row.
    pub base: u32,
    /// Edge length of a cube, m.
    pub cube: f32,
    /// Gap between neighbours in a row, m.
    pub lateral_gap: f32,
    /// Gap under each row, m.
    pub vertical_gap: f32,
}

impl Pyramid {
    /// A pyramid of cubes of 1 m without gaps.
    pub fn new(base: u32) -> Self {
        Self {
            base,
            cube: 1.0,
            lateral_gap: 0.0,
            vertical_gap: 0.0,
        }
    }

    /// The cubes, row by row from the ground.
    ///
    /// # Errors
    /// [`MasonryError`] if a size is invalid, or there are no cubes or too many.
    pub fn blocks(&self) -> Result<Vec<Block>, MasonryError> {
        error::size("a cube", self.cube)?;
        error::gap("the lateral gap", self.lateral_gap)?;
        error::gap("the vertical gap", self.vertical_gap)?;
        if self.base == 0 {
            return Err(MasonryError::Nothing("cubes"));
        }
        let base = u64::from(self.base);
        error::count(base * (base + 1) / 2)?;
        let mut blocks = Vec::new();
        for course in 0..self.base {
            let y = level(course, self.cube, self.vertical_gap);
            let widths = vec![self.cube; (self.base - course) as usize];
            let row = side_by_side(&widths, self.lateral_gap);
            blocks.extend(row.map(|x| Block::cuboid(Vec3::splat(self.cube), Vec3::new(x, y, 0.0))));
        }
        Ok(blocks)
    }
}

/// A tower of planks, three in a layer, each layer across the one below, as in the game in which players pull planks out and lay them on
/// top.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tower {
    /// Number of layers. Default: 18.
    pub layers: u32,
    /// Length, height and depth of a plank, m. Three depths and two gaps should add up to a length. Default: (0.75, 0.15, 0.245).
    pub plank: Vec3,
    /// Gap between the planks of a layer, m. Default: 0.0075.
    pub lateral_gap: f32,
    /// Gap under each layer, m. Default: 0.
    pub vertical_gap: f32,
}

impl Default for Tower {
    /// Eighteen layers of the game's proportions, ten times as large.
    fn default() -> Self {
        Self {
            layers: 18,
            plank: Vec3::new(0.75, 0.15, 0.245),
            lateral_gap: 0.0075,
            vertical_gap: 0.0,
        }
    }
}

impl Tower {
    /// The planks, layer by layer from the ground, and within a layer from one side to the other.
    ///
    /// # Errors
    /// [`MasonryError`] if a size is invalid, or there are no layers or too many.
    pub fn blocks(&self) -> Result<Vec<Block>, MasonryError> {
        for size in self.plank.to_array() {
            error::size("a plank", size)?;
        }
        error::gap("the lateral gap", self.lateral_gap)?;
        error::gap("the vertical gap", self.vertical_gap)?;
        if self.layers == 0 {
            return Err(MasonryError::Nothing("layers"));
        }
        error::count(3 * u64::from(self.layers))?;
        let mut blocks = Vec::new();
        for layer in 0..self.layers {
            let y = level(layer, self.plank.y, self.vertical_gap);
            let turn = match layer % 2 {
                0 => Quat::IDENTITY,
                _ => quarter_turn(),
            };
            let planks = [self.plank.z; 3];
            let row = side_by_side(&planks, self.lateral_gap);
            blocks.extend(row.map(|z| {
                let mut block = Block::cuboid(self.plank, turn * Vec3::Z * z + Vec3::Y * y);
                block.pose.rotation = turn;
                block
            }));
        }
        Ok(blocks)
    }
}

/// A house of cards: leaning pairs of cards, with a flat card over each level but the last. Each level has one pair fewer than the level
/// below.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CardHouse {
    /// Number of levels. Default: 3.
    pub levels: u32,
    /// Length, thickness and width of a card, m. Default: (1, 0.06, 0.7).
    pub card: Vec3,
    /// Angle of leaning cards from the vertical, rad. Default: 15°.
    pub lean: f32,
    /// Gap between cards that would touch, m. Default: 0.
    pub gap: f32,
}

impl Default for CardHouse {
    fn default() -> Self {
        Self {
            levels: 3,
            card: Vec3::new(1.0, 0.06, 0.7),
            lean: 15f32.to_radians(),
            gap: 0.0,
        }
    }
}

impl CardHouse {
    /// The cards, level by level from the ground.
    ///
    /// # Errors
    /// [`MasonryError`] if a size is invalid, or there are no levels or too many.
    pub fn blocks(&self) -> Result<Vec<Block>, MasonryError> {
        for size in self.card.to_array() {
            error::size("a card", size)?;
        }
        error::gap("a gap", self.gap)?;
        if !(0.0..1.5).contains(&self.lean) {
            return Err(MasonryError::InvalidSize("how far cards lean"));
        }
        if self.levels == 0 {
            return Err(MasonryError::Nothing("levels"));
        }
        let levels = u64::from(self.levels);
        error::count((levels * (levels + 1)).saturating_add(levels - 1))?;
        let Vec3 {
            x: length,
            y: thickness,
            z: width,
        } = self.card;
        let (sin, cos) = ops::sin_cos(self.lean);
        // A leaning card's extent: half its height and half its width.
        let rise = 0.5 * (length * cos + thickness * sin);
        let reach = 0.5 * (length * sin + thickness * cos);
        let pitch = 4.0 * reach + 0.1 * length;
        let mut y = 0.0;
        let mut blocks = Vec::new();
        for level in 0..self.levels {
            let pairs = self.levels - level;
            for i in 0..pairs {
                let x = (i as f32 - 0.5 * (pairs - 1) as f32) * pitch;
                for side in [-1.0, 1.0] {
                    let at = Vec3::new(
                        x + side * (reach + 0.5 * self.gap),
                        y + self.gap + rise,
                        0.0,
                    );
                    let mut card = Block::cuboid(Vec3::new(thickness, length, width), at);
                    card.pose.rotation = Quat::from_rotation_z(side * self.lean);
                    blocks.push(card);
                }
            }
            y += self.gap + 2.0 * rise;
            if pairs > 1 {
                let span = (pairs - 1) as f32 * pitch + 4.0 * thickness;
                let at = Vec3::Y * (y + self.gap + 0.5 * thickness);
                blocks.push(Block::cuboid(Vec3::new(span, thickness, width), at));
                y += self.gap + thickness;
            }
        }
        Ok(blocks)
    }
}
