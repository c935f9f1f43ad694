//! Surfaces that move although their body does not, such as conveyor belts and tracks.

use crate::body::{BodyState, KeptProperty, limits};
use crate::diagnosis::BodyProblem;
use bevy_ecs::prelude::*;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::{Reflect, std_traits::ReflectDefault};
use glam::Vec3;

/// Velocity of the surface of a body against the body itself, m/s, in the axes of the body. Friction carries other bodies along with it, as
/// a conveyor belt does; on a dynamic body it drives the body, as a track does. Only the part along the surface counts. Default: zero.
///
/// Friction on a moving surface slides until there is no slip, and is not anchored: a body at rest against it creeps a little under a
/// steady load.
///
/// ```
/// use bevy_transform::components::Transform;
/// use drystone::prelude::*;
///
/// # let mut app = bevy_app::App::new();
/// # app.add_plugins(DrystonePlugins::default());
/// # let world = app.world_mut();
/// world.spawn((RigidBody::Static, Collider::cuboid(20.0, 1.0, 2.0), SurfaceVelocity(Vec3::X * 2.0)));
/// let parcel = world
///     .spawn((RigidBody::Dynamic, Collider::cuboid(0.5, 0.5, 0.5), Transform::from_xyz(-5.0, 0.75, 0.0)))
///     .id();
/// for _ in 0..120 {
///     drystone::step(world, 1.0 / 60.0).unwrap();
/// }
/// assert!((world.get::<Velocity>(parcel).unwrap().linear.x - 2.0).abs() < 1e-3);
/// ```
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
#[component(on_remove = crate::body::lost_description, summary_tick)]
pub struct SurfaceVelocity(pub Vec3);

impl KeptProperty for SurfaceVelocity {
    fn check(&self) -> Result<(), BodyProblem> {
        match limits::within(self.0, limits::SPEED) {
            true => Ok(()),
            false => Err(BodyProblem::InvalidSurfaceVelocity),
        }
    }
}

impl BodyState {
    /// Velocity of its surface against its material, m/s, world axes.
    pub(crate) fn surface_velocity(&self) -> Vec3 {
        match self.properties.surface_velocity.0 {
            Vec3::ZERO => Vec3::ZERO,
            velocity => self.pose.rotation * velocity,
        }
    }
}
