//! The component on the root of a scene, and the message that its colliders are there.

use crate::body::collider::MeshShape;
use bevy_ecs::prelude::*;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::{Reflect, std_traits::ReflectDefault};
use std::collections::HashMap;

/// Makes colliders from the mesh of this entity and from the meshes of all entities below it; see the [module](super). Default: surfaces.
///
/// It acts on meshes that have no collider yet. Removing it takes no collider away. A change of its fields holds for meshes that come
/// later; insert it again to apply it to those that are there and have no collider.
#[derive(Component, Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "bevy_reflect",
    derive(Reflect),
    reflect(Component, Debug, Default)
)]
pub struct MeshColliders {
    /// The shape of meshes that no name and no extras describe. `None`: they get no collider. Default: [`MeshShape::Surface`].
    pub shape: Option<MeshShape>,
    /// The shapes of entities with these `Name`s, and of those below them. `None`: they get no collider. Default: none.
    pub by_name: HashMap<String, Option<MeshShape>>,
    /// Whether glTF extras are read. Default: true.
    #[cfg(feature = "gltf")]
    pub extras: bool,
}

impl Default for MeshColliders {
    fn default() -> Self {
        Self::new(MeshShape::default())
    }
}

impl MeshColliders {
    /// Colliders of this shape; with `None`, only of meshes that names or extras choose.
    pub fn new(shape: impl Into<Option<MeshShape>>) -> Self {
        Self {
            shape: shape.into(),
            by_name: HashMap::default(),
            #[cfg(feature = "gltf")]
            extras: true,
        }
    }

    /// The same, with this shape for entities of this `Name` and those below them; with `None`, without colliders there.
    #[must_use]
    pub fn with(mut self, name: impl Into<String>, shape: impl Into<Option<MeshShape>>) -> Self {
        self.by_name.insert(name.into(), shape.into());
        self
    }
}

/// All meshes at and below an entity with [`MeshColliders`] have been handled. It is sent as a message, and triggered as an event of that
/// entity. It comes again when meshes that came later have been handled.
#[derive(Message, EntityEvent, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect), reflect(Message, Debug))]
pub struct MeshCollidersReady {
    /// The entity with [`MeshColliders`].
    #[event_target]
    pub root: Entity,
    /// The entities that have got a collider since the last time.
    pub colliders: Vec<Entity>,
}
