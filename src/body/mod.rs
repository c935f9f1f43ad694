//! Bodies: the components that define kind, pose, velocity, mass, surface and applied forces of a body, and the table of all bodies.
//!
//! A body is an entity with a [`RigidBody`], and with a [`Collider`](crate::collider::Collider) if it can touch other bodies; more
//! colliders may be on [child entities](crate::children). The components that every body has are added with their defaults; others, such as
//! [`ExternalForce`], only if you insert them. The [`BodyTable`] is a dense copy of the components that the stages read at random. The
//! stage [`prepare`] fills it once a step.
//!
//! A body with a component whose value is invalid or beyond the [`limits`] is [quarantined](Quarantined): it is reported, and takes no part
//! in the simulation until the value is corrected.

#[doc(hidden)]
pub mod collider;
mod disabled;
mod inactive;
mod kept_components;
mod list;
#[expect(
    missing_debug_implementations,
    reason = "`derive(QueryData)` generates state types without `Debug`"
)]
mod listed;
mod mass;
mod motion;
mod moved;
pub(crate) mod parts;
mod placement;
mod prepare;
mod properties;
mod push;
mod sleeping;
mod spawn_order;
mod table;

pub use crate::limits;
pub(crate) use disabled::Simulated;
pub use disabled::{ColliderDisabled, RigidBodyDisabled};
pub use inactive::Inactive;
pub(crate) use inactive::{InactiveBodies, note_written};
pub(crate) use kept_components::{kept_components, take_over};
#[cfg(feature = "bevy_reflect")]
pub(crate) use listed::register;
pub(crate) use listed::visit;
pub use mass::{AngularInertia, CenterOfMass, Density, Mass, MassProperties};
pub(crate) use mass::{weigh_body, weigh_with_parts};
pub use motion::Motion;
pub use moved::Moved;
pub(crate) use parts::mark_if_part;
pub use parts::{CompoundCollider, Sensor, SensorOverlap, SensorOverlaps};
pub use placement::Teleport;
pub(crate) use placement::{
    Beside, local_pose, pose_of, transform_of, user_pose, velocity_between,
};
#[doc(hidden)]
pub use prepare::any_suspects;
pub(crate) use prepare::{
    ActiveBodies, ActiveBodyItem, NewBodies, PlacedActive, PlacedBodies, add_asleep, new_rows,
    newer_than, written_rows,
};
pub use prepare::{
    Pending, Quarantined, WrittenTransforms, complete, find_written_transforms, lift, prepare,
    quarantine, refresh,
};
pub(crate) use properties::KeptProperty;
pub use properties::{
    ActiveContactHooks, BodyProperties, ContactEvents, Dominance, LockedAxes, MaxAngularSpeed,
    MaxLinearSpeed, SolverEffort,
};
pub use push::{
    Damping, ExternalForce, ExternalImpulse, Forces, ForcesItem, ForcesReadOnly,
    ForcesReadOnlyItem, Grab, GrabForce, GravityScale, HeldBy, forces,
};
pub(crate) use push::{let_go_of, let_go_of_disabled};
pub use sleeping::Sleeping;
pub use spawn_order::SpawnOrder;
#[cfg(feature = "serde")]
pub(crate) use table::Noted;
pub use table::{BodyIndex, BodyState, BodyTable};
pub(crate) use table::{WORLD, cover, is_body, lost_description, make_room, note_loss, with_table};

use bevy_ecs::prelude::*;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::{Reflect, std_traits::ReflectDefault};
use bevy_transform::components::Transform;
use glam::{Quat, Vec3};
use list::body_properties;

macro_rules! rigid_body {
    (
        essential { $($essential:ident: $Essential:ident $(= $_essential_known:expr)?,)* }
        computed { $($computed:ident: $Computed:ident,)* }
        pushing { $($_pushing:tt)* }
        optional { $($_optional:tt)* }
        described { $($_described:tt)* }
        kept { $($_kept:tt)* }
    ) => {
        /// The kind of a body: whether forces and contacts move it. It may be changed at any time.
        #[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
        #[cfg_attr(feature = "bevy_reflect", derive(Reflect), reflect(Component, Debug, Default))]
        #[cfg_attr(all(feature = "bevy_reflect", feature = "serde"), reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize))]
        #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
        #[component(on_insert = parts::changed_kind, on_remove = parts::lost_kind, summary_tick)]
        #[require($($Essential,)* $($Computed,)* Transform)]
        pub enum RigidBody {
            /// Moved by forces and contacts. The default.
            #[default]
            Dynamic,
            /// Infinitely heavy, and never moved by the simulation. A change of its `Transform` moves it at once and does not carry other
            /// bodies along. Its [`Velocity`] is that of its surface, as on a conveyor belt.
            Static,
            /// Infinitely heavy, and moved only by the user: by its [`Velocity`], or by a change of its `Transform`. In the step after that
            /// change it has the velocity that takes it to the new pose, and carries the bodies that stand on it. See [`Teleport`].
            Kinematic,
        }
    };
}
body_properties!(rigid_body);

/// Position and orientation of a body in the world. Default: the origin, without rotation.
///
/// Drystone owns this component. A step reads the [`Transform`] if the user changed it, and writes the new pose back to it at the end.
/// Inside the physics schedule use `Pose` rather than `Transform`.
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
#[component(summary_tick)]
pub struct Pose {
    /// Position of the body's origin, m.
    pub position: Vec3,
    /// Orientation, a unit quaternion.
    pub rotation: Quat,
}

impl Default for Pose {
    fn default() -> Self {
        Self {
            position: Vec3::ZERO,
            rotation: Quat::IDENTITY,
        }
    }
}

impl Pose {
    /// Transforms a point from the body's frame to the world, m.
    #[inline]
    pub fn transform_point(&self, local: Vec3) -> Vec3 {
        self.position + self.rotation * local
    }

    /// Transforms a point from the world to the body's frame, m.
    #[inline]
    pub fn inverse_transform_point(&self, world: Vec3) -> Vec3 {
        self.rotation.inverse() * (world - self.position)
    }

    /// Returns true if every number is finite.
    #[inline]
    pub fn is_finite(&self) -> bool {
        self.position.is_finite() && self.rotation.is_finite()
    }

    /// This pose with a rotation of unit length.
    #[inline]
    pub(crate) fn normalized(mut self) -> Self {
        if !self.rotation.is_normalized() {
            self.rotation = self.rotation.normalize();
        }
        self
    }

    /// This pose in the frame of another.
    pub(crate) fn within(&self, frame: &Self) -> Self {
        Self {
            position: frame.inverse_transform_point(self.position),
            rotation: frame.rotation.inverse() * self.rotation,
        }
    }

    pub(crate) fn to_parry(self) -> parry3d::math::Pose {
        parry3d::math::Pose::from_parts(self.position, self.rotation)
    }
}

/// Linear and angular velocity of a body. Default: zero.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq)]
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
#[component(summary_tick)]
pub struct Velocity {
    /// Velocity of the centre of mass, m/s.
    pub linear: Vec3,
    /// Angular velocity in world axes, rad/s.
    pub angular: Vec3,
}

impl Velocity {
    /// A velocity without rotation, m/s.
    pub fn linear(linear: Vec3) -> Self {
        Self {
            linear,
            angular: Vec3::ZERO,
        }
    }

    /// Velocity of the body's material at `arm` from its centre of mass (world axes, m), in m/s.
    #[inline]
    pub fn at(&self, arm: Vec3) -> Vec3 {
        self.linear + self.angular.cross(arm)
    }

    /// Returns true if every number is finite.
    pub fn is_finite(&self) -> bool {
        self.linear.is_finite() && self.angular.is_finite()
    }

    /// Returns true if every number is within [`limits`].
    #[inline]
    pub fn is_within_limits(&self) -> bool {
        limits::within(self.linear, limits::SPEED) && limits::within(self.angular, limits::SPIN)
    }
}
