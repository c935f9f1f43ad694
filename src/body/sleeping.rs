//! The component that says whether a body sleeps. The stage *sleeping* puts islands to sleep, and the stage *islands* wakes bodies.

use bevy_ecs::entity::{ComponentCloneCtx, SourceComponent};
use bevy_ecs::prelude::*;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::{Reflect, std_traits::ReflectDefault};

/// Whether a body sleeps, and whether it may. A body can be spawned asleep or put to sleep. The clone of a sleeping body is awake.
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
#[component(clone_behavior = Custom(copy_awake), summary_tick)]
pub struct Sleeping {
    /// Whether the body sleeps. Default: false.
    pub asleep: bool,
    /// Time for which the body has been still, s. Default: 0.
    pub still_for: f32,
    /// Whether the body may sleep. False keeps the body and its island awake. Default: true.
    pub allowed: bool,
}

/// A clone overlaps its original, so it must be awake for the two to be pushed apart.
fn copy_awake(source: &SourceComponent, context: &mut ComponentCloneCtx) {
    if let Some(&original) = source.read::<Sleeping>() {
        let mut copy = original;
        copy.wake();
        context.write_target_component(copy);
    }
}

impl Default for Sleeping {
    fn default() -> Self {
        Self {
            asleep: false,
            still_for: 0.0,
            allowed: true,
        }
    }
}

impl Sleeping {
    /// Wakes the body.
    pub fn wake(&mut self) {
        self.asleep = false;
        self.still_for = 0.0;
    }
}
