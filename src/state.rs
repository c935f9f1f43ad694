//! The state of a world: the components and resources that decide how the simulation goes on, on one list.
//!
//! Whoever copies all of them into another world, with entities mapped, can go on there to the same bits. The table in `docs/data-flow.md`
//! says what each is and who writes it. Everything else is derived from these or has no effect on the simulation: scratch memory, times,
//! reports, and messages that wait to be read.
//!
//! Where a component or resource names entities, [`Component::map_entities`] maps them.
//!
//! The list is read with a [`Visitor`].

use crate::body::{self, BodyTable, Inactive, Pending, Quarantined, Teleport};
use crate::broadphase::Broadphase;
use crate::collapse::{CollapseSettings, Stands, Structures, Watch};
use crate::contact::{
    ContactAnchors, ContactForceEvents, ContactImpulses, ContactPair, ContactTargets, EndedPairs,
    Load, LostPairs, Manifold, NarrowphaseCache, Untriggered,
};
use crate::diagnosis::{Suspects, Told};
use crate::grab::{Grasp, Hand, HandForce, HeldBy};
use crate::graph::{ConstraintGraph, Islands};
use crate::settings::{
    Gravity, InForce, NarrowphaseSettings, SleepSettings, SolverSettings, SpeedLimits,
    StabilizationSettings, StepTime,
};
use crate::warm_start::IslandProblems;
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::hierarchy::ChildOf;
use bevy_ecs::name::Name;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use std::sync::atomic::{AtomicU64, Ordering};

/// Is shown each type on the list.
pub trait Visitor {
    /// A component that is part of the state.
    fn component<T: Component + Clone>(&mut self);

    /// A resource that is part of the state. Those of plugins that were not added are missing in the world.
    fn resource<T: Resource + Clone>(&mut self);

    /// A resource that is derived from the state, and must not outlive it: whoever replaces the state puts the default in its place.
    fn derived<T: Resource + Default>(&mut self);
}

/// Shows a visitor the list. Components come before resources: some components count, as they are inserted, what a resource says.
pub fn visit(visitor: &mut impl Visitor) {
    macro_rules! list {
        ($method:ident: $($type:ty),+ $(,)?) => {
            $(visitor.$method::<$type>();)+
        };
    }
    // Of bodies, as users and stages write them.
    body::visit(visitor);
    list!(component: Inactive, Quarantined, Teleport, HandForce, HeldBy);
    list!(component: ContactForceEvents, Load, Watch, Stands);
    // Of hands.
    list!(component: Grasp, Hand);
    // Of anything: Bevy's, as far as drystone reads them.
    list!(component: Transform, ChildOf, Name, Disabled);
    // Of pairs.
    list!(component: ContactPair, Manifold, ContactTargets, ContactImpulses, ContactAnchors, NarrowphaseCache);

    list!(resource: Gravity, StabilizationSettings, NarrowphaseSettings, SolverSettings);
    list!(resource: SleepSettings, SpeedLimits, CollapseSettings);
    list!(resource: InForce, StepTime);
    list!(resource: BodyTable, Broadphase, ConstraintGraph, Islands, LostPairs);
    list!(resource: Suspects, Told, EndedPairs, Untriggered, Structures);

    list!(derived: Pending, IslandProblems);
}

/// A number that no version of anything has had. What is derived from a version of something is not taken for that of another one, not even
/// where one world's state was copied over another's.
pub(crate) fn next_version() -> u64 {
    static LAST: AtomicU64 = AtomicU64::new(0);
    LAST.fetch_add(1, Ordering::Relaxed) + 1
}
