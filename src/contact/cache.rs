//! What the narrowphase keeps of a pair from step to step. Data alone: the narrowphase writes and reads it.

use bevy_ecs::prelude::*;
use glam::{Quat, Vec3};
use parry3d::query::{ContactManifold, ContactManifoldsWorkspace};

/// Which features make the separating axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Axis {
    /// Not known.
    #[default]
    Unknown,
    /// The normal of a face of A.
    FaceOfA(u16),
    /// The normal of a face of B.
    FaceOfB(u16),
    /// Square to an edge of A and one of B.
    Edges(u16, u16),
}

/// A manifold of parry's, which keeps the separating axis of ours.
pub(crate) type ParryManifold = ContactManifold<Axis, ()>;

/// What collision detection keeps from step to step.
#[derive(Component, Clone, Default)]
#[component(clone_behavior = Ignore)]
#[doc(hidden)]
pub struct NarrowphaseCache {
    /// How the bodies stood when the manifold was detected.
    pub(crate) stand: Stand,
    /// Along which two polyhedra were last found to be farthest apart.
    pub(crate) axis: Axis,
    /// Of shapes that parry looks at.
    pub(crate) parry: Option<Box<ParryCache>>,
}

/// What parry keeps from search to search.
#[derive(Clone, Default)]
pub(crate) struct ParryCache {
    pub manifolds: Vec<ParryManifold>,
    pub workspace: Option<ContactManifoldsWorkspace>,
}

impl NarrowphaseCache {
    /// What is found next is found anew.
    pub(crate) fn forget(&mut self) {
        self.stand.forget();
        self.axis = Axis::Unknown;
        self.parry = None;
    }
}

/// How two bodies stood to each other, up to what distance their surfaces were searched for contact, and how far they were apart.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stand {
    /// From the centre of mass of B to that of A, world axes, m.
    pub between: Vec3,
    /// Of A and B, as numbers: a `Quat` would be padded to 16 bytes.
    pub rotations: [[f32; 4]; 2],
    /// m; −∞ where what was found may not be kept.
    pub reach: f32,
    /// No two points of theirs were nearer than this, m; −∞ where nothing is known.
    pub apart: f32,
}

impl Default for Stand {
    fn default() -> Self {
        Self {
            between: Vec3::ZERO,
            rotations: [Quat::IDENTITY.to_array(); 2],
            reach: f32::NEG_INFINITY,
            apart: f32::NEG_INFINITY,
        }
    }
}
