//! Asking a world outside of a system: the functions [`spatial_query`](crate::query::spatial_query),
//! [`contacts`](crate::contact::contacts()) and [`supports`](crate::contact::supports()) build the system parameter of the same name and
//! hand it to a closure.

use bevy_ecs::system::{ReadOnlySystemParam, SystemParamItem, SystemState};
use bevy_ecs::world::World;

/// Calls `ask` with a system parameter of this world.
///
/// # Panics
/// If a resource that the parameter reads is missing, with a sentence that names the plugin to add.
pub(crate) fn ask<P: ReadOnlySystemParam + 'static, R>(
    world: &mut World,
    ask: impl FnOnce(SystemParamItem<P>) -> R,
) -> R {
    let mut state = SystemState::<P>::new(world);
    match state.get(world) {
        Ok(parameter) => ask(parameter),
        Err(error) => {
            panic!("the world has no physics: add `DrystonePlugins`, or `StepPlugin` ({error})")
        }
    }
}
