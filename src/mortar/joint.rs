//! The joint that a bonded patch is.

use super::Mortar;
use super::patch::{Patch, section};
use crate::body::SpawnOrder;
use crate::joint::{JointDefinition, JointEnds, JointForces, JointFrame, JointType, look_again};
use crate::solver::Section;
use bevy_ecs::prelude::*;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::Reflect;
use glam::Vec2;

/// A mortar joint: the bond of two bodies at one patch of contact. [`Mortar`] makes it, an entity for each patch; despawn it to break the
/// bond.
///
/// It holds the bodies as they were when it was made, like a [`FixedJoint`](crate::joint::FixedJoint), until the stress in the patch
/// exceeds its strength. [`JointForces`] has the force and the torque about the centre of the patch.
#[derive(Component, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect), reflect(Component, Debug))]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[component(on_remove = look_again)]
#[require(JointForces, SpawnOrder)]
pub struct MortarJoint {
    /// The first body.
    #[entities]
    pub body1: Option<Entity>,
    /// The second body.
    #[entities]
    pub body2: Option<Entity>,
    /// The patch on body 1: its centroid, and its axes. x is the normal, from body 1 to body 2; y and z are the principal axes of the area.
    pub frame1: JointFrame,
    /// The patch on body 2.
    pub frame2: JointFrame,
    /// The corners of the patch, along y and z from its centroid, counterclockwise about x, m. The last is repeated if there are three.
    pub corners: [Vec2; 4],
    /// The strength of the bond.
    pub mortar: Mortar,
}

impl MortarJoint {
    /// A bond of two bodies at a patch, as they are.
    pub(super) fn new(bodies: [Entity; 2], patch: &Patch, mortar: Mortar) -> Self {
        let frame = JointFrame::from_global(patch.center, patch.axes);
        Self {
            body1: Some(bodies[0]),
            body2: Some(bodies[1]),
            frame1: frame,
            frame2: frame,
            corners: patch.corners,
            mortar,
        }
    }

    /// Area of the patch, m².
    pub fn area(&self) -> f32 {
        section(self.corners).area
    }

    /// The highest stress in the patch under the forces of the last step, as a share of the strength: of the tensile strength or of the
    /// shear strength, whichever is greater. The bond breaks above 1.
    pub fn utilization(&self, forces: &JointForces) -> f32 {
        self.section().utilization(forces.filtered).share
    }

    fn section(&self) -> Section {
        let Mortar {
            tensile_strength: tension,
            cohesion,
            friction,
        } = self.mortar;
        Section {
            tension,
            cohesion,
            friction,
            ..section(self.corners)
        }
    }
}

crate::joint::joint_ends!(MortarJoint, |_joint| false);

impl JointType for MortarJoint {
    fn definition(&self) -> JointDefinition {
        JointDefinition {
            section: Some(self.section()),
            ..self.locked()
        }
    }
}

/// The corners of a patch in the world, m, from the position and the axes of its frame.
#[cfg(feature = "gizmos")]
pub(crate) fn corners(section: &Section, center: glam::Vec3, axes: glam::Quat) -> [glam::Vec3; 4] {
    section
        .corners
        .map(|corner| center + axes * glam::Vec3::new(0.0, corner.x, corner.y))
}
