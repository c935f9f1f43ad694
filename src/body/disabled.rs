//! Bodies and colliders that a user has switched off, without losing a component.

use super::Quarantined;
use bevy_ecs::prelude::*;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::{Reflect, std_traits::ReflectDefault};

/// Takes a body out of the simulation while it is there. The body keeps all its components, and its entity stays in all queries: it is
/// drawn, and may be moved by hand. It does not move, touches nothing, is found by no spatial query, and nothing stands on it. Contacts
/// with it end in the next step, and bodies that slept on it wake.
///
/// When the component is removed the body comes back in the next step as it was: at its `Transform`, with its
/// [`Velocity`](super::Velocity), in its place in the order of spawning. It is awake then.
///
/// ```
/// use bevy_transform::components::Transform;
/// use drystone::prelude::*;
///
/// # let mut app = bevy_app::App::new();
/// # app.add_plugins(DrystonePlugins::default());
/// # let world = app.world_mut();
/// let ball = world.spawn((RigidBody::Dynamic, Collider::ball(0.5), Velocity::linear(Vec3::X))).id();
/// drystone::step(world, 1.0 / 60.0).unwrap();
/// let (at, velocity) = (*world.get::<Transform>(ball).unwrap(), *world.get::<Velocity>(ball).unwrap());
///
/// world.entity_mut(ball).insert(RigidBodyDisabled);
/// for _ in 0..60 {
///     drystone::step(world, 1.0 / 60.0).unwrap();
/// }
/// assert_eq!(world.get(ball), Some(&at));
/// assert_eq!(world.get(ball), Some(&velocity));
///
/// world.entity_mut(ball).remove::<RigidBodyDisabled>();
/// drystone::step(world, 1.0 / 60.0).unwrap();
/// assert!(world.get::<Transform>(ball).unwrap().translation.x > at.translation.x);
/// ```
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
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
// A body that was taken out asleep is still marked as inactive, and only this hook has it looked at.
#[component(on_remove = super::lost_description)]
pub struct RigidBodyDisabled;

/// Switches the collider of a body off while it is there: the body touches nothing and is found by no spatial query. It keeps its mass, and
/// goes on to fall and to fly.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
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
#[component(on_remove = super::lost_description, summary_tick)]
pub struct ColliderDisabled;

/// Filter for entities that are not taken out of the simulation, by a user or because of invalid input.
pub(crate) type Simulated = (Without<Quarantined>, Without<RigidBodyDisabled>);
