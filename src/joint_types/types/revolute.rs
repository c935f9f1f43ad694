//! The revolute joint: a hinge.

use super::joint_type::joint_type;
use crate::joint_types::JointLimits;
use crate::joint_types::definition::{JointDefinition, JointEnds, JointType};
use crate::solver::{JointAxis, JointMotor};
use bevy_ecs::prelude::*;
use glam::Vec3;

joint_type! {
    /// A hinge: body 2 turns about one axis of body 1. For doors, wheels, drawbridges, elbows.
    ///
    /// The angle is that of body 2 relative to body 1 about the hinge axis, right-handed, rad. It is zero where the two frames agree: with
    /// frames that are not given, as the bodies are when the joint is added. It counts turns: limits and targets may lie many turns away.
    /// [`JointForces::angle`](crate::joint::JointForces::angle) tells it. A joint begins with the angle from −π to π, or with the one in
    /// its limits if that is not.
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
    pub struct RevoluteJoint {
        /// The axis of the hinge in the frames of the joint, of any length but zero. Default: z.
        pub hinge_axis: Vec3 = Vec3::Z,
        /// Limits of the angle, rad. Default: none.
        pub limits: Option<JointLimits> = None,
        /// A motor about the axis: rad, rad/s, N·m. Default: none.
        pub motor: Option<JointMotor> = None,
        /// Maximum torque of dry friction, N·m. Default: 0.
        pub friction: f32 = 0.0,
    }

    /// A hinge about z between two bodies. `None` is the world.
    pub fn new;
}

impl RevoluteJoint {
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
