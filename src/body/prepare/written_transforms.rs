//! Part of the stage *prepare* and of a refresh: finds the bodies whose `Transform` was written.
//!
//! Bevy has no summary tick for `Transform`, so the change tick of each row is read, which is most of a step of a large world at rest. So
//! there is one search, for scales as well as for poses.

use super::rows::look;
use crate::body::{
    BodyIndex, Inactive, Pose, RigidBody, collider::Collider, parts::CompoundCollider,
};
use bevy_ecs::hierarchy::ChildOf;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use glam::Vec3;

/// Bodies without a parent whose `Transform` was written and no longer fits. They are found at the start of *prepare*, which takes them.
#[derive(Resource, Debug, Default)]
#[doc(hidden)]
pub struct WrittenTransforms {
    /// Bodies whose scale is not that of their shape.
    pub(crate) rescaled: Vec<Entity>,
    /// Inactive bodies that have another pose. Interpolation writes the transforms of all bodies in every frame, but those of inactive
    /// bodies keep their value.
    pub(in crate::body) moved: Vec<Entity>,
}

type Body<'w> = (
    Entity,
    Ref<'w, Transform>,
    Option<(&'w Pose, &'w BodyIndex)>,
    Option<&'w Inactive>,
    Option<&'w Collider>,
    Option<&'w CompoundCollider>,
);

/// Finds the bodies whose `Transform` was written since the system ran last.
pub fn find_written_transforms(
    mut written: ResMut<WrittenTransforms>,
    bodies: Query<Body, (With<RigidBody>, Without<ChildOf>)>,
) {
    let WrittenTransforms { rescaled, moved } = &mut *written;
    rescaled.clear();
    moved.clear();
    let tables = bodies.contiguous_iter();
    for table in tables.expect("all of it is stored in tables") {
        let (entities, transforms, places, inactive, colliders, compounds) = table;
        let has_shape = colliders.is_some() || compounds.is_some();
        let places = places.filter(|_| inactive.is_some());
        look(transforms, None, |row, transform| {
            let scale = compounds.map_or(Vec3::ONE, |compounds| compounds[row].scale());
            if has_shape && transform.scale != scale {
                rescaled.push(entities[row]);
            }
            // A body that was spawned asleep has no pose before it is in the table.
            if let Some((poses, slots)) = places
                && slots[row] != BodyIndex::NONE
                && !poses[row].is_drawn_by(transform)
            {
                moved.push(entities[row]);
            }
        });
    }
}

impl Pose {
    fn is_drawn_by(&self, transform: &Transform) -> bool {
        (self.position, self.rotation) == (transform.translation, transform.rotation)
    }
}
