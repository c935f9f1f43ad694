//! Arches of voussoirs.

use super::{Block, MasonryError, error};
use crate::body::{Pose, collider::Collider};
use bevy_math::ops;
use glam::{Quat, Vec3};
use std::f32::consts::PI;

/// A circular arch with radial joints in the x–y plane, around the origin. By default it is a semicircle that springs from y = 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arch {
    /// Radius of the middle of the ring, m. Default: 3.
    pub radius: f32,
    /// Thickness along the radius, m. Default: 0.6.
    pub thickness: f32,
    /// Depth along z, m. Default: 1.
    pub depth: f32,
    /// Number of voussoirs. Default: 15.
    pub voussoirs: u32,
    /// Angle from springing to springing, rad. Default: π, half a ring.
    pub angle: f32,
    /// Width of each joint, and of the gaps under both springers, m. Default: 0.
    pub gap: f32,
}

impl Default for Arch {
    fn default() -> Self {
        Self {
            radius: 3.0,
            thickness: 0.6,
            depth: 1.0,
            voussoirs: 15,
            angle: PI,
            gap: 0.0,
        }
    }
}

impl Arch {
    /// The voussoirs, from the right springing to the left.
    ///
    /// # Errors
    /// [`MasonryError`] if a size is invalid, there are no voussoirs or too many, or each of them spans half a ring or more.
    pub fn blocks(&self) -> Result<Vec<Block>, MasonryError> {
        error::size("an arch's radius", self.radius)?;
        error::size("an arch's thickness", self.thickness)?;
        error::size("an arch's depth", self.depth)?;
        error::size("an arch's angle", self.angle)?;
        error::gap("an arch's gap", self.gap)?;
        if self.thickness >= 2.0 * self.radius {
            return Err(MasonryError::InvalidSize("the inner radius"));
        }
        if self.angle > 2.0 * PI {
            return Err(MasonryError::InvalidSize("an arch's angle"));
        }
        if self.voussoirs == 0 {
            return Err(MasonryError::Nothing("voussoirs"));
        }
        error::count(self.voussoirs.into())?;
        let angle = self.angle / self.voussoirs as f32;
        let half = 0.5 * angle;
        if half >= 0.49 * PI {
            return Err(MasonryError::DegenerateBlock);
        }
        let reach = 0.5 * self.thickness;
        let (inner, outer) = (self.radius - reach, self.radius + reach);
        let corner = |radius: f32, side: f32, z: f32| {
            let (sin, cos) = ops::sin_cos(side * half);
            Vec3::new(radius * cos, radius * sin, z * 0.5 * self.depth)
        };
        // In a frame at the arch's centre with x through the voussoir's middle; then moved to the voussoir's own middle.
        let middle = Vec3::X * self.radius;
        let points: Vec<Vec3> = [-1.0, 1.0]
            .iter()
            .flat_map(|&z| {
                [(inner, -1.0), (inner, 1.0), (outer, -1.0), (outer, 1.0)]
                    .map(|(r, s)| corner(r, s, z) - middle)
            })
            .collect();
        let voussoir = Collider::convex_hull(&points).map_err(|_| MasonryError::DegenerateBlock)?;
        // Moved out along its middle, each joint opens by the gap; lifted, so do the springers'.
        let out = 0.5 * self.gap / ops::sin(half);
        let first = 0.5 * (PI - self.angle);
        let block = |i: u32| {
            let rotation = Quat::from_rotation_z(first + (i as f32 + 0.5) * angle);
            let position = rotation * (middle + Vec3::X * out) + Vec3::Y * (0.5 * self.gap);
            Block {
                collider: voussoir.clone(),
                pose: Pose { position, rotation },
            }
        };
        Ok((0..self.voussoirs).map(block).collect())
    }
}
