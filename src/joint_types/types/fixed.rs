//! The fixed joint.

use super::joint_type::joint_type;
use crate::joint_types::definition::{JointDefinition, JointEnds, JointType};
use bevy_ecs::prelude::*;

joint_type! {
    /// Holds two bodies together as if they were one: no translation, no rotation. Unlike a compound it may break
    /// ([`BreakForce`](crate::joint::BreakForce)), and its force can be read ([`JointForces`](crate::joint::JointForces)).
    ///
    /// Without frames it holds the bodies as they are when it is added.
    ///
    /// ```
    /// use bevy_transform::components::Transform;
    /// use drystone::prelude::*;
    ///
    /// # let mut app = bevy_app::App::new();
    /// # app.add_plugins(DrystonePlugins::default());
    /// # let world = app.world_mut();
    /// let beam = (RigidBody::Dynamic, Collider::cuboid(1.0, 0.1, 0.1), Mass(10.0));
    /// let beam = world.spawn((beam, Transform::from_xyz(0.5, 2.0, 0.0))).id();
    /// // The beam sticks out of a wall that is not there: the world.
    /// let joint = world.spawn(FixedJoint::new(None, beam).with_anchor(Vec3::Y * 2.0)).id();
    /// for _ in 0..60 {
    ///     drystone::step(world, 1.0 / 60.0).unwrap();
    /// }
    /// let forces = world.get::<JointForces>(joint).unwrap();
    /// assert!((forces.force.y - 98.1).abs() < 0.1);
    /// assert!((forces.torque.z - 0.5 * 98.1).abs() < 0.1);
    /// ```
    pub struct FixedJoint {
    }

    /// Holds two bodies as they are when the joint is added. `None` is the world.
    pub fn new;
}

impl JointType for FixedJoint {
    fn definition(&self) -> JointDefinition {
        self.locked()
    }
}
