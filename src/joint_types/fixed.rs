//! The fixed joint.

use super::builder::joint_builder;
use super::definition::{JointDefinition, JointEnds, JointType};
use super::list::look_again;
use super::{JointAnchor, JointBasis, JointForces, JointFrame};
use crate::body::SpawnOrder;
use bevy_ecs::prelude::*;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::Reflect;
use glam::{Quat, Vec3};

/// Holds two bodies together as if they were one: no translation, no rotation. Unlike a compound it may break
/// ([`BreakForce`](super::BreakForce)), and its force can be read ([`JointForces`]).
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
#[derive(Component, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect), reflect(Component, Debug))]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[component(on_remove = look_again)]
#[require(JointForces, SpawnOrder)]
pub struct FixedJoint {
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
    /// Whether the two bodies collide with each other. Default: false.
    pub collision: bool,
}

joint_builder!(FixedJoint);

impl FixedJoint {
    /// Holds two bodies as they are when the joint is added. `None` is the world.
    pub fn new(body1: impl Into<Option<Entity>>, body2: impl Into<Option<Entity>>) -> Self {
        Self {
            body1: body1.into(),
            body2: body2.into(),
            frame1: JointFrame::default(),
            frame2: JointFrame::default(),
            collision: false,
        }
    }
}

impl JointType for FixedJoint {
    fn definition(&self) -> JointDefinition {
        self.locked()
    }
}
