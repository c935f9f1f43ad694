//! The panel of physics, shown all the time and without a window: what it costs is measured (feature `ui`).

use bevy_app::{App, Update};
use bevy_ecs::prelude::*;
use drystone::panel::{PhysicsPanel, PhysicsPanelPlugin};
use std::time::{Duration, Instant};

pub fn add(app: &mut App) {
    app.add_plugins(PhysicsPanelPlugin);
    app.world_mut().resource_mut::<PhysicsPanel>().shown = true;
}

/// Runs what an app runs in every frame, and returns how long it took.
pub fn frame(world: &mut World) -> Duration {
    let start = Instant::now();
    world.run_schedule(Update);
    start.elapsed()
}

pub fn mean(times: &[Duration]) -> String {
    let sum: Duration = times.iter().sum();
    format!("{:.4}", 1e3 * sum.as_secs_f64() / times.len().max(1) as f64)
}
