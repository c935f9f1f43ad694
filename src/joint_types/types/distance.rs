//! The distance joint: a rod or a rope.

use super::joint_type::joint_type;
use crate::joint_types::JointLimits;
use crate::joint_types::definition::{Distance, JointDefinition, JointEnds, JointType};
use crate::solver::JointAxis;
use bevy_ecs::prelude::*;

joint_type! {
    /// Keeps the distance of two anchors within limits: a rod if minimum and maximum are equal, a rope if there is only a maximum.
    ///
    /// Without limits it is a rod of the length that it has when it is added. Anchors that are not given are at the centres of mass.
    ///
    /// ```
    /// use bevy_transform::components::Transform;
    /// use drystone::prelude::*;
    ///
    /// # let mut app = bevy_app::App::new();
    /// # app.add_plugins(DrystonePlugins::default());
    /// # let world = app.world_mut();
    /// let bucket = (RigidBody::Dynamic, Collider::ball(0.2), Mass(5.0));
    /// let bucket = world.spawn((bucket, Transform::from_xyz(0.0, 2.5, 0.0))).id();
    /// // A rope of 2 m, slack at first.
    /// let rope = world
    ///     .spawn(DistanceJoint::new(None, bucket).with_local_anchor1(Vec3::Y * 3.0).with_max_distance(2.0))
    ///     .id();
    /// drystone::step(world, 1.0 / 60.0).unwrap();
    /// assert_eq!(world.get::<JointForces>(rope).unwrap().force, Vec3::ZERO);
    /// for _ in 0..180 {
    ///     drystone::step(world, 1.0 / 60.0).unwrap();
    /// }
    /// let height = world.get::<Transform>(bucket).unwrap().translation.y;
    /// assert!((height - 1.0).abs() < 0.01);
    /// ```
    pub struct DistanceJoint {
        /// Limits of the distance, m; the maximum must be above zero. Default: the distance when the joint is added.
        pub limits: Option<JointLimits> = None,
    }

    /// A rod between two bodies. `None` is the world.
    pub fn new;
}

impl DistanceJoint {
    /// With limits, m.
    pub fn with_limits(mut self, min: f32, max: f32) -> Self {
        self.limits = Some(JointLimits { min, max });
        self
    }

    /// A rope: with a maximum of the distance only, m.
    pub fn with_max_distance(mut self, max: f32) -> Self {
        let min = self.limits.map_or(0.0, |limits| limits.min);
        self.limits = Some(JointLimits { min, max });
        self
    }

    /// With a minimum of the distance, m.
    pub fn with_min_distance(mut self, min: f32) -> Self {
        let max = self.limits.map_or(f32::INFINITY, |limits| limits.max);
        self.limits = Some(JointLimits { min, max });
        self
    }

    /// A rod of this length, m.
    pub fn with_length(self, length: f32) -> Self {
        self.with_limits(length, length)
    }
}

impl JointType for DistanceJoint {
    fn definition(&self) -> JointDefinition {
        JointDefinition {
            axes: [JointAxis::FREE; 6],
            distance: Some(match self.limits {
                Some(limits) => Distance::Axis(limits.axis()),
                None => Distance::Untaken(None),
            }),
            ..self.locked()
        }
    }

    fn take_length(&mut self, distance: f32) {
        if self.limits.is_none() {
            self.limits = Some(JointLimits::new(distance, distance));
        }
    }
}
