//! The state of a world: the list of components and resources that determine how the simulation continues.
//!
//! If all of them are copied into another world, with entities mapped, the simulation there continues with bitwise equal results. The table
//! in `docs/data-flow.md` says what each is and which stage writes it. All other data is derived from these or has no effect on the
//! simulation: scratch memory, times, reports, and unread messages.
//!
//! Components and resources that refer to entities map them with [`Component::map_entities`](bevy_ecs::component::Component::map_entities).
//!
//! The list is read with a [`Visitor`]. To add a component, write it in a file of its own, and add its name to the group of those that are
//! treated like it: here, or in the lists of [body properties](crate::body) and [joint types](crate::joint).

mod list;

pub use crate::stored::{Role, Stored, Visitor};
pub(crate) use list::{copy_settings, list, parts_of};

use crate::body::parts::{ColliderOf, ImplicitBody, Unassembled};
use crate::body::{
    self, BodyTable, GrabForce, HeldBy, Inactive, Pending, Quarantined, RigidBodyDisabled, Sensor,
    SensorOverlaps, Teleport,
};
use crate::broadphase::Broadphase;
use crate::character::{Character, CharacterState};
use crate::collapse::{CollapseSettings, Stands, Structures, Watch};
use crate::contact::{CollidingEntities, ContactForceEvents, ContactHooks, Load, Untriggered};
use crate::diagnosis::{FoundProblems, ReportedProblems};
use crate::fluid::{Fluid, FluidState};
use crate::fracture::{Debris, Fracturable, Fractures};
use crate::grab::{Hand, HandState};
use crate::graph::{ConstraintGraph, Islands};
use crate::joint::BrokenJoints;
use crate::joint_types::{
    self, BreakForce, JointChanges, JointDisabled, JointEdge, JointForces, Mortar,
    QuarantinedJoint, Studs,
};
use crate::mortar::BrokenMortar;
use crate::pair::{
    ContactAnchors, ContactImpulses, ContactPair, ContactTargets, EndedPairs, LostPairs, Manifold,
    MovingSurfaces, NarrowphaseCache,
};
use crate::restored::{Restored, Saved};
use crate::sensor::{Sensors, UntriggeredSensorEvents};
use crate::settings::{
    ActiveSettings, Gravity, NarrowphaseSettings, PhysicsTime, SleepSettings, SolverSettings,
    SpeedLimits, StabilizationSettings, StepTime,
};
use crate::streaming::{Arrivals, Suspended};
use crate::vehicle::{Wheel, WheelState};
use crate::voxels::{VoxelChunk, Voxels};
use crate::warm_start::IslandProblems;
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::hierarchy::ChildOf;
use bevy_ecs::name::Name;
use bevy_transform::components::Transform;

/// Makes [`visit`] and [`register`] of groups of types. A group names the method of [`Visitor`] for its types and their [`Role`]. Types of
/// a group that is `hidden` are not registered for reflection.
macro_rules! state {
    (derived { $($Derived:ident),+ } $($method:ident $role:ident $($hidden:ident)? { $($Type:ident),+ })+) => {
        /// Passes every type on the list to a visitor. Components come before resources, because inserting some components changes
        /// counters in resources.
        pub fn visit(visitor: &mut impl Visitor) {
            body::visit(visitor);
            joint_types::visit(visitor);
            $($(visitor.$method::<$Type>(Role::$role);)+)+
            $(visitor.derived::<$Derived>();)+
        }

        /// Registers the types on the list for reflection.
        #[cfg(feature = "bevy_reflect")]
        pub(crate) fn register(app: &mut bevy_app::App) {
            body::register(app);
            joint_types::register(app);
            $(register!(app $($hidden)? { $($Type)+ });)+
        }
    };
}

#[cfg(feature = "bevy_reflect")]
macro_rules! register {
    ($app:ident { $($Type:ident)+ }) => {
        $($app.register_type::<$Type>();)+
    };
    ($app:ident hidden { $($Type:ident)+ }) => {};
}

state! {
    derived { Pending, IslandProblems }

    component Other { Quarantined, RigidBodyDisabled, Teleport, GrabForce, HeldBy, CollidingEntities, ContactForceEvents, Watch }
    component Other hidden { Stands }
    component Body { Mortar, Studs }
    output Other { Load }
    internal Stages hidden { Inactive }
    // Colliders.
    component Other { ColliderOf, ImplicitBody, Sensor, SensorOverlaps }
    // Entities of a scene that was just loaded.
    internal Other { Saved }
    // Hands and characters.
    component Other { HandState, Hand, CharacterState, Character }
    // Bodies that break, and debris.
    component Other { Fracturable, Debris, Voxels, VoxelChunk }
    // Fluids.
    component Other { Fluid, FluidState }
    // Vehicles.
    component Other { Wheel, WheelState }
    // Joints.
    component Joint { JointForces, BreakForce }
    component Other { JointDisabled, QuarantinedJoint }
    internal Other hidden { JointEdge }
    // Any entity: components that drystone reads.
    component Bevy { Transform, Name }
    immutable Bevy { ChildOf }
    marker Bevy { Disabled }
    internal Pair { ContactPair, Manifold, ContactTargets, ContactImpulses, ContactAnchors }
    internal Pair hidden { NarrowphaseCache }

    resource Setting { Gravity, StabilizationSettings, NarrowphaseSettings, SolverSettings, SleepSettings, SpeedLimits, CollapseSettings }
    resource Time { PhysicsTime, StepTime }
    code Other hidden { ContactHooks }
    resource Hooks hidden { BodyTable, JointChanges, Unassembled }
    resource Stages hidden { Broadphase, ConstraintGraph, Islands, LostPairs, Suspended }
    resource Events hidden { Untriggered, UntriggeredSensorEvents, BrokenJoints, BrokenMortar, Fractures }
    resource Other hidden { ActiveSettings, FoundProblems, ReportedProblems, EndedPairs, Structures, MovingSurfaces }
    resource Other hidden { Sensors, Restored, Arrivals }
}
