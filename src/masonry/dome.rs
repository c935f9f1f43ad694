//! Domes of rings.

use super::{Block, MasonryError, error};
use crate::body::{Pose, collider::Collider};
use crate::solver::Both;
use bevy_math::ops;
use glam::{Quat, Vec3};
use std::f32::consts::{FRAC_PI_2, TAU};

/// A spherical shell around the y axis, made of rings of blocks and open at the top. It springs from y = 0.
///
/// The blocks of a ring stand directly over those of the ring below, so that whole faces meet. Shifted by half a block they would not,
/// because a ring of flat faces is not a surface of revolution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dome {
    /// Radius of the middle of the shell, m. Default: 2.5.
    pub radius: f32,
    /// Thickness along the radius, m. Default: 0.5.
    pub thickness: f32,
    /// Number of rings. Default: 6.
    pub rings: u32,
    /// Number of blocks in each ring. Default: 16.
    pub blocks: u32,
    /// Angle from the axis to the edge of the opening, rad. Default: 0.25.
    pub opening: f32,
}

impl Default for Dome {
    fn default() -> Self {
        Self {
            radius: 2.5,
            thickness: 0.5,
            rings: 6,
            blocks: 16,
            opening: 0.25,
        }
    }
}

impl Dome {
    /// The blocks, ring by ring from the ground.
    ///
    /// # Errors
    /// [`MasonryError`] if a size is invalid, there are no rings or fewer than three blocks in a ring, there are too many blocks, or the
    /// opening leaves no room for them.
    pub fn blocks(&self) -> Result<Vec<Block>, MasonryError> {
        error::size("a dome's radius", self.radius)?;
        error::size("a dome's thickness", self.thickness)?;
        error::size("a dome's opening", self.opening)?;
        if self.thickness >= 2.0 * self.radius {
            return Err(MasonryError::InvalidSize("the inner radius"));
        }
        if self.opening >= FRAC_PI_2 {
            return Err(MasonryError::InvalidSize("a dome's opening"));
        }
        if self.rings == 0 {
            return Err(MasonryError::Nothing("rings"));
        }
        if self.blocks < 3 {
            return Err(MasonryError::Nothing("blocks that close a ring"));
        }
        error::count(u64::from(self.rings) * u64::from(self.blocks))?;
        let rise = (FRAC_PI_2 - self.opening) / self.rings as f32;
        let turn = TAU / self.blocks as f32;
        let reach = 0.5 * self.thickness;
        let radii = [self.radius - reach, self.radius + reach];
        let mut blocks = Vec::new();
        for ring in 0..self.rings {
            let (low, high) = (ring as f32 * rise, (ring + 1) as f32 * rise);
            // With x through its middle.
            let corner = |radius: f32, up: f32, side: f32| {
                let out = radius * ops::cos(up);
                let (sin, cos) = ops::sin_cos(0.5 * side * turn);
                Vec3::new(out * cos, radius * ops::sin(up), out * sin)
            };
            let mut points = Vec::with_capacity(8);
            for radius in radii {
                for up in [low, high] {
                    points.extend([-1.0, 1.0].both(|side| corner(radius, up, side)));
                }
            }
            let middle = points.iter().sum::<Vec3>() / points.len() as f32;
            points.iter_mut().for_each(|point| *point -= middle);
            let block =
                Collider::convex_hull(&points).map_err(|_| MasonryError::DegenerateBlock)?;
            blocks.extend((0..self.blocks).map(|i| {
                let rotation = Quat::from_rotation_y(i as f32 * turn);
                Block {
                    collider: block.clone(),
                    pose: Pose {
                        position: rotation * middle,
                        rotation,
                    },
                }
            }));
        }
        Ok(blocks)
    }
}
