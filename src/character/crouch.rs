//! Crouching: a lower collider with the feet in the same place, and getting up where there is room.

use super::{Character, CharacterState};
use crate::body::{Pose, collider::Collider};
use crate::query::{QueryFilter, SpatialQuery};
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use glam::Vec3;
use parry3d::shape::TypedShape;

/// Lowers the colliders of characters that crouch, and raises those of characters that get up and have room for it.
pub fn crouch(
    world: SpatialQuery,
    mut characters: Query<(
        Entity,
        &Character,
        &mut CharacterState,
        &mut Transform,
        &mut Collider,
    )>,
) {
    for (entity, character, mut state, mut transform, mut collider) in &mut characters {
        if character.crouches == state.full_height.is_some() {
            continue;
        }
        let now = 2.0 * collider.half_extents().y;
        let next = match state.full_height {
            None => character.crouch_height.min(now),
            Some(full) => full,
        };
        let Some(shape) = with_height(&collider, next) else {
            continue;
        };
        let rise = 0.5 * (next - now) * transform.scale.y;
        let place = Pose {
            position: transform.translation + rise * (transform.rotation * Vec3::Y),
            rotation: transform.rotation,
        };
        if rise > 0.0 && !has_room(&world, entity, &shape, place, transform.scale) {
            continue;
        }
        state.full_height = match state.full_height {
            None => Some(now),
            Some(_) => None,
        };
        transform.translation = place.position;
        *collider = shape;
    }
}

fn has_room(
    world: &SpatialQuery,
    character: Entity,
    shape: &Collider,
    place: Pose,
    scale: Vec3,
) -> bool {
    let Some(body) = world.state(character) else {
        return true;
    };
    let alone = [character];
    let filter = QueryFilter::default()
        .excluding(&alone)
        .with_layers(body.properties.layers);
    let scaled = shape.scaled(scale);
    let overlaps = scaled.map(|shape| world.overlaps(&shape, place, 0.0, &filter));
    matches!(overlaps, Ok(Ok(overlaps)) if overlaps.is_empty())
}

/// An upright capsule, cylinder or cuboid with another height, m. `None` for other shapes.
fn with_height(shape: &Collider, height: f32) -> Option<Collider> {
    match shape.shape().as_typed_shape() {
        TypedShape::Capsule(capsule) => {
            /// A capsule has some length between its ends, as a share of the radius.
            const LEAST_LENGTH: f32 = 0.01;
            let radius = capsule.radius;
            let length = (height - 2.0 * radius).max(LEAST_LENGTH * radius);
            Some(Collider::capsule(radius, length))
        }
        TypedShape::Cylinder(cylinder) => Some(Collider::cylinder(cylinder.radius, height)),
        TypedShape::Cuboid(cuboid) => {
            let [x, _, z] = (2.0 * cuboid.half_extents).to_array();
            Some(Collider::cuboid(x, height, z))
        }
        _ => None,
    }
}
