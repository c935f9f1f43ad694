//! The cost of a step, and the panel of physics.

use crate::overlays::Overlays;
use bevy::prelude::*;
use drystone::panel::PhysicsPanel;
use drystone::prelude::*;

/// Milliseconds of a step, smoothed.
#[derive(Resource, Default)]
pub(super) struct Costs {
    /// The whole step.
    pub step: f32,
}

/// How much of a new figure is taken over.
const NEW: f32 = 0.1;

pub(super) fn follow(mut costs: ResMut<Costs>, profile: Res<Profile>) {
    let new = 1e3 * profile.step.as_secs_f32();
    costs.step += NEW * (new - costs.step);
}

/// Shows or hides the panel of physics.
pub(super) fn switch(overlays: Res<Overlays>, mut panel: ResMut<PhysicsPanel>) {
    if panel.shown != overlays.costs {
        panel.shown = overlays.costs;
    }
}
