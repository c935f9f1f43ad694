//! Drystone's own gizmos, as they are switched.

use super::Overlays;
use bevy::prelude::*;
use drystone::gizmos::PhysicsGizmos;

pub(super) fn config(mut store: ResMut<GizmoConfigStore>) {
    let (config, physics) = store.config_mut::<PhysicsGizmos>();
    // Faces that touch hide what is between them.
    config.depth_bias = -1.0;
    physics.shapes = false;
}

pub(super) fn switch(overlays: Res<Overlays>, mut store: ResMut<GizmoConfigStore>) {
    if overlays.is_changed() {
        let (_, physics) = store.config_mut::<PhysicsGizmos>();
        physics.contacts = overlays.contacts;
        physics.impulses = overlays.contacts;
        physics.anchors = overlays.anchors;
    }
}
