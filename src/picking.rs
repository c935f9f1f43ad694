//! A backend for [`bevy_picking`]: pointers hit bodies by their shapes.
//!
//! With [`PhysicsPickingPlugin`] beside Bevy's own picking plugins, `Pointer` events reach bodies: what is seen is what is hit, as the last step left
//! it. Entities with `Pickable::IGNORE` are passed over; an entity whose `Pickable` does not block what is below lets the ray through.

use crate::RefreshSystems;
use crate::query::{QueryFilter, SpatialQuery};
use bevy_app::{App, Plugin, PreUpdate};
use bevy_camera::Camera;
use bevy_ecs::message::MessageWriter;
use bevy_ecs::prelude::*;
use bevy_picking::backend::ray::RayMap;
use bevy_picking::backend::{HitData, PointerHits};
use bevy_picking::{Pickable, PickingSystems};

/// See the module's text. It is in none of the plugins of [`DrystonePlugins`](crate::DrystonePlugins).
pub struct PhysicsPickingPlugin;

impl Plugin for PhysicsPickingPlugin {
    fn build(&self, app: &mut App) {
        let pick = pick.in_set(PickingSystems::Backend).after(RefreshSystems);
        app.add_systems(PreUpdate, pick);
    }
}

/// How far pointers reach, m.
const REACH: f32 = 1e5;

/// Tells what each pointer hits.
pub fn pick(
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
        // A camera that looks from nowhere sees nothing.
        let found = world
            .cast_ray_through(ray, REACH, &filter)
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
