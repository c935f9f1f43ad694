//! Conversion between `Transform` and pose: the pose that a user set, its frame, and the velocity of a kinematic body that is moved by its
//! `Transform`.

use super::{BodyIndex, BodyState, CompoundCollider, Pose, Velocity};
use crate::components::put;
use crate::settings::{SpeedLimits, StepTime};
use bevy_ecs::{hierarchy::ChildOf, prelude::*};
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::{Reflect, std_traits::ReflectDefault};
use bevy_transform::components::Transform;
use glam::Vec3;
use smallvec::SmallVec;

/// Marks a kinematic body whose change of `Transform` moves it at once: it gets no velocity from the change and does not carry other bodies
/// along. The next step removes this component.
///
/// Bodies of other kinds are always moved at once. So is a kinematic body that would be faster than
/// [`SpeedLimits`](crate::settings::SpeedLimits) allows.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "bevy_reflect",
    derive(Reflect),
    reflect(Component, Debug, Default)
)]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[component(storage = "SparseSet")]
pub struct Teleport;

/// The transforms of bodies and of their ancestors.
pub(in crate::body) type Placed<'w, 's> =
    Query<'w, 's, (&'static Transform, Option<&'static ChildOf>)>;

/// The pose that the user gave the body through `Transform` (or, for a new body, through `Pose`), if the body was moved. A change of a
/// parent's `Transform` between two steps moves the body too, but for a dynamic body below a kinematic one; see
/// [`stay`](crate::children::stay).
pub(crate) fn user_pose(
    (transform, parent): (&Transform, Option<&ChildOf>),
    pose: Pose,
    new: bool,
    placed: Query<(&Transform, Option<&ChildOf>)>,
) -> Option<Pose> {
    let stays = if new {
        // A `Pose` set by hand counts if the transform still has its default.
        *transform == Transform::IDENTITY && pose != Pose::default() && pose.is_finite()
    } else {
        // The comparison is exact: an unchanged transform gives the same sum of the same numbers as at the end of the last step. Rounding
        // far from the origin therefore does not matter.
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

/// A pose in the frame of its parent, or unchanged if there is no parent.
pub(crate) fn local_pose(
    mut pose: Pose,
    parent: Option<&ChildOf>,
    placed: Query<(&Transform, Option<&ChildOf>)>,
) -> Pose {
    // A hierarchy may be deeper than the stack.
    let mut frames = SmallVec::<[&Transform; 8]>::new();
    let mut above = parent;
    while let Some(ChildOf(parent)) = above
        && let Ok((frame, grandparent)) = placed.get_inner(*parent)
    {
        frames.push(frame);
        above = grandparent;
    }
    for frame in frames.into_iter().rev() {
        let back = frame.rotation.inverse();
        pose = Pose {
            position: back * (pose.position - frame.translation) / frame.scale,
            rotation: back * pose.rotation,
        };
    }
    pose
}

/// Where the `Transform`s of an entity and of those above it put it, without scale.
pub(crate) fn transform_of(world: &World, entity: Entity) -> Pose {
    let at = |entity: Entity| world.get::<Transform>(entity).copied().unwrap_or_default();
    let (mut frame, mut below) = (at(entity), entity);
    while let Some(&ChildOf(above)) = world.get::<ChildOf>(below) {
        frame = at(above) * frame;
        below = above;
    }
    Pose {
        position: frame.translation,
        rotation: frame.rotation,
    }
}

/// The pose of a body, which may have been spawned after the last step.
pub(crate) fn pose_of(world: &World, body: Entity) -> Pose {
    let pose = world.get::<Pose>(body).copied().unwrap_or_default();
    let is_new = world.get::<BodyIndex>(body) == Some(&BodyIndex::NONE);
    match is_new && pose == Pose::default() {
        true => transform_of(world, body),
        false => pose,
    }
}

/// Where the pieces of a body are put: beside it in the hierarchy.
pub(crate) struct Beside {
    parent: Option<Entity>,
    /// Of the body, in the frame of its parent.
    transform: Transform,
    /// Scale of the parent in the world.
    scale: Vec3,
}

impl Beside {
    /// For a body at a pose.
    pub fn new(world: &World, body: Entity, pose: Pose) -> Self {
        let parent = world.get::<ChildOf>(body).map(|parent| parent.0);
        let own = world.get::<Transform>(body).filter(|_| parent.is_some());
        let scale = own.map_or(Vec3::ONE, |own| {
            let whole = world.get::<CompoundCollider>(body);
            whole.map_or(own.scale, |whole| whole.scale) / own.scale
        });
        Self {
            parent,
            transform: own.copied().unwrap_or_else(|| pose.to_transform()),
            scale,
        }
    }

    /// The transform of a piece at a point of the body's frame, m. Its scale in the world is 1.
    pub fn transform(&self, point: Vec3) -> Transform {
        let out = self.transform.rotation * point / self.scale;
        Transform {
            translation: self.transform.translation + out,
            rotation: self.transform.rotation,
            scale: self.scale.recip(),
        }
    }

    /// Gives a piece the parent of the body.
    pub fn join(&self, world: &mut World, piece: Entity) {
        if let Some(parent) = self.parent {
            put(world, piece, ChildOf(parent));
        }
    }
}

impl Pose {
    /// The transform of a body without a parent.
    pub(crate) fn to_transform(self) -> Transform {
        Transform::from_translation(self.position).with_rotation(self.rotation)
    }
}

impl BodyState {
    /// Sends a kinematic body to the pose of its `Transform`: gives it the velocity that takes it there by the end of the step. Returns
    /// false if it would be too fast, or if its pose is invalid.
    pub(in crate::body) fn send(
        &mut self,
        from: Pose,
        to: Pose,
        velocity: &mut Velocity,
        time: &StepTime,
        speeds: &SpeedLimits,
    ) -> bool {
        let way = velocity_between(&from, &to, self.mass.local_center, time.whole());
        // The user may have written an invalid `Pose`.
        let goes = from.is_finite() && from.rotation.is_normalized() && speeds.allow(&way);
        if goes {
            self.target = Some(Box::new(to));
            *velocity = way;
        }
        goes
    }
}

/// The velocity that takes a body from one pose to another in `dt` s. `center` is its centre of mass in its frame, m.
pub(crate) fn velocity_between(from: &Pose, to: &Pose, center: Vec3, dt: f32) -> Velocity {
    let turn = to.rotation * from.rotation.inverse();
    // Two rotations lead to this orientation. Take the shorter one.
    let turn = if turn.w < 0.0 { -turn } else { turn };
    Velocity {
        linear: (to.transform_point(center) - from.transform_point(center)) / dt,
        angular: turn.to_scaled_axis() / dt,
    }
}
