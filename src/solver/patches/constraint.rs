//! A patch of contact: all points of two bodies that share a normal, with one friction force and one twist between them.

use glam::Vec3;

/// What a [patch solver](super::PatchSolver) is given of a patch, and what it finds. World axes.
#[derive(Clone, Copy, Debug, Default)]
pub struct PatchConstraint {
    /// Indices of A and B among the problem's bodies.
    pub bodies: [u32; 2],
    /// Unit vector from B to A.
    pub normal: Vec3,
    /// From the centres of mass of A and B to the patch's centre, m.
    pub arms: [Vec3; 2],
    /// μ
    pub friction: f32,
    /// e
    pub restitution: f32,
    /// How far a sticking patch has slipped since the onset; `None` where nothing holds it.
    pub slip: Option<Slip>,
    /// Its points among the problem's: the first, and how many.
    pub first: u32,
    /// See `first`.
    pub count: u32,
    /// λ_t at the centre, N·s: what to start from, as if it acted all through the step; and what to start the next from.
    pub warm_tangential: Vec3,
    /// Moment about the normal, N·m·s, likewise.
    pub warm_twist: f32,
    /// What resists rolling, as a share of the radius; 0 where nothing rolls.
    pub rolling_friction: f32,
    /// Of what rolls, m.
    pub rolling_radius: f32,
    /// Moment against rolling, N·m·s, likewise.
    pub warm_rolling: Vec3,
    /// Slow means of λ_t and of the twist: what they carry at rest.
    pub load_tangential: Vec3,
    /// See `load_tangential`.
    pub load_twist: f32,
    /// What λ_t has given in the whole step, N·s: found.
    pub tangential: Vec3,
    /// How far it has slid for good in this step, so that its anchor is to follow: found.
    pub dragged: Slip,
}

impl PatchConstraint {
    /// The indices of its points.
    #[inline]
    pub fn range(&self) -> std::ops::Range<usize> {
        self.first as usize..(self.first + self.count) as usize
    }
}

/// How far A has slipped on B at the centre of a patch.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Slip {
    /// m, world axes.
    pub shift: Vec3,
    /// About the normal, rad.
    pub twist: f32,
}

/// One point of a patch.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PatchPoint {
    /// From the patch's centre, world axes, m.
    pub offset: Vec3,
    /// Distance of the surfaces beyond the ideal one, m; negative: too near.
    pub separation: f32,
    /// λ_n, N·s: what to start from, as if it acted all through the step; and what to start the next from.
    pub warm_normal: f32,
    /// What λ_n has given in the whole step, N·s: found.
    pub normal: f32,
    /// A slow mean of λ_n, N·s over the step: what it carries at rest.
    pub load: f32,
}

/// A step walks them five times.
const _: () = assert!(size_of::<PatchConstraint>() <= 160 && size_of::<PatchPoint>() <= 28);
