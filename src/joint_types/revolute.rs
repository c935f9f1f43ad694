//! The revolute joint: a hinge.

use super::builder::joint_builder;
use super::definition::{JointDefinition, JointEnds, JointType};
use super::list::look_again;
use super::{JointAnchor, JointBasis, JointForces, JointFrame, JointLimits};
use crate::body::SpawnOrder;
use crate::solver::{JointAxis, JointMotor};
use bevy_ecs::prelude::*;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::Reflect;
use glam::{Quat, Vec3};

/// A hinge: body 2 turns about one axis of body 1. For doors, wheels, drawbridges, elbows.
///
/// The angle is that of body 2 relative to body 1 about the hinge axis, right-handed, rad. It is zero where the two frames agree: with
/// frames that are not given, as the bodies are when the joint is added. It counts turns: limits and targets may lie many turns away.
/// [`JointForces::angle`] tells it. A joint begins with the angle from −π to π, or with the one in its limits if that is not.
///
/// ```
/// use bevy_transform::components::Transform;
/// use drystone::prelude::*;
///
/// # let mut app = bevy_app::App::new();
/// # app.add_plugins(DrystonePlugins::default());
/// # let world = app.world_mut();
/// let door = (RigidBody::Dynamic, Collider::cuboid(1.0, 2.0, 0.05), Mass(20.0));
/// let door = world.spawn((door, Transform::from_xyz(0.5, 1.0, 0.0), Velocity::linear(Vec3::Z))).id();
/// // Hung on the world at its left edge, it opens by up to 90°.
/// world.spawn(
///     RevoluteJoint::new(None, door)
///         .with_anchor(Vec3::Y)
///         .with_hinge_axis(Vec3::Y)
///         .with_angle_limits(-1.571, 0.0),
/// );
/// for _ in 0..120 {
///     drystone::step(world, 1.0 / 60.0).unwrap();
/// }
/// let at = world.get::<Transform>(door).unwrap().translation;
/// assert!((at.with_y(0.0).length() - 0.5).abs() < 1e-2);
/// assert!(at.z > 0.0 && (at.y - 1.0).abs() < 1e-2);
/// ```
#[derive(Component, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect), reflect(Component, Debug))]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[component(on_remove = look_again)]
#[require(JointForces, SpawnOrder)]
pub struct RevoluteJoint {
    /// The first body; `None` is the world.
    #[entities]
    pub body1: Option<Entity>,
    /// The second body; `None` is the world.
    #[entities]
    pub body2: Option<Entity>,
    /// The frame on body 1.
    pub frame1: JointFrame,
    /// The frame on body 2.
    pub frame2: JointFrame,
    /// The axis of the hinge in the frames of the joint, of any length but zero. Default: z.
    pub hinge_axis: Vec3,
    /// Limits of the angle, rad. Default: none.
    pub limits: Option<JointLimits>,
    /// A motor about the axis: rad, rad/s, N·m. Default: none.
    pub motor: Option<JointMotor>,
    /// Maximum torque of dry friction, N·m. Default: 0.
    pub friction: f32,
    /// Whether the two bodies collide with each other. Default: false.
    pub collision: bool,
}

joint_builder!(RevoluteJoint);

impl RevoluteJoint {
    /// A hinge about z between two bodies. `None` is the world.
    pub fn new(body1: impl Into<Option<Entity>>, body2: impl Into<Option<Entity>>) -> Self {
        Self {
            body1: body1.into(),
            body2: body2.into(),
            frame1: JointFrame::default(),
            frame2: JointFrame::default(),
            hinge_axis: Vec3::Z,
            limits: None,
            motor: None,
            friction: 0.0,
            collision: false,
        }
    }

    /// With an axis, in the frames of the joint. If these are not given, they are the axes of the world when the joint is added.
    pub fn with_hinge_axis(mut self, axis: Vec3) -> Self {
        self.hinge_axis = axis;
        self
    }

    /// With limits, rad, of any number of turns: 0 to 20π is a winch.
    pub fn with_angle_limits(mut self, min: f32, max: f32) -> Self {
        self.limits = Some(JointLimits { min, max });
        self
    }

    /// As [`with_angle_limits`](Self::with_angle_limits).
    pub fn with_limits(self, min: f32, max: f32) -> Self {
        self.with_angle_limits(min, max)
    }

    /// With a motor.
    pub fn with_motor(mut self, motor: JointMotor) -> Self {
        self.motor = Some(motor);
        self
    }

    /// With dry friction: the maximum torque (N·m) with which it resists motion.
    pub fn with_friction(mut self, friction: f32) -> Self {
        self.friction = friction;
        self
    }
}

impl JointType for RevoluteJoint {
    fn definition(&self) -> JointDefinition {
        let mut joint = self.locked().about(self.hinge_axis);
        joint.axes[3] = JointAxis {
            motor: self.motor,
            friction: self.friction,
            ..self.limits.unwrap_or_default().axis()
        };
        joint
    }
}
