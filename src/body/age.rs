//! Who came first.

use super::{BodyProperty, BodyTable};
use bevy_ecs::{lifecycle::HookContext, prelude::*, world::DeferredWorld};
use bevy_reflect::Reflect;

/// When a body came into the world, counted over all bodies. Bodies on one level of support stand in this order, so two worlds in
/// which it is the same come out the same to the bit, whatever their `Entity`s.
///
/// Stamped when a [`RigidBody`](super::RigidBody) is spawned. Give it by hand, and to all bodies, where worlds must agree that do not spawn in
/// the same order: on a server and its clients.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Reflect)]
#[reflect(Component, Debug)]
#[component(on_add = stamp, clone_behavior = Ignore, summary_tick)]
pub struct Age(pub u64);

impl Age {
    /// Not stamped yet.
    pub(crate) const NONE: Self = Self(u64::MAX);
}

impl Default for Age {
    fn default() -> Self {
        Self::NONE
    }
}

impl BodyProperty for Age {}

/// As soon as the body is spawned: by the next step nobody would know the order any more. Where the plugins come after the body,
/// *prepare* makes up for it.
fn stamp(mut world: DeferredWorld, context: HookContext) {
    let next = world
        .get_resource_mut::<BodyTable>()
        .map(|mut table| table.next_age());
    if let (Some(mut age), Some(next)) = (world.get_mut::<Age>(context.entity), next)
        && *age == Age::NONE
    {
        *age = next;
    }
}
