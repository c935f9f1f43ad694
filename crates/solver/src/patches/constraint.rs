//! A patch of contact: all points of two bodies that share a normal, with one friction force and one twist between them.

#[cfg(feature = "bevy_reflect")]
use bevy_reflect::{Reflect, std_traits::ReflectDefault};
use glam::Vec3;

/// The input of a [patch solver](super::PatchSolver) for a patch, and its results. World axes.
#[derive(Clone, Copy, Debug, Default)]
pub struct PatchConstraint {
    /// Indices of A and B among the problem's bodies.
    pub bodies: [u32; 2],
    /// Unit vector from B to A.
    pub normal: Vec3,
    /// From the centres of mass of A and B to the patch's centre, m.
    pub arms: [Vec3; 2],
    /// Coefficient of friction μ.
    pub friction: f32,
    /// Coefficient of restitution e.
    pub restitution: f32,
    /// Slip of a sticking patch since the onset; `None` if friction is not anchored.
    pub slip: Option<Slip>,
    /// Index of its first point among the problem's.
    pub first: u32,
    /// Number of its points.
    pub count: u32,
    /// λ_t at the centre, N·s over the whole step. In: the warm start. Out: that of the next step.
    pub friction_impulse: Vec3,
    /// Moment about the normal, N·m·s; in and out as `friction_impulse`.
    pub twist_impulse: f32,
    /// Rolling friction, as a share of the radius; 0 if the patch does not roll.
    pub rolling_friction: f32,
    /// Rolling radius, m.
    pub rolling_radius: f32,
    /// Moment against rolling, N·m·s; in and out as `friction_impulse`.
    pub rolling_impulse: Vec3,
    /// Slow mean of λ_t: its load at rest, N·s over the step.
    pub rest_friction_impulse: Vec3,
    /// Slow mean of the twist: its load at rest, N·m·s over the step.
    pub rest_twist_impulse: f32,
    /// Result: impulse of λ_t over the whole step, N·s.
    pub tangential: Vec3,
    /// Result: permanent slip in this step, by which its anchor is to be moved.
    pub dragged: Slip,
}

impl PatchConstraint {
    /// The indices of its points.
    #[inline]
    pub fn range(&self) -> std::ops::Range<usize> {
        self.first as usize..(self.first + self.count) as usize
    }
}

/// Slip of A on B at the centre of a patch.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect), reflect(Debug, Default))]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Slip {
    /// Displacement in world axes, m.
    pub shift: Vec3,
    /// Rotation about the normal, rad.
    pub twist: f32,
}

/// One point of a patch.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PatchPoint {
    /// From the patch's centre, world axes, m.
    pub offset: Vec3,
    /// Distance of the surfaces beyond the ideal one, m; negative: too near.
    pub separation: f32,
    /// λ_n, N·s over the whole step. In: the warm start. Out: that of the next step.
    pub normal_impulse: f32,
    /// Result: impulse of λ_n over the whole step, N·s.
    pub normal: f32,
    /// Slow mean of λ_n: its load at rest, N·s over the step.
    pub rest_impulse: f32,
}

/// The sizes matter, since a step passes over these lists five times.
const _: () = assert!(size_of::<PatchConstraint>() <= 160 && size_of::<PatchPoint>() <= 28);
