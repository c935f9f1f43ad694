//! The ends of a bond: where it holds its bodies.

use glam::{Quat, Vec3};

/// Where a bond holds one of its bodies, and where that body is at the beginning of the step.
///
/// Arm and frame do not change as long as the bond holds, so bodies that bonds connect have the same places relative to each other, to the
/// bit, in every step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BondEnd {
    /// From the centre of mass to the bonded patch, axes of the body, m.
    pub arm: Vec3,
    /// Rotation from the axes of the joint to those of the body.
    pub frame: Quat,
    /// The centre of mass, world, m.
    pub center: Vec3,
    /// Rotation from the axes of the body to those of the world.
    pub rotation: Quat,
}
