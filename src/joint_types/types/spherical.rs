//! The spherical joint: a ball in a socket.

use super::joint_type::joint_type;
use crate::joint_types::JointLimits;
use crate::joint_types::definition::{JointDefinition, JointEnds, JointType};
use crate::solver::JointAxis;
use bevy_ecs::prelude::*;
use glam::Vec3;

joint_type! {
    /// A ball in a socket: the anchors stay together, and the bodies turn freely about them. For links of a chain, shoulders, hips,
    /// pendulums.
    ///
    /// Two kinds of limits bound the rotation of body 2 relative to body 1. With a swing cone, the *swing* is the angle between the twist
    /// axes of both bodies, the same in all directions, and the *twist* is the rotation about that axis with all its turns, which does not
    /// depend on the swing. Swing limits are a box: the two axes across the twist axis have limits of their own. Without a cone they are of
    /// the parts of the rotation vector, and so is the twist; with one, or with limits of the twist alone that reach beyond a quarter turn,
    /// of the tilt of the twist axis.
    ///
    /// ```
    /// use bevy_transform::components::Transform;
    /// use drystone::prelude::*;
    ///
    /// # let mut app = bevy_app::App::new();
    /// # app.add_plugins(DrystonePlugins::default());
    /// # let world = app.world_mut();
    /// let ball = (RigidBody::Dynamic, Collider::ball(0.2), Mass(5.0));
    /// let ball = world.spawn((ball, Transform::from_xyz(1.0, 3.0, 0.0))).id();
    /// // A pendulum of 1 m, let go from the side.
    /// world.spawn(SphericalJoint::new(None, ball).with_anchor(Vec3::Y * 3.0));
    /// for _ in 0..30 {
    ///     drystone::step(world, 1.0 / 60.0).unwrap();
    ///     let at = world.get::<Transform>(ball).unwrap().translation;
    ///     assert!((at.distance(Vec3::Y * 3.0) - 1.0).abs() < 5e-3);
    /// }
    /// ```
    ///
    /// An arm that swings by 60° from where it hangs, and turns by 30° about itself:
    ///
    /// ```
    /// use bevy_transform::components::Transform;
    /// use drystone::prelude::*;
    ///
    /// # let mut app = bevy_app::App::new();
    /// # app.add_plugins(DrystonePlugins::default());
    /// # let world = app.world_mut();
    /// let arm = (RigidBody::Dynamic, Collider::capsule(0.1, 0.6), Mass(4.0));
    /// let arm = world.spawn((arm, Transform::from_xyz(0.0, -0.4, 0.0), Velocity::linear(Vec3::X * 6.0))).id();
    /// world.spawn(
    ///     SphericalJoint::new(None, arm)
    ///         .with_anchor(Vec3::ZERO)
    ///         .with_swing_cone(60f32.to_radians())
    ///         .with_twist_limits(-0.5, 0.5),
    /// );
    /// let mut highest = 0.0f32;
    /// for _ in 0..60 {
    ///     drystone::step(world, 1.0 / 60.0).unwrap();
    ///     let along = world.get::<Transform>(arm).unwrap().rotation * Vec3::Y;
    ///     highest = highest.max(along.angle_between(Vec3::Y).to_degrees());
    /// }
    /// assert!((59.0..60.5).contains(&highest), "{highest}");
    /// ```
    pub struct SphericalJoint {
        /// The axis of twist in the frames of the joint, of any length but zero. Default: y.
        pub twist_axis: Vec3 = Vec3::Y,
        /// Limits of the rotation about the twist axis, rad. Default: none.
        pub twist_limits: Option<JointLimits> = None,
        /// Limits of the rotation about each of the two axes across, rad: a box. Default: none.
        pub swing_limits: Option<JointLimits> = None,
        /// Largest angle between the twist axes of both bodies, rad, above 0 and at most π: a cone. Default: none.
        pub swing_cone: Option<f32> = None,
        /// Maximum torque of dry friction about each axis, N·m. Default: 0.
        pub friction: f32 = 0.0,
    }

    /// A ball in a socket between two bodies. `None` is the world.
    pub fn new;
}

impl SphericalJoint {
    /// With an axis of twist, in the frames of the joint. If these are not given, they are the axes of the world when the joint is added.
    pub fn with_twist_axis(mut self, axis: Vec3) -> Self {
        self.twist_axis = axis;
        self
    }

    /// With limits of the rotation about the twist axis, rad.
    pub fn with_twist_limits(mut self, min: f32, max: f32) -> Self {
        self.twist_limits = Some(JointLimits { min, max });
        self
    }

    /// With limits of the rotation about each of the two axes across the twist axis, rad.
    pub fn with_swing_limits(mut self, min: f32, max: f32) -> Self {
        self.swing_limits = Some(JointLimits { min, max });
        self
    }

    /// With a cone in which the twist axis stays: half its opening angle (rad), above 0 and at most π.
    pub fn with_swing_cone(mut self, angle: f32) -> Self {
        self.swing_cone = Some(angle);
        self
    }

    /// With dry friction: the maximum torque (N·m) about each axis with which it resists motion.
    pub fn with_friction(mut self, friction: f32) -> Self {
        self.friction = friction;
        self
    }
}

impl JointType for SphericalJoint {
    fn definition(&self) -> JointDefinition {
        let mut joint = self.locked().about(self.twist_axis);
        joint.swing = self.swing_cone;
        let limits = [self.twist_limits, self.swing_limits, self.swing_limits];
        for (axis, limits) in joint.axes[3..].iter_mut().zip(limits) {
            *axis = JointAxis {
                friction: self.friction,
                ..limits.unwrap_or_default().axis()
            };
        }
        joint
    }
}
