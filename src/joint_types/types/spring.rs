//! The spring joint.

use super::joint_type::joint_type;
use crate::joint_types::definition::{Distance, JointDefinition, JointEnds, JointType};
use crate::solver::{JointAxis, JointMotor};
use bevy_ecs::prelude::*;

joint_type! {
    /// A spring with a damper between two anchors, along the line between them.
    ///
    /// Without a rest length it is relaxed as it is when it is added. Anchors that are not given are at the centres of mass.
    ///
    /// ```
    /// use bevy_transform::components::Transform;
    /// use drystone::prelude::*;
    ///
    /// # let mut app = bevy_app::App::new();
    /// # app.add_plugins(DrystonePlugins::default());
    /// # let world = app.world_mut();
    /// let weight = (RigidBody::Dynamic, Collider::ball(0.2), Mass(2.0));
    /// let weight = world.spawn((weight, Transform::from_xyz(0.0, 2.0, 0.0))).id();
    /// world.spawn(
    ///     SpringJoint::new(None, weight)
    ///         .with_local_anchor1(Vec3::Y * 3.0)
    ///         .with_stiffness(200.0)
    ///         .with_damping(40.0),
    /// );
    /// for _ in 0..240 {
    ///     drystone::step(world, 1.0 / 60.0).unwrap();
    /// }
    /// // It has stretched by its weight over its stiffness.
    /// let height = world.get::<Transform>(weight).unwrap().translation.y;
    /// assert!((height - (2.0 - 2.0 * 9.81 / 200.0)).abs() < 2e-3);
    /// ```
    pub struct SpringJoint {
        /// Length at which it exerts no force, m. Default: the distance when the joint is added.
        pub rest_length: Option<f32> = None,
        /// Force per metre of stretch, N/m. Default: 1000.
        pub stiffness: f32 = 1000.0,
        /// Force per speed of stretching, N·s/m. Default: 0.
        pub damping: f32 = 0.0,
        /// Maximum force, N. Default: infinite.
        pub max_force: f32 = f32::INFINITY,
    }

    /// A spring between two bodies. `None` is the world.
    pub fn new;
}

impl SpringJoint {
    /// With a rest length, m.
    pub fn with_rest_length(mut self, length: f32) -> Self {
        self.rest_length = Some(length);
        self
    }

    /// With a stiffness, N/m.
    pub fn with_stiffness(mut self, stiffness: f32) -> Self {
        self.stiffness = stiffness;
        self
    }

    /// With a damping, N·s/m.
    pub fn with_damping(mut self, damping: f32) -> Self {
        self.damping = damping;
        self
    }

    /// With a maximum force, N.
    pub fn with_max_force(mut self, max_force: f32) -> Self {
        self.max_force = max_force;
        self
    }
}

impl JointType for SpringJoint {
    fn definition(&self) -> JointDefinition {
        let motor = JointMotor {
            target_position: self.rest_length.unwrap_or(0.0),
            target_velocity: 0.0,
            stiffness: self.stiffness,
            damping: self.damping,
            max_force: self.max_force,
        };
        JointDefinition {
            axes: [JointAxis::FREE; 6],
            distance: Some(match self.rest_length {
                Some(_) => Distance::Spring(motor),
                None => Distance::Untaken(Some(motor)),
            }),
            ..self.locked()
        }
    }

    fn take_length(&mut self, distance: f32) {
        self.rest_length.get_or_insert(distance);
    }
}
