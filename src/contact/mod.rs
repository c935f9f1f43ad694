//! The contact pair as an entity: which bodies, where they touch, what acts there, and where it is held.
//!
//! A pair lives as long as the fat boxes of its two bodies overlap, touching or not, so that pairs seldom come and go. All its
//! lists run in parallel over the points of its [`Manifold`].

mod events;

pub(crate) use events::trigger;
pub use events::{
    ContactEnded, ContactEvents, ContactStarted, EndedPairs, Untriggered, contact_events,
};

use crate::islands::SolverSlot;
use bevy_ecs::prelude::*;
use glam::Vec3;
use parry3d::query::{ContactManifold, ContactManifoldsWorkspace};
use smallvec::SmallVec;

/// Two bodies near each other. A is `bodies[0]`, B is `bodies[1]`; normals point from B to A.
#[derive(Component, Clone, Copy, Debug)]
#[require(
    Manifold,
    ContactTargets,
    ContactImpulses,
    ContactAnchors,
    NarrowphaseCache,
    SolverSlot
)]
pub struct ContactPair {
    /// A and B.
    pub bodies: [Entity; 2],
    /// Their slots in the [`BodyTable`](crate::body::BodyTable).
    pub slots: [u32; 2],
    /// What pairs are sorted by: the order in which A and B came into the world.
    pub order: [u64; 2],
    /// Combined coefficient of friction μ.
    pub friction: f32,
    /// Combined coefficient of restitution e.
    pub restitution: f32,
    /// Some point is inside the collision envelope.
    pub touching: bool,
    /// Touching, as last told to listeners.
    pub(crate) announced: bool,
}

/// Where two bodies touch, or may within the step.
#[derive(Component, Clone, Debug, Default)]
pub struct Manifold {
    /// Parts of the manifold with one normal each. A pair of convex bodies has one at most.
    pub patches: SmallVec<[Patch; 1]>,
    /// The points of all patches.
    pub points: SmallVec<[ContactPoint; 4]>,
}

/// Contact points with one normal.
#[derive(Clone, Copy, Debug)]
pub struct Patch {
    /// Unit vector from B to A, world axes.
    pub normal: Vec3,
    /// Index of its first point.
    pub first: u32,
    /// How many points it has.
    pub count: u32,
    /// One of the surfaces is curved here, so that it can roll.
    pub curved: bool,
}

impl Patch {
    /// The indices of its points.
    pub fn range(&self) -> std::ops::Range<usize> {
        self.first as usize..(self.first + self.count) as usize
    }
}

/// One point of contact.
#[derive(Clone, Copy, Debug)]
pub struct ContactPoint {
    /// Midway between the surfaces, world, m.
    pub position: Vec3,
    /// The same point in the frames of A and B, m.
    pub local: [Vec3; 2],
    /// Signed distance d of the surfaces along the normal, m; negative: overlap.
    pub distance: f32,
}

/// What the two stabilizations demand of each point's velocity.
#[derive(Component, Clone, Debug, Default)]
pub struct ContactTargets {
    /// One for each point.
    pub points: SmallVec<[Target; 4]>,
}

/// The velocity that a contact point should have after the solve.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Target {
    /// Lower bound of the normal velocity, m/s: u_collision + c_n of equations (4) and (6).
    pub normal: f32,
    /// Tangential velocity, m/s, world axes: −c_t of equation (15), against the slip.
    pub tangential: Vec3,
}

/// The impulses λ of the last solve.
#[derive(Component, Clone, Debug, Default)]
pub struct ContactImpulses {
    /// One for each point.
    pub points: SmallVec<[Impulse; 4]>,
}

/// What A gets at a contact point, and B the opposite of.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Impulse {
    /// λ_n ≥ 0 along the normal, N·s.
    pub normal: f32,
    /// λ_t, N·s, world axes.
    pub tangential: Vec3,
}

/// The tracked contact anchors of section 3 of the paper.
#[derive(Component, Clone, Debug, Default)]
pub struct ContactAnchors {
    /// One for each point.
    pub points: SmallVec<[Anchor; 4]>,
}

/// Where one contact point is held while it sticks.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Anchor {
    /// Classified as sticking in the last step, equation (10).
    pub sticking: bool,
    /// An anchor is set (sticking and written).
    pub set: bool,
    /// p_A and p_B of equation (11): the contact point in the frames of A and B when it was written, m. With pair-pose
    /// anchors: the position of A's origin in B's frame, and unused.
    pub local: [Vec3; 2],
    /// The contact normal in the frames of A and B when it was written.
    pub normal: [Vec3; 2],
    /// Pair-pose anchors: the rotation of A in B's frame when it was written.
    pub rotation: glam::Quat,
    /// Curved contacts: the slip since the onset, Σ u_t Δt, world axes, m.
    pub slip: Vec3,
}

/// What parry keeps from step to step. Internal.
#[derive(Component, Default)]
pub struct NarrowphaseCache {
    pub(crate) manifolds: Vec<ContactManifold<(), u32>>,
    pub(crate) workspace: Option<ContactManifoldsWorkspace>,
}
