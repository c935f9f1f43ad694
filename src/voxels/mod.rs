//! Voxels: bodies of equal cells that are dug and built cell by cell.
//!
//! Put [`Voxels`] on a body instead of a [`Collider`](crate::collider::Collider), and edit it at any time. A *static* body is divided into
//! chunks of 16³ cells, each a static body of its own, so that an edit costs a chunk and not the whole: a hill of millions of cells may be
//! dug while others play on it. (A hit on a chunk names the chunk; its [`VoxelChunk`] names the body with the grid.) A *dynamic* or
//! *kinematic* body has one collider of few boxes, and its mass, inertia and centre of mass are those of its cells.
//!
//! What is no longer joined to the largest part after cells were emptied, or to the [ground](Voxels::with_ground) if there is one, becomes
//! a dynamic body with a grid of its own, unless [`Voxels::with_splits`] says otherwise; momentum is kept.
//!
//! ```
//! use bevy_ecs::prelude::*;
//! use bevy_transform::components::Transform;
//! use drystone::prelude::*;
//!
//! # let mut app = bevy_app::App::new();
//! # app.add_plugins(DrystonePlugins::default());
//! # let world = app.world_mut();
//! // A table of a thick post and a slab.
//! let mut table = Voxels::new(0.25).with_ground(0);
//! table.set_box(IVec3::new(-1, 0, -1), IVec3::new(1, 8, 1), true);
//! table.set_box(IVec3::new(-6, 8, -6), IVec3::new(6, 9, 6), true);
//! let table = world.spawn((RigidBody::Static, table)).id();
//! let ball = world.spawn((RigidBody::Dynamic, Collider::ball(0.2), Transform::from_xyz(0.0, 2.45, 0.0))).id();
//! # let dt = 1.0 / 60.0;
//! drystone::step(world, dt).unwrap();
//!
//! // A shot through the post: slab and ball fall.
//! world.get_mut::<Voxels>(table).unwrap().set_ball(Vec3::Y, 0.5, false);
//! for _ in 0..60 {
//!     drystone::step(world, dt).unwrap();
//! }
//! assert!(world.get::<Transform>(ball).unwrap().translation.y < 1.9);
//! let mut parts = world.query::<(&RigidBody, &Voxels)>();
//! assert_eq!(parts.iter(world).filter(|(kind, _)| **kind == RigidBody::Dynamic).count(), 1);
//! ```
//!
//! # What rolls over it
//! Cells are merged into boxes, and contacts with the seams between boxes and between chunks are left out, as between the bricks of a
//! floor: what rolls or slides over level cells does so as over a plane.
//!
//! # Limits
//! The scale of a `Transform` is not followed. Chunks take over friction, layers and other properties of the body when they are made.
//! Shapes below the surface are not pushed out of chunks that other full chunks surround.

mod cells;
mod grid;
#[cfg(feature = "serde")]
mod saved;
mod split;
mod sync;

pub use grid::{VoxelChunk, Voxels};
pub use sync::voxels;

use crate::character::CrouchSystems;
use crate::components::{any_with, init};
use crate::fracture::FractureSystems;
use crate::grab::{hands, refresh_for_hands};
use crate::profile::{Profile, own};
use crate::schedule::{PhysicsSchedule, PhysicsSystems, RefreshSchedule};
use bevy_app::{App, Plugin};
use bevy_ecs::component::Components;
use bevy_ecs::prelude::*;

/// Keeps bodies up to date with their [`Voxels`]. It is part of [`DrystonePlugins`](crate::DrystonePlugins).
#[derive(Debug)]
pub struct VoxelPlugin;

/// The system set in which grids that were edited are looked at: before *prepare*.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct VoxelSystems;

impl Plugin for VoxelPlugin {
    fn build(&self, app: &mut App) {
        init::<Profile>(app.world_mut());
        let profile = app.world().resource::<Profile>().clone();
        let any = any_with(Components::component_id::<Voxels>);
        app.add_systems(
            PhysicsSchedule,
            own(&profile, "prepare", voxels)
                .run_if(any_with(Components::component_id::<Voxels>))
                .before(PhysicsSystems::Prepare)
                .before(FractureSystems)
                .after(CrouchSystems)
                .before(refresh_for_hands)
                .before(hands)
                .in_set(VoxelSystems),
        );
        app.add_systems(RefreshSchedule, voxels.run_if(any).in_set(VoxelSystems));
    }

    fn finish(&self, app: &mut App) {
        crate::schedule::check_step_plugin::<Self>(app);
    }
}
