//! The frames of a joint: where it is attached to its two bodies.

use crate::body::{Pose, limits};
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::{Reflect, std_traits::ReflectDefault};
use glam::{Quat, Vec3};

/// Where a joint is attached to one of its bodies, and how its axes lie there. Default: found when the joint is added, from the other body.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect), reflect(Debug, Default))]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct JointFrame {
    /// The point of the body at which the joint is attached.
    pub anchor: JointAnchor,
    /// The axes of the joint on the body.
    pub basis: JointBasis,
}

/// The point of a body at which a joint is attached.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect), reflect(Debug, Default))]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum JointAnchor {
    /// Where the anchor on the other body is when the joint is added. If neither anchor is given, both are at the centre of mass of body 2,
    /// or of body 1 if body 2 is the world. Distance and spring joints take the centre of mass of each body instead.
    #[default]
    Auto,
    /// In the frame of the body, from its origin, m. In the world if the body is the world.
    Local(Vec3),
    /// In the world, m: the point of the body that is there when the joint is added. The step that adds the joint replaces it by a local
    /// one.
    FromGlobal(Vec3),
}

/// The orientation of a joint's axes on a body.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect), reflect(Debug, Default))]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum JointBasis {
    /// As the basis on the other body lies when the joint is added. If neither is given, both are the axes of the world.
    #[default]
    Auto,
    /// Rotation from the joint's axes to those of the body.
    Local(Quat),
    /// Rotation from the joint's axes to those of the world when the joint is added. The step that adds the joint replaces it by a local
    /// one.
    FromGlobal(Quat),
}

impl JointFrame {
    /// A frame relative to its body: anchor from the origin (m), rotation from the joint's axes to those of the body.
    pub fn local(anchor: Vec3, basis: Quat) -> Self {
        Self {
            anchor: JointAnchor::Local(anchor),
            basis: JointBasis::Local(basis),
        }
    }

    /// A frame in the world, as it is when the joint is added: position (m) and orientation.
    pub fn from_global(anchor: Vec3, basis: Quat) -> Self {
        Self {
            anchor: JointAnchor::FromGlobal(anchor),
            basis: JointBasis::FromGlobal(basis),
        }
    }

    /// Whether anchor and basis are local.
    pub(crate) fn is_local(&self) -> bool {
        matches!(self.anchor, JointAnchor::Local(_)) && matches!(self.basis, JointBasis::Local(_))
    }

    pub(crate) fn has_valid_anchor(&self) -> bool {
        match self.anchor {
            JointAnchor::Auto => true,
            JointAnchor::Local(point) | JointAnchor::FromGlobal(point) => {
                limits::within(point, limits::POSITION)
            }
        }
    }

    pub(crate) fn has_valid_basis(&self) -> bool {
        match self.basis {
            JointBasis::Auto => true,
            JointBasis::Local(turn) | JointBasis::FromGlobal(turn) => limits::is_turn(turn),
        }
    }
}

/// The frames of a joint, all local, for bodies at these poses with these centres of mass (world, m); the world has no centre. If `apart`,
/// anchors that are not given are at the centres of mass.
pub(crate) fn resolve(
    frames: [JointFrame; 2],
    poses: [Pose; 2],
    centers: [Option<Vec3>; 2],
    apart: bool,
) -> [JointFrame; 2] {
    let points: [Option<Vec3>; 2] = std::array::from_fn(|i| match frames[i].anchor {
        JointAnchor::Auto if apart => centers[i],
        JointAnchor::Auto => None,
        JointAnchor::Local(point) => Some(poses[i].transform_point(point)),
        JointAnchor::FromGlobal(point) => Some(point),
    });
    let turns: [Option<Quat>; 2] = std::array::from_fn(|i| match frames[i].basis {
        JointBasis::Auto => None,
        JointBasis::Local(turn) => Some(poses[i].rotation * turn.normalize()),
        JointBasis::FromGlobal(turn) => Some(turn.normalize()),
    });
    let center = centers[1].or(centers[0]).unwrap_or_default();
    let turn = turns[0].or(turns[1]).unwrap_or_default();
    let point = points[0].or(points[1]).unwrap_or(center);
    std::array::from_fn(|i| {
        let anchor = match frames[i].anchor {
            JointAnchor::Local(point) => point,
            _ => poses[i].inverse_transform_point(points[i].unwrap_or(point)),
        };
        let basis = match frames[i].basis {
            JointBasis::Local(turn) => turn.normalize(),
            _ => poses[i].rotation.inverse() * turns[i].unwrap_or(turn),
        };
        JointFrame::local(anchor, basis)
    })
}
