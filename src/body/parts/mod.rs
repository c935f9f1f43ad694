//! The parts of a body: the colliders at and below it in the hierarchy, of which its shape and its mass are made.
//!
//! The module [`children`](crate::children) keeps the parts up to date in every step, and says how they are used.

mod compound;
mod gather;
mod hooks;
mod in_table;
mod sensor;

pub use compound::CompoundCollider;
pub(crate) use compound::{compound_mass, is_separate, shape_of};
pub use gather::ColliderOf;
pub(crate) use gather::{Part, body_of, gather, has_few, is_real_body, scale_of};
pub use hooks::Unassembled;
pub(crate) use hooks::{changed_kind, collider_inserted, lost_kind, mark, mark_if_part};
pub(crate) use in_table::{BodyParts, Zone};
pub use sensor::{Sensor, SensorOverlap, SensorOverlaps};

use bevy_ecs::prelude::*;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::{Reflect, std_traits::ReflectDefault};

/// Marks a collider that has no body above it, and was made a static body for that reason. Also a mesh, height field, triangle or
/// half-space below a static or kinematic body, which was made a body of that kind.
///
/// If the entity gets a body above it that it can be a part of, it loses its [`RigidBody`](crate::body::RigidBody) again. Insert a
/// `RigidBody` to make it a body of its own.
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
#[component(clone_behavior = Ignore)]
pub struct ImplicitBody;
