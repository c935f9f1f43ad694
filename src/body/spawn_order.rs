//! The order in which bodies were spawned.

use super::BodyTable;
use crate::solver::sort::Word;
use bevy_ecs::{lifecycle::HookContext, prelude::*, world::DeferredWorld};
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::Reflect;

/// The number of a body in the order of spawning. Bodies on one level of support are solved in this order. So two worlds with the same
/// numbers give bitwise equal results, whatever their `Entity`s are.
///
/// A [`RigidBody`](super::RigidBody) gets its number when it is spawned. Set it by hand on all bodies if two worlds must agree that do not
/// spawn them in the same order, such as a server and its clients.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect), reflect(Component, Debug))]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[component(on_add = stamp, clone_behavior = Ignore, summary_tick)]
pub struct SpawnOrder(pub u64);

impl SpawnOrder {
    /// The default: no number yet.
    pub(crate) const NONE: Self = Self(u64::MAX);
}

impl Word for SpawnOrder {
    fn word(self) -> u64 {
        self.0
    }
}

impl Default for SpawnOrder {
    fn default() -> Self {
        Self::NONE
    }
}

/// Numbers a body when it is spawned, because the next step cannot recover the order of spawning. Bodies that are spawned before the
/// plugins are added get their numbers in *prepare*.
fn stamp(mut world: DeferredWorld, context: HookContext) {
    let next = world
        .get_resource_mut::<BodyTable>()
        .map(|mut table| table.next_spawn_order());
    if let (Some(mut spawn_order), Some(next)) = (world.get_mut::<SpawnOrder>(context.entity), next)
        && *spawn_order == SpawnOrder::NONE
    {
        *spawn_order = next;
    }
}
