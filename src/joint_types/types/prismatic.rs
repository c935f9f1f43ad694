//! The prismatic joint: a slider.

use super::joint_type::joint_type;
use crate::joint_types::JointLimits;
use crate::joint_types::definition::{JointDefinition, JointEnds, JointType};
use crate::solver::{JointAxis, JointMotor};
use bevy_ecs::prelude::*;
use glam::Vec3;

joint_type! {
    /// A slider: body 2 moves along one axis of body 1 and does not turn. For lifts, drawers, portcullises, pistons.
    ///
    /// The position is that of the anchor of body 2 along the slider axis, from the anchor of body 1, m.
    ///
    /// ```
    /// use bevy_transform::components::Transform;
    /// use drystone::prelude::*;
    ///
    /// # let mut app = bevy_app::App::new();
    /// # app.add_plugins(DrystonePlugins::default());
    /// # let world = app.world_mut();
    /// let lift = (RigidBody::Dynamic, Collider::cuboid(1.0, 0.1, 1.0), Mass(100.0));
    /// let lift = world.spawn((lift, Transform::from_xyz(0.0, 1.0, 0.0))).id();
    /// // It goes up at 0.5 m/s, and 2 m at most.
    /// world.spawn(
    ///     PrismaticJoint::new(None, lift)
    ///         .with_slider_axis(Vec3::Y)
    ///         .with_limits(0.0, 2.0)
    ///         .with_motor(JointMotor::velocity(0.5, 5_000.0)),
    /// );
    /// for _ in 0..60 {
    ///     drystone::step(world, 1.0 / 60.0).unwrap();
    /// }
    /// let height = world.get::<Transform>(lift).unwrap().translation.y;
    /// assert!((height - 1.5).abs() < 0.02);
    /// ```
    pub struct PrismaticJoint {
        /// The axis of the slider in the frames of the joint, of any length but zero. Default: x.
        pub slider_axis: Vec3 = Vec3::X,
        /// Limits of the position, m. Default: none.
        pub limits: Option<JointLimits> = None,
        /// A motor along the axis: m, m/s, N. Default: none.
        pub motor: Option<JointMotor> = None,
        /// Maximum force of dry friction, N. Default: 0.
        pub friction: f32 = 0.0,
    }

    /// A slider along x between two bodies. `None` is the world.
    pub fn new;
}

impl PrismaticJoint {
    /// With an axis, in the frames of the joint. If these are not given, they are the axes of the world when the joint is added.
    pub fn with_slider_axis(mut self, axis: Vec3) -> Self {
        self.slider_axis = axis;
        self
    }

    /// With limits, m.
    pub fn with_limits(mut self, min: f32, max: f32) -> Self {
        self.limits = Some(JointLimits { min, max });
        self
    }

    /// With a motor.
    pub fn with_motor(mut self, motor: JointMotor) -> Self {
        self.motor = Some(motor);
        self
    }

    /// With dry friction: the maximum force (N) with which it resists motion.
    pub fn with_friction(mut self, friction: f32) -> Self {
        self.friction = friction;
        self
    }
}

impl JointType for PrismaticJoint {
    fn definition(&self) -> JointDefinition {
        let mut joint = self.locked().about(self.slider_axis);
        joint.axes[0] = JointAxis {
            motor: self.motor,
            friction: self.friction,
            ..self.limits.unwrap_or_default().axis()
        };
        joint
    }
}
