//! A backend for [`bevy_picking`]: pointers hit bodies by their collision shapes. Needs the feature `picking`.
//!
//! Add [`PhysicsPickingPlugin`] beside Bevy's own picking plugins, and `Pointer` events reach bodies. Poses are those at the start of the
//! frame. Entities with `Pickable::IGNORE` are skipped. A ray goes on through an entity whose `Pickable` does not block lower entities.

use crate::RefreshSystems;
use crate::query::{QueryFilter, SpatialQuery};
use bevy_app::{App, Plugin, PreUpdate};
use bevy_camera::Camera;
use bevy_ecs::message::MessageWriter;
use bevy_ecs::prelude::*;
use bevy_picking::backend::ray::RayMap;
use bevy_picking::backend::{HitData, PointerHits};
use bevy_picking::{Pickable, PickingSystems};

/// Adds a picking backend that casts pointer rays against bodies; see the [module](self). It is not part of
/// [`DrystonePlugins`](crate::DrystonePlugins).
#[derive(Debug)]
pub struct PhysicsPickingPlugin;

impl Plugin for PhysicsPickingPlugin {
    fn build(&self, app: &mut App) {
        let pick = pick.in_set(PickingSystems::Backend).after(RefreshSystems);
        // Bevy's own picking plugins add these too, and may come later.
        app.init_resource::<RayMap>()
            .add_message::<PointerHits>()
            .add_systems(PreUpdate, pick);
    }

    fn finish(&self, app: &mut App) {
        crate::schedule::check_step_plugin::<Self>(app);
    }
}

/// How far pointers reach, m.
const MAX_DISTANCE: f32 = 1e5;

/// Reports the bodies that each pointer hits, nearest first.
fn pick(
    rays: Res<RayMap>,
    cameras: Query<&Camera>,
    pickables: Query<&Pickable>,
    world: SpatialQuery,
    mut hits: MessageWriter<PointerHits>,
) {
    let seen = |body| pickables.get(body) != Ok(&Pickable::IGNORE);
    let filter = QueryFilter::default().with_predicate(&seen);
    for (&id, &ray) in rays.iter() {
        let Ok(camera) = cameras.get(id.camera) else {
            continue;
        };
        // The ray of a camera with an invalid transform hits nothing.
        let found = world
            .cast_ray_through(ray, MAX_DISTANCE, &filter)
            .unwrap_or_default();
        let mut picks = Vec::new();
        for hit in found {
            let data = HitData::new(id.camera, hit.distance, Some(hit.point), Some(hit.normal));
            picks.push((hit.entity, data));
            let blocks = pickables.get(hit.entity);
            if blocks.map_or(true, |pickable| pickable.should_block_lower) {
                break;
            }
        }
        if !picks.is_empty() {
            hits.write(PointerHits::new(id.pointer, picks, camera.order as f32));
        }
    }
}
