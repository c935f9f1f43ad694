//! The state of a world: the list of components and resources that determine how the simulation continues.
//!
//! If all of them are copied into another world, with entities mapped, the simulation there continues with bitwise equal results. The table
//! in `docs/data-flow.md` says what each is and which stage writes it. All other data is derived from these or has no effect on the
//! simulation: scratch memory, times, reports, and unread messages.
//!
//! Components and resources that refer to entities map them with [`Component::map_entities`](bevy_ecs::component::Component::map_entities).
//!
//! The list is read with a [`Visitor`].

mod list;

pub use crate::stored::{Stored, Visitor};
pub(crate) use list::{components_of, list};

use crate::body::{self, BodyTable, Inactive, Pending, Quarantined, RigidBodyDisabled, Teleport};
use crate::broadphase::Broadphase;
use crate::character::{Character, CharacterState};
use crate::children::{ColliderOf, ImplicitBody, Unassembled};
use crate::collapse::{CollapseSettings, Stands, Structures, Watch};
use crate::contact::{
    CollidingEntities, ContactAnchors, ContactForceEvents, ContactHooks, ContactImpulses,
    ContactPair, ContactTargets, EndedPairs, Load, LostPairs, Manifold, MovingSurfaces,
    NarrowphaseCache, Untriggered,
};
use crate::diagnosis::{Suspects, Told};
use crate::grab::{GrabForce, Hand, HandState, HeldBy};
use crate::graph::{ConstraintGraph, Islands};
use crate::joint::{
    self, BreakForce, BrokenJoints, JointChanges, JointDisabled, JointEdge, JointForces,
    QuarantinedJoint,
};
use crate::mortar::{BrokenMortar, Mortar};
use crate::saving::{Restored, Saved};
use crate::sensor::{Sensor, SensorOverlaps, Sensors, UntriggeredSensorEvents};
use crate::settings::{
    ActiveSettings, Gravity, NarrowphaseSettings, PhysicsTime, SleepSettings, SolverSettings,
    SpeedLimits, StabilizationSettings, StepTime,
};
use crate::streaming::{Arrivals, Suspended};
use crate::warm_start::IslandProblems;
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::hierarchy::ChildOf;
use bevy_ecs::name::Name;
use bevy_transform::components::Transform;
use std::any::TypeId;

/// Returns true for a component of Bevy, which entities have that have nothing to do with drystone.
pub(crate) fn is_of_bevy(id: TypeId) -> bool {
    let of_bevy = [
        TypeId::of::<Transform>(),
        TypeId::of::<ChildOf>(),
        TypeId::of::<Name>(),
        TypeId::of::<Disabled>(),
    ];
    of_bevy.contains(&id)
}

/// Passes every type on the list to a visitor. Components come before resources, because inserting some components changes counters in
/// resources.
pub fn visit(visitor: &mut impl Visitor) {
    macro_rules! list {
        ($method:ident: $($type:ty),+ $(,)?) => {
            $(visitor.$method::<$type>();)+
        };
    }
    // Bodies, written by users and stages.
    body::visit(visitor);
    list!(internal: Inactive);
    list!(component: Quarantined, RigidBodyDisabled, Teleport, GrabForce, HeldBy);
    list!(component: CollidingEntities, ContactForceEvents, Watch, Stands);
    list!(output: Load);
    // Colliders.
    list!(component: ColliderOf, ImplicitBody, Sensor, SensorOverlaps);
    // Entities of a scene that was just loaded.
    list!(internal: Saved);
    // Hands.
    list!(component: HandState, Hand);
    // Characters.
    list!(component: CharacterState, Character);
    // Joints.
    joint::visit(visitor);
    list!(internal: JointEdge);
    list!(component: JointForces, BreakForce, JointDisabled, QuarantinedJoint);
    list!(component: Mortar);
    // Any entity: components of Bevy that drystone reads.
    list!(component: Transform, Name);
    list!(immutable: ChildOf);
    list!(marker: Disabled);
    // Pairs.
    list!(internal: ContactPair, Manifold, ContactTargets, ContactImpulses, ContactAnchors, NarrowphaseCache);

    list!(resource: Gravity, StabilizationSettings, NarrowphaseSettings, SolverSettings);
    list!(resource: SleepSettings, SpeedLimits, CollapseSettings, PhysicsTime);
    list!(code: ContactHooks);
    list!(resource: ActiveSettings, StepTime);
    list!(resource: BodyTable, Broadphase, ConstraintGraph, Islands, LostPairs);
    list!(resource: Suspects, Told, EndedPairs, Untriggered, Structures, MovingSurfaces);
    list!(resource: JointChanges, BrokenJoints, BrokenMortar);
    list!(resource: Unassembled, Sensors, UntriggeredSensorEvents, Restored, Suspended, Arrivals);

    list!(derived: Pending, IslandProblems);
}
