//! Mortar, and the joint that bonds two bodies at a patch of contact.

mod patch;
mod studs;

pub(crate) use patch::Patch;
pub use studs::Studs;

use super::{
    JointDefinition, JointEnds, JointForces, JointFrame, JointType, joint_ends, look_again,
};
use crate::body::SpawnOrder;
use crate::solver::Section;
use bevy_ecs::prelude::*;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::{Reflect, std_traits::ReflectDefault};
use glam::Vec2;
use patch::section;

/// Fresh mortar on a body: in the first step in which it rests on other bodies, face to face, it is bonded to all of them, and the
/// component is removed. Insert it again to bond the body to what it touches by then.
///
/// The default has the characteristic strengths of clay bricks in a common cement mortar (EN 1996-1-1, 3.6: M2.5 to M9).
#[derive(Component, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "bevy_reflect",
    derive(Reflect),
    reflect(Component, Debug, Default)
)]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Mortar {
    /// Tensile strength, Pa. Default: 100 kPa.
    pub tensile_strength: f32,
    /// Shear strength without pressure, Pa. Default: 200 kPa.
    pub cohesion: f32,
    /// Shear strength gained per pressure on the patch. Default: 0.4. It acts while the bond holds; then the friction of the bodies does.
    pub friction: f32,
}

impl Default for Mortar {
    fn default() -> Self {
        Self {
            tensile_strength: 1e5,
            cohesion: 2e5,
            friction: 0.4,
        }
    }
}

impl Mortar {
    /// Mortar of these tensile and shear strengths, Pa.
    pub fn new(tensile_strength: f32, cohesion: f32) -> Self {
        Self {
            tensile_strength,
            cohesion,
            ..Self::default()
        }
    }

    /// The lesser strength of each kind.
    pub(crate) fn weaker(&self, other: &Self) -> Self {
        Self {
            tensile_strength: self.tensile_strength.min(other.tensile_strength),
            cohesion: self.cohesion.min(other.cohesion),
            friction: self.friction.min(other.friction),
        }
    }

    pub(crate) fn is_valid(&self) -> bool {
        // A comparison with NaN is false.
        self.tensile_strength >= 0.0 && self.cohesion >= 0.0 && self.friction >= 0.0
    }
}

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
    pub(crate) fn new(bodies: [Entity; 2], patch: &Patch, mortar: Mortar) -> Self {
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

joint_ends!(MortarJoint, |_joint| false);

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
