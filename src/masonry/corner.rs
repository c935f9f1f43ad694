//! Corners of two walls.

use super::{BRICK, Block, MasonryError, error, level};
use glam::Vec3;

/// Two walls in running bond that meet at a right angle and interlock: in every other course one of them goes on to the corner, in the
/// others the other one. The outer edge of the corner stands at the origin, and the walls run along x and z.
#[derive(Clone, Debug, PartialEq)]
pub struct Corner {
    /// Length, height and depth of a brick, m; it must be twice as long as deep. Default: [`BRICK`].
    pub brick: Vec3,
    /// Lengths of the walls along x and along z, from the outer edge, m; multiples of half a brick. Default: 4 and 4.
    pub lengths: [f32; 2],
    /// Number of courses. Default: 6.
    pub courses: u32,
    /// Gap under each course, m. Default: 0.
    pub vertical_gap: f32,
}

impl Default for Corner {
    fn default() -> Self {
        Self {
            brick: BRICK,
            lengths: [4.0; 2],
            courses: 6,
            vertical_gap: 0.0,
        }
    }
}

impl Corner {
    /// The bricks, course by course from the ground.
    ///
    /// # Errors
    /// [`MasonryError`] if a size is invalid, a brick is not twice as long as deep, a wall does not end with a half or whole brick, or
    /// there are too many bricks.
    pub fn blocks(&self) -> Result<Vec<Block>, MasonryError> {
        let Vec3 {
            x: long,
            y: high,
            z: deep,
        } = self.brick;
        error::size("a brick's length", long)?;
        error::size("a brick's height", high)?;
        error::gap("the vertical gap", self.vertical_gap)?;
        if (long - 2.0 * deep).abs() > 1e-3 * long {
            return Err(MasonryError::NotHalfAsDeep);
        }
        if self.courses == 0 {
            return Err(MasonryError::Nothing("courses"));
        }
        let mut halves = [0; 2];
        for (halves, &length) in halves.iter_mut().zip(&self.lengths) {
            let count = (length / deep).round();
            if !((count - length / deep).abs() < 0.02 && (3.0..1e5).contains(&count)) {
                let below = (length / deep).floor().max(0.0) * deep;
                let shorter = if below < 3.0 * deep { 0.0 } else { below };
                return Err(MasonryError::NoRoom {
                    length,
                    nearest: [shorter, (below + deep).max(3.0 * deep)],
                });
            }
            *halves = count as u32;
        }
        let course = halves.iter().map(|&halves| u64::from(halves) / 2 + 1);
        error::count(course.sum::<u64>() * u64::from(self.courses))?;
        let mut blocks = Vec::new();
        for course in 0..self.courses {
            let y = level(course, high, self.vertical_gap);
            for (along_z, halves) in halves.into_iter().enumerate() {
                // The one that ends at the other begins half a brick from the edge.
                let mut at = u32::from((course % 2 == 0) == (along_z == 1));
                while at < halves {
                    let width = 2.min(halves - at);
                    let middle = (at as f32 + 0.5 * width as f32) * deep;
                    let width = width as f32 * deep;
                    let (size, position) = match along_z {
                        0 => (
                            Vec3::new(width, high, deep),
                            Vec3::new(middle, y, 0.5 * deep),
                        ),
                        _ => (
                            Vec3::new(deep, high, width),
                            Vec3::new(0.5 * deep, y, middle),
                        ),
                    };
                    blocks.push(Block::cuboid(size, position));
                    at += 2;
                }
            }
        }
        Ok(blocks)
    }
}
