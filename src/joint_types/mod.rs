//! The components of joints: their types, frames, forces and edges.
//!
//! Users find them in the module [`joint`](crate::joint), which stands above the constraint graph and has the stage and the questions.

mod definition;
mod edge;
mod error;
mod forces;
mod frame;
mod list;
mod mortar;
pub(crate) mod types;

pub use crate::solver::{JointAxis, JointMotor};
pub use definition::JointLimits;
pub(crate) use definition::{JointDefinition, JointEnds, JointType};
pub use edge::{JointChanges, JointEdge};
pub use error::{JointError, JointProblem, QuarantinedJoint};
pub use forces::{BreakForce, JointForces};
pub(crate) use frame::resolve;
pub use frame::{JointAnchor, JointBasis, JointFrame};
#[cfg(feature = "bevy_reflect")]
pub(crate) use list::register;
pub(crate) use list::{
    DetachedJoints, WrittenJoints, added, definition, look_again, set_bodies, settle, visit,
};
pub(crate) use mortar::Patch;
#[cfg(feature = "gizmos")]
pub(crate) use mortar::corners;
pub use mortar::{Mortar, MortarJoint, Studs};
pub(crate) use types::joint_ends;

use bevy_ecs::prelude::*;
use bevy_ecs::world::DeferredWorld;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::{Reflect, std_traits::ReflectDefault};

/// Marks a joint that is switched off: it does nothing, and its bodies collide. Remove the component to switch it on again. A joint that
/// broke has it.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq)]
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
#[component(on_insert = list::look_again)]
pub struct JointDisabled;

/// Looks at a joint again that was disabled as an entity.
pub(crate) fn look_at_disabled(world: &mut DeferredWorld, joint: Entity) {
    if world.get::<JointEdge>(joint).is_some()
        && let Some(mut changes) = world.get_resource_mut::<JointChanges>()
    {
        changes.written.push(joint);
    }
}
