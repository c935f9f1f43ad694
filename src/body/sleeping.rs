//! Whether a body sleeps. *Sleeping* puts islands to sleep, and *islands* wakes them.

use super::{BodyProperty, BodyState};
use bevy_ecs::entity::{ComponentCloneCtx, SourceComponent};
use bevy_ecs::prelude::*;
use bevy_reflect::{Reflect, std_traits::ReflectDefault};

/// Whether a body sleeps, and may. A body may be spawned asleep, or put to sleep. A copy of it is awake.
#[derive(Component, Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Component, Debug, Default)]
#[component(clone_behavior = Custom(copy_awake), summary_tick)]
pub struct Sleeping {
    /// Now asleep.
    pub asleep: bool,
    /// How long it has been still, s.
    pub still_for: f32,
    /// False keeps it, and every island it is in, awake.
    pub allowed: bool,
}

/// It lies where the original lies, and must get out of its way.
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

impl BodyProperty for Sleeping {
    fn is_known(&self, body: &BodyState) -> bool {
        body.asleep == self.asleep
    }
}

impl Sleeping {
    /// Wakes the body.
    pub fn wake(&mut self) {
        self.asleep = false;
        self.still_for = 0.0;
    }
}
