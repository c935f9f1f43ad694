//! The cylindrical joint: a bar in a sleeve.

use super::joint_type::joint_type;
use crate::joint_types::JointLimits;
use crate::joint_types::definition::{JointDefinition, JointEnds, JointType};
use crate::solver::{JointAxis, JointMotor};
use bevy_ecs::prelude::*;
use glam::Vec3;

joint_type! {
    /// A bar in a sleeve: body 2 slides along one axis of body 1 and turns about it. For bolts, pistons, lances, revolving lifts.
    ///
    /// The position is that of the anchor of body 2 along the axis, from the anchor of body 1, m; the angle is that of body 2 about it,
    /// rad.
    ///
    /// ```
    /// use bevy_transform::components::Transform;
    /// use drystone::prelude::*;
    ///
    /// # let mut app = bevy_app::App::new();
    /// # app.add_plugins(DrystonePlugins::default());
    /// # let world = app.world_mut();
    /// let bolt = (RigidBody::Dynamic, Collider::cuboid(0.4, 0.04, 0.04), Mass(2.0), GravityScale(0.0));
    /// let velocity = Velocity { linear: Vec3::X, angular: Vec3::X * 3.0 };
    /// let bolt = world.spawn((bolt, Transform::from_xyz(0.0, 1.0, 0.0), velocity)).id();
    /// // It slides by 0.2 m at most, and turns freely.
    /// world.spawn(CylindricalJoint::new(None, bolt).with_slide_limits(0.0, 0.2));
    /// for _ in 0..60 {
    ///     drystone::step(world, 1.0 / 60.0).unwrap();
    /// }
    /// let at = world.get::<Transform>(bolt).unwrap();
    /// assert!((at.translation.x - 0.2).abs() < 2e-3);
    /// assert!((at.rotation.to_scaled_axis() - Vec3::X * 3.0).length() < 1e-2);
    /// ```
    pub struct CylindricalJoint {
        /// The axis in the frames of the joint, of any length but zero. Default: x.
        pub axis: Vec3 = Vec3::X,
        /// Limits of the position, m. Default: none.
        pub slide_limits: Option<JointLimits> = None,
        /// Limits of the angle, rad. Default: none.
        pub angle_limits: Option<JointLimits> = None,
        /// A motor along the axis: m, m/s, N. Default: none.
        pub slide_motor: Option<JointMotor> = None,
        /// A motor about the axis: rad, rad/s, N·m. Default: none.
        pub angle_motor: Option<JointMotor> = None,
        /// Maximum force of dry friction along the axis, N. Default: 0.
        pub slide_friction: f32 = 0.0,
        /// Maximum torque of dry friction about the axis, N·m. Default: 0.
        pub angle_friction: f32 = 0.0,
    }

    /// A bar that slides along x and turns about it. `None` is the world.
    pub fn new;
}

impl CylindricalJoint {
    /// With an axis, in the frames of the joint. If these are not given, they are the axes of the world when the joint is added.
    pub fn with_axis(mut self, axis: Vec3) -> Self {
        self.axis = axis;
        self
    }

    /// With limits of the position, m.
    pub fn with_slide_limits(mut self, min: f32, max: f32) -> Self {
        self.slide_limits = Some(JointLimits { min, max });
        self
    }

    /// With limits of the angle, rad, of any number of turns.
    pub fn with_angle_limits(mut self, min: f32, max: f32) -> Self {
        self.angle_limits = Some(JointLimits { min, max });
        self
    }

    /// With a motor along the axis.
    pub fn with_slide_motor(mut self, motor: JointMotor) -> Self {
        self.slide_motor = Some(motor);
        self
    }

    /// With a motor about the axis.
    pub fn with_angle_motor(mut self, motor: JointMotor) -> Self {
        self.angle_motor = Some(motor);
        self
    }

    /// With dry friction: the maximum force along the axis (N) and torque about it (N·m) with which it resists motion.
    pub fn with_friction(mut self, force: f32, torque: f32) -> Self {
        (self.slide_friction, self.angle_friction) = (force, torque);
        self
    }
}

impl JointType for CylindricalJoint {
    fn definition(&self) -> JointDefinition {
        let mut joint = self.locked().about(self.axis);
        joint.axes[0] = JointAxis {
            motor: self.slide_motor,
            friction: self.slide_friction,
            ..self.slide_limits.unwrap_or_default().axis()
        };
        joint.axes[3] = JointAxis {
            motor: self.angle_motor,
            friction: self.angle_friction,
            ..self.angle_limits.unwrap_or_default().axis()
        };
        joint
    }
}
