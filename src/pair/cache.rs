//! Data of a pair that the narrowphase keeps from step to step. The code that writes and reads it is in the narrowphase.

use bevy_ecs::prelude::*;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::{Reflect, std_traits::ReflectDefault};
use glam::{Quat, Vec3};
use parry3d::query::{ContactManifold, ContactManifoldsWorkspace};
use std::fmt;

/// The features that define the separating axis of two polyhedra.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect), reflect(Debug, Default))]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Axis {
    /// No axis is known. The default.
    #[default]
    Unknown,
    /// The normal of a face of A.
    FaceOfA(u16),
    /// The normal of a face of B.
    FaceOfB(u16),
    /// Perpendicular to an edge of A and one of B.
    Edges(u16, u16),
}

/// A manifold of parry that also stores our separating axis.
pub(crate) type ParryManifold = ContactManifold<Axis, ()>;

/// Data that collision detection keeps from step to step.
#[derive(Component, Clone, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[component(clone_behavior = Ignore)]
#[doc(hidden)]
pub struct NarrowphaseCache {
    /// The relative pose of the bodies when the manifold was detected.
    pub(crate) last_pose: CachedRelativePose,
    /// The axis along which two polyhedra were last found to be farthest apart.
    pub(crate) axis: Axis,
    /// Data of parry, for shapes that parry handles.
    pub(crate) parry: Option<Box<ParryCache>>,
}

/// Data that parry keeps from one detection to the next.
#[derive(Clone, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct ParryCache {
    pub manifolds: Vec<ParryManifold>,
    /// The places of the manifolds by the parts that touch. It is not written: the order of its hash maps differs from process to process.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub workspace: Option<ContactManifoldsWorkspace>,
    /// The manifolds were read from bytes, so the workspace does not know them.
    #[cfg_attr(feature = "serde", serde(skip, default = "was_read"))]
    pub is_read: bool,
}

#[cfg(feature = "serde")]
fn was_read() -> bool {
    true
}

impl fmt::Debug for NarrowphaseCache {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("NarrowphaseCache")
            .field("last_pose", &self.last_pose)
            .field("axis", &self.axis)
            .finish_non_exhaustive()
    }
}

impl NarrowphaseCache {
    /// Discards the data, so that the next detection starts from scratch.
    pub(crate) fn forget(&mut self) {
        self.last_pose.forget();
        self.axis = Axis::Unknown;
        self.parry = None;
    }
}

/// The relative pose of two bodies at the last detection, the distance up to which contacts were searched, and a lower bound of their
/// distance.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct CachedRelativePose {
    /// From the centre of mass of B to that of A, world axes, m.
    pub between: Vec3,
    /// Orientations of A and B, as numbers: a `Quat` would be padded to 16 bytes.
    pub rotations: [[f32; 4]; 2],
    /// Search distance, m; −∞ if the manifold must not be recycled.
    pub reach: f32,
    /// Lower bound of the distance of the two surfaces, m; −∞ if none is known.
    pub apart: f32,
}

impl Default for CachedRelativePose {
    fn default() -> Self {
        Self {
            between: Vec3::ZERO,
            rotations: [Quat::IDENTITY.to_array(); 2],
            reach: f32::NEG_INFINITY,
            apart: f32::NEG_INFINITY,
        }
    }
}
