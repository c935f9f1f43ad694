//! The way of a piece's weight to the ground.

use super::Overlays;
use crate::camera::Pointer;
use bevy::prelude::*;
use drystone::prelude::*;

/// Thick lines, seen through pieces.
#[derive(Default, Reflect, GizmoConfigGroup)]
pub(super) struct PathGizmos;

pub(super) fn config(mut store: ResMut<GizmoConfigStore>) {
    let (config, _) = store.config_mut::<PathGizmos>();
    config.depth_bias = -1.0;
    config.line.width = 5.0;
}

pub(super) fn draw(
    mut gizmos: Gizmos<PathGizmos>,
    overlays: Res<Overlays>,
    pointer: Res<Pointer>,
    supports: Supports,
    bodies: Query<(&Pose, &RigidBody)>,
) {
    let Some(body) = pointer.body.filter(|_| overlays.path) else {
        return;
    };
    let Ok(path) = supports.load_path(body) else {
        return;
    };
    for bearing in path {
        let Ok((above, _)) = bodies.get(bearing.above) else {
            continue;
        };
        let color = Color::hsla(
            50.0 - 40.0 * bearing.share,
            1.0,
            0.55,
            0.25 + 0.75 * bearing.share,
        );
        // The centre of a static body has no meaning.
        let foot = match bodies.get(bearing.below) {
            Ok((below, RigidBody::Dynamic)) => below.position,
            _ => above.position.with_y(0.0),
        };
        gizmos.arrow(above.position, foot, color);
    }
}
