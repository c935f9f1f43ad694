//! Part of the stage *prepare*: what every body must have, and somebody took off, is put back.

use super::{Age, BodyIndex, MassProperties, Pose, RigidBody, Sleeping, Velocity, local_pose};
use bevy_ecs::{hierarchy::ChildOf, prelude::*};
use bevy_transform::components::Transform;

type Incomplete = (
    With<RigidBody>,
    Or<(
        Without<Pose>,
        Without<Velocity>,
        Without<MassProperties>,
        Without<Sleeping>,
        Without<BodyIndex>,
        Without<Age>,
        Without<Transform>,
    )>,
);

/// See the module's text. A body that lost its `Transform` gets that of its pose.
pub fn complete(
    mut commands: Commands,
    incomplete: Query<(Entity, Option<&Pose>, Option<&ChildOf>), Incomplete>,
    placed: Query<(&Transform, Option<&ChildOf>)>,
) {
    for (body, pose, parent) in &incomplete {
        let pose = local_pose(pose.copied().unwrap_or_default(), parent, placed);
        commands.entity(body).insert_if_new((
            Transform::from_translation(pose.position).with_rotation(pose.rotation),
            Pose::default(),
            Velocity::default(),
            MassProperties::default(),
            Sleeping::default(),
            BodyIndex::NONE,
            Age::NONE,
        ));
    }
}
