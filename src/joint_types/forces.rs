//! The forces of joints, and joints that break.

use super::list::look_again;
use crate::limits;
use crate::solver::{COORDINATES, JointConstraint};
use bevy_ecs::prelude::*;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::{Reflect, std_traits::ReflectDefault};
use glam::Vec3;

/// Force and torque of a joint on body 2 in the last step; body 1 gets the opposite. Drystone writes it. Zero while the joint is disabled.
/// It also has the [`angle`](Self::angle) of the joint.
///
/// For bodies that sleep they are those with which they came to rest.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq)]
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
#[component(clone_behavior = Ignore)]
pub struct JointForces {
    /// The mean force at the anchor on body 2 over the step, N, world axes.
    pub force: Vec3,
    /// The mean torque on body 2 in addition to that of the force, N·m, world axes.
    pub torque: Vec3,
    /// The largest magnitude during the step of the force, N, filtered by a low-pass with the time constant [`BreakForce::response`]. It
    /// does not depend on the length of a step, and a blow that lasts a substep does not count much.
    pub filtered_force: f32,
    /// The largest magnitude of the torque, N·m, filtered as the force is.
    pub filtered_torque: f32,
    /// The start of the next solve: the forces along and torques about the coordinates, N and N·m.
    pub(crate) start: [f32; COORDINATES],
    /// See [`JointConstraint::rest`].
    pub(crate) rest: [f32; COORDINATES],
    /// Force and torque in the axes of the frame on body 1, filtered, N and N·m.
    pub(crate) filtered: [Vec3; 2],
    /// See [`JointConstraint::late`].
    pub(crate) late: [Vec3; 2],
    /// See [`JointConstraint::angles`].
    #[cfg_attr(feature = "serde", serde(default))]
    pub(crate) angles: Option<Vec3>,
}

impl JointForces {
    /// The angle of a [`RevoluteJoint`](crate::joint::RevoluteJoint) or the twist of a [`SphericalJoint`](crate::joint::SphericalJoint) at
    /// the end of the last step, rad, with all its turns. See [`angles`](Self::angles).
    pub fn angle(&self) -> Option<f32> {
        self.angles.map(|angles| angles.x)
    }

    /// The rotation of a [`GenericJoint`](crate::joint::GenericJoint) about its three axes at the end of the last step, rad. The angle that
    /// counts turns comes with all of them, the others are zero then.
    ///
    /// `None` before the first step, and of joints whose rotations are all locked, or free about several axes without a limit, motor or
    /// spring. A disabled joint keeps its angles; so it knows its turns when it acts again.
    pub fn angles(&self) -> Option<Vec3> {
        self.angles
    }

    /// No forces, at the same angles.
    pub(crate) fn without_forces(&self) -> Self {
        Self {
            angles: self.angles,
            ..Self::default()
        }
    }

    /// The result of a solve.
    pub(crate) fn of(solved: &JointConstraint) -> Self {
        let [force, torque] = solved.mean;
        Self {
            force,
            torque,
            filtered_force: solved.peak[0],
            filtered_torque: solved.peak[1],
            start: solved.forces,
            rest: solved.rest,
            filtered: solved.filtered,
            late: solved.late,
            // Those of a solve that failed are no numbers.
            angles: solved.angles.filter(|angles| angles.is_finite()),
        }
    }
}

/// Makes a joint break when its force or torque exceeds a maximum: [`JointBroke`](crate::joint::JointBroke) is sent, and the joint gets
/// [`JointDisabled`](super::JointDisabled). Remove that component to mend it.
///
/// Forces are filtered, so that a joint breaks at the same load whatever the length of a step is, and not by a blow that lasts a substep.
///
/// ```
/// use bevy_transform::components::Transform;
/// use drystone::prelude::*;
///
/// # let mut app = bevy_app::App::new();
/// # app.add_plugins(DrystonePlugins::default());
/// # let world = app.world_mut();
/// let lamp = (RigidBody::Dynamic, Collider::ball(0.2), Mass(3.0));
/// let lamp = world.spawn((lamp, Transform::from_xyz(0.0, 2.0, 0.0))).id();
/// let hook = world.spawn((FixedJoint::new(None, lamp), BreakForce::new(50.0))).id();
/// for _ in 0..60 {
///     drystone::step(world, 1.0 / 60.0).unwrap();
/// }
/// assert!(!world.entity(hook).contains::<JointDisabled>());
/// world.entity_mut(lamp).insert(Mass(6.0));
/// for _ in 0..60 {
///     drystone::step(world, 1.0 / 60.0).unwrap();
/// }
/// assert!(world.entity(hook).contains::<JointDisabled>());
/// assert!(world.get::<Transform>(lamp).unwrap().translation.y < 1.0);
/// ```
#[derive(Component, Clone, Copy, Debug, PartialEq)]
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
#[component(on_remove = look_again)]
pub struct BreakForce {
    /// Maximum force, N. Default: infinite.
    pub force: f32,
    /// Maximum torque, N·m. Default: infinite.
    pub torque: f32,
    /// Time constant of the low-pass for the forces that are compared, s. Default: 0.01.
    pub response: f32,
}

impl Default for BreakForce {
    /// A joint that does not break.
    fn default() -> Self {
        Self {
            force: f32::INFINITY,
            torque: f32::INFINITY,
            response: JointConstraint::default().filter,
        }
    }
}

impl BreakForce {
    /// Breaks above a force, N.
    pub fn new(force: f32) -> Self {
        Self {
            force,
            ..Self::default()
        }
    }

    /// Breaks above a torque, too, N·m.
    pub fn with_torque(self, torque: f32) -> Self {
        Self { torque, ..self }
    }

    /// With a time constant of the low-pass, s.
    pub fn with_response(self, response: f32) -> Self {
        Self { response, ..self }
    }

    pub(crate) fn is_valid(&self) -> bool {
        self.force >= 0.0 && self.torque >= 0.0 && limits::share_of(self.response, 1e3)
    }

    /// The load of a joint as a share of its strength, if it is larger than 1. `before` are the forces of the last step. Filtered forces
    /// outlast the relief by a neighbour that has broken, so a load that only decreases must last until the end of the step.
    pub(crate) fn exceeded_share(&self, before: &JointForces, now: &JointForces) -> Option<f32> {
        let share = |load: f32, strength: f32| {
            if load > strength {
                load / strength
            } else {
                0.0
            }
        };
        let load = |peak: f32, i: usize, strength: f32| {
            let [before, end] = [before, now].map(|forces| forces.filtered[i].length());
            let counts = peak > before || end > strength;
            if counts { share(peak, strength) } else { 0.0 }
        };
        let share =
            load(now.filtered_force, 0, self.force).max(load(now.filtered_torque, 1, self.torque));
        (share > 0.0).then_some(share)
    }
}
