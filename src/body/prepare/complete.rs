//! Part of the stage *prepare*: restores components that every body must have if the user removed them.

use crate::body::listed::{Incomplete, essentials};
use crate::body::{Pose, local_pose};
use bevy_ecs::{hierarchy::ChildOf, prelude::*};
use bevy_transform::components::Transform;

/// Restores missing components with their defaults. A body without `Transform` gets that of its pose.
pub fn complete(
    mut commands: Commands,
    incomplete: Query<(Entity, Option<&Pose>, Option<&ChildOf>), Incomplete>,
    placed: Query<(&Transform, Option<&ChildOf>)>,
) {
    for (body, pose, parent) in &incomplete {
        let pose = local_pose(pose.copied().unwrap_or_default(), parent, placed);
        let transform = pose.to_transform();
        commands
            .entity(body)
            .try_insert_if_new((transform, essentials()));
    }
}
