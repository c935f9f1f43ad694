//! Pairs of bodies that do not collide.

use crate::body::KeptProperty;
use bevy_ecs::entity::{EntityHashSet, EntityMapper, MapEntities};
use bevy_ecs::prelude::*;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::{Reflect, std_traits::ReflectDefault};

/// Bodies that this body does not collide with, whatever their [`CollisionLayers`](super::CollisionLayers) say. It is enough that one of
/// the two names the other.
///
/// May be changed at any time. From the next step on a pair that is named has no contact: if the two touched, a
/// [`ContactEnded`](crate::contact::ContactEnded) is sent, and bodies that slept wake. A pair that is no longer named collides again, and
/// where the two overlap by then they are pushed apart. Rays and other queries still find the body. Entities that are not bodies, or not
/// any more, have no effect.
///
/// ```
/// use bevy_transform::components::Transform;
/// use drystone::prelude::*;
///
/// # let mut app = bevy_app::App::new();
/// # app.add_plugins(DrystonePlugins::default());
/// # let world = app.world_mut();
/// let shape = || (RigidBody::Dynamic, Collider::cuboid(1.0, 1.0, 1.0), GravityScale(0.0));
/// let door = world.spawn(shape()).id();
/// // Half inside the door, as a handle is.
/// let at = Transform::from_xyz(0.5, 0.0, 0.0);
/// let handle = world.spawn((shape(), at, CollisionExceptions::from_iter([door]))).id();
/// for _ in 0..60 {
///     drystone::step(world, 1.0 / 60.0).unwrap();
/// }
/// assert_eq!(world.get::<Transform>(handle), Some(&at));
/// ```
#[derive(Component, Clone, Debug, Default, PartialEq, Eq)]
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
#[component(on_remove = crate::body::lost_description, map_entities, summary_tick)]
pub struct CollisionExceptions(pub EntityHashSet);

impl KeptProperty for CollisionExceptions {}

impl MapEntities for CollisionExceptions {
    fn map_entities<Mapper: EntityMapper>(&mut self, mapper: &mut Mapper) {
        let mapped = self.0.drain().map(|body| mapper.get_mapped(body));
        self.0 = mapped.collect();
    }
}

impl FromIterator<Entity> for CollisionExceptions {
    fn from_iter<Bodies: IntoIterator<Item = Entity>>(bodies: Bodies) -> Self {
        Self(bodies.into_iter().collect())
    }
}
