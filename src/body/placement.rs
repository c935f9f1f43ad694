//! From `Transform` to pose and back: where a user put a body, its frame, and the velocity of a kinematic body that is moved by it.

use super::{BodyState, Pose, Velocity};
use crate::settings::{SpeedLimits, StepTime};
use bevy_ecs::{hierarchy::ChildOf, prelude::*};
use bevy_reflect::{Reflect, std_traits::ReflectDefault};
use bevy_transform::components::Transform;
use glam::Vec3;

/// Makes a change of `Transform` put a kinematic body elsewhere at once: it gets no velocity from it and carries nothing along. The next
/// step removes this component.
///
/// Other bodies are always put where their `Transform` says at once. So is a kinematic body that would be faster than
/// [`SpeedLimits`](crate::settings::SpeedLimits) allows.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Component, Debug, Default)]
#[component(storage = "SparseSet")]
pub struct Teleport;

/// The transforms of bodies and of what stands above them.
pub(super) type Placed<'w, 's> = Query<'w, 's, (&'static Transform, Option<&'static ChildOf>)>;

/// The pose a user gave the body through `Transform` (or, for a new body, through `Pose`), if it was moved. What moves a
/// parent's `Transform` between two steps moves the body too.
pub(super) fn user_pose(
    (transform, parent): (&Transform, Option<&ChildOf>),
    pose: Pose,
    new: bool,
    placed: Query<(&Transform, Option<&ChildOf>)>,
) -> Option<Pose> {
    let stays = if new {
        // A pose set by hand counts where the transform was left alone.
        *transform == Transform::IDENTITY && pose != Pose::default() && pose.is_finite()
    } else {
        // To the bit: the same sum as at the end of the last step, from the same numbers where nobody touched them. How far
        // its own or a parent's frame is from the origin does not matter then.
        let local = local_pose(pose, parent, placed);
        (local.position, local.rotation) == (transform.translation, transform.rotation)
    };
    (!stays).then(|| {
        let mut world = *transform;
        let mut above = parent;
        while let Some(ChildOf(parent)) = above
            && let Ok((transform, grandparent)) = placed.get(*parent)
        {
            world = transform.mul_transform(world);
            above = grandparent;
        }
        Pose {
            position: world.translation,
            rotation: world.rotation,
        }
    })
}

/// A pose in its parent's frame, or as it is where there is none.
pub(crate) fn local_pose(
    pose: Pose,
    parent: Option<&ChildOf>,
    placed: Query<(&Transform, Option<&ChildOf>)>,
) -> Pose {
    let Some((frame, above)) = parent.and_then(|parent| placed.get(parent.0).ok()) else {
        return pose;
    };
    let pose = local_pose(pose, above, placed);
    let back = frame.rotation.inverse();
    Pose {
        position: back * (pose.position - frame.translation) / frame.scale,
        rotation: back * pose.rotation,
    }
}

impl BodyState {
    /// Sends a kinematic body to where its `Transform` is: it has the velocity that takes it there by the end of the step. False where
    /// it would be too fast, or stands nowhere.
    pub(super) fn send(
        &mut self,
        from: Pose,
        to: Pose,
        velocity: &mut Velocity,
        time: &StepTime,
        speeds: &SpeedLimits,
    ) -> bool {
        let way = velocity_between(&from, &to, self.mass.local_center, time.whole());
        // Nobody goes anywhere from a `Pose` that somebody wrote and that is none.
        let goes = from.is_finite() && from.rotation.is_normalized() && speeds.allow(&way);
        if goes {
            self.target = Some(to);
            *velocity = way;
        }
        goes
    }
}

/// The velocity that takes a body from one pose to another in `dt` s; `center` is its centre of mass in its frame.
fn velocity_between(from: &Pose, to: &Pose, center: Vec3, dt: f32) -> Velocity {
    let turn = to.rotation * from.rotation.inverse();
    // The shorter way round.
    let turn = if turn.w < 0.0 { -turn } else { turn };
    Velocity {
        linear: (to.transform_point(center) - from.transform_point(center)) / dt,
        angular: turn.to_scaled_axis() / dt,
    }
}
