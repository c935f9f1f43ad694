//! Colliders from the meshes of scenes (feature `mesh`).
//!
//! Put [`MeshColliders`] on an entity, for example on the root of a glTF scene. Its mesh and the meshes of all entities below it become
//! colliders, as soon as all of them are loaded: they come at once, so that nothing falls through what is not there yet. Entities that come
//! below it later are found too.
//!
//! ```
//! use bevy_app::App;
//! use bevy_asset::{AssetApp, Assets};
//! use bevy_mesh::{Mesh, Mesh3d};
//! use bevy_shape::{Cuboid, Sphere};
//! use drystone::collider::MeshShape;
//! use drystone::prelude::*;
//!
//! # use bevy_ecs::prelude::*;
//! # let mut app = App::new();
//! # app.add_plugins((bevy_asset::AssetPlugin::default(), DrystonePlugins::default())).init_asset::<Mesh>();
//! # let mut meshes = app.world_mut().resource_mut::<Assets<Mesh>>();
//! let [floor, stone, ivy] = [Mesh::from(Cuboid::from_length(9.0)), Cuboid::from_length(0.5).into(), Sphere::new(1.0).into()];
//! let [floor, stone, ivy] = [floor, stone, ivy].map(|mesh| Mesh3d(meshes.add(mesh)));
//! let rules = MeshColliders::new(MeshShape::Surface)
//!     .with("Stone", MeshShape::ConvexHull)
//!     .with("Ivy", None);
//! // A loader of scenes would spawn the children.
//! let children = children![(Name::new("Floor"), floor), (Name::new("Stone"), stone), (Name::new("Ivy"), ivy)];
//! let scene = app.world_mut().spawn((rules, children)).id();
//! app.world_mut().add_observer(move |ready: On<MeshCollidersReady>| {
//!     assert_eq!((ready.root, ready.colliders.len()), (scene, 2));
//! });
//! app.update();
//! # let world = app.world_mut();
//! # assert_eq!(world.query::<&Collider>().iter(world).count(), 2);
//! ```
//!
//! # Which shape
//! For each mesh the first of these decides: [`MeshColliders::by_name`] or, with the feature `gltf`, glTF extras of its own entity; then of
//! the entity above it, and so on up to the entity with [`MeshColliders`]; then [`MeshColliders::shape`]. On one entity the name comes
//! before the extras. So the name of an object in Blender holds for all its meshes. An entity that has a [`Collider`] keeps it. A
//! `MeshColliders` below another one is on its own.
//!
//! The shape follows the scale of its `Transform` and of those above, as every [`Collider`] does. Of a skinned or morphed mesh it is the
//! shape at rest.
//!
//! # Which body
//! A collider is a part of the nearest [`RigidBody`](crate::body::RigidBody) above it, and stands still without one; see
//! [`children`](crate::children). So a level needs no body, and a scene that is one thing gets a `RigidBody` on its root. For a scene of
//! several bodies, name them in glTF extras, or insert them in an observer of [`MeshCollidersReady`].
//!
//! # From Blender
//! With the feature `gltf`, custom properties in Blender (*Include → Custom Properties* at export), which are *extras* in glTF, describe
//! bodies and colliders. They may be on materials, meshes or objects. The nearest one decides: of a part of a mesh the material, then the
//! mesh, its object, and the objects above.
//!
//! | property | value | |
//! |---|---|---|
//! | `drystone.collider` | `"surface"`, `"hull"`, `"decomposition"`, `"cuboid"`, `"ball"`, `"capsule"`, `"cylinder"`, `"none"` | shape |
//! | `drystone.body` | `"dynamic"`, `"static"`, `"kinematic"` | the object is a body |
//! | `drystone.mass` | kg | mass of that body |
//! | `drystone.density` | kg/m³ | density of the colliders |
//! | `drystone.friction`, `drystone.restitution` | a number | surface of the colliders |
//! | `drystone.sensor` | `true` | the colliders are sensors |
//!
//! An object under the key `drystone` means the same: `{"drystone": {"collider": "hull", "body": "dynamic"}}`. So does a single word:
//! `{"drystone": "hull"}`. Components that the entity has already are kept.
//!
//! The add-on [Skein](https://bevyskein.dev) inserts reflected components by itself. With the feature `bevy_reflect` it offers
//! [`MeshColliders`], [`RigidBody`](crate::body::RigidBody), [`Mass`](crate::body::Mass), [`Friction`](crate::collider::Friction) and most
//! other components. [`Collider`] itself is opaque to it: use `MeshColliders`, also on a single object.
//!
//! # Errors
//! A mesh that cannot have its shape gets no collider. A [`MeshColliderError`] names it, as a message and in the log.

mod components;
mod error;
#[cfg_attr(not(feature = "gltf"), path = "no_extras.rs")]
mod extras;
mod make;
mod resolve;
mod shapes;
mod waiting;

pub use components::{MeshColliders, MeshCollidersReady};
pub use error::{MeshColliderError, MeshProblem};
pub use make::make_mesh_colliders;
pub use waiting::WaitingMeshes;

#[expect(unused_imports, reason = "for the links of the documentation")]
use crate::body::collider::Collider;
use crate::components::init;
use bevy_app::{App, Plugin, PreUpdate};
use bevy_ecs::prelude::*;

/// Makes colliders from meshes, in `PreUpdate`. It is part of [`DrystonePlugins`](crate::DrystonePlugins) with the feature `mesh`.
#[derive(Debug)]
pub struct MeshColliderPlugin;

/// The system set in `PreUpdate` that makes colliders from meshes.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct MeshColliderSystems;

impl Plugin for MeshColliderPlugin {
    fn build(&self, app: &mut App) {
        init::<WaitingMeshes>(app.world_mut());
        app.add_message::<MeshColliderError>()
            .add_message::<MeshCollidersReady>()
            .add_observer(waiting::root_added)
            .add_observer(waiting::mesh_added)
            .add_observer(waiting::child_added)
            .add_systems(
                PreUpdate,
                make_mesh_colliders
                    .run_if(waiting::any_waiting)
                    .in_set(MeshColliderSystems)
                    .ambiguous_with_all(),
            );
    }

    fn finish(&self, app: &mut App) {
        crate::schedule::check_step_plugin::<Self>(app);
    }
}
