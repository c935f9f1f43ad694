//! Asking the world: what a ray hits, what a shape would bump into on its way, what is at a point, what is nearest to it, what a shape
//! overlaps, and whether it fits somewhere.
//!
//! [`SpatialQuery`] is a parameter of a system. It looks through the tree of the [`broadphase`](crate::broadphase), and answers for bodies
//! where the last step left them, with the shapes and layers that they had in it: what was spawned, changed or put elsewhere since is seen
//! after the next one, what was despawned is no longer found. Of two hits at one distance either may come first, the same one in every run.
//!
//! ```
//! use bevy_ecs::prelude::*;
//! use bevy_ecs::system::RunSystemOnce;
//! use bevy_transform::components::Transform;
//! use drystone::prelude::*;
//!
//! # let mut app = bevy_app::App::new();
//! # app.add_plugins(DrystonePlugins::default());
//! # let world = app.world_mut();
//! world.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
//! let brick = Collider::cuboid(1.0, 0.5, 0.5);
//! let lies = world.spawn((RigidBody::Dynamic, brick.clone(), Transform::from_xyz(0.0, 0.25, 0.0))).id();
//! drystone::step(world, 1.0 / 60.0).unwrap();
//!
//! fn look(world: SpatialQuery) -> Option<RayHit> {
//!     let down = Ray3d::new(Vec3::new(0.2, 3.0, 0.0), Dir3::NEG_Y);
//!     world.cast_ray(down, 10.0, &QueryFilter::default()).unwrap()
//! }
//! let hit = world.run_system_once(look).unwrap().unwrap();
//! assert_eq!((hit.entity, hit.normal), (lies, Vec3::Y));
//! assert!((hit.distance - 2.5).abs() < 1e-4);
//!
//! // There is room on top of it, but not in it.
//! let fits = |height: f32| move |world: SpatialQuery| {
//!     let there = Pose { position: Vec3::Y * height, ..Pose::default() };
//!     world.fits(&Collider::cuboid(1.0, 0.5, 0.5), there, 1e-3, &QueryFilter::default()).unwrap()
//! };
//! assert!(world.run_system_once(fits(0.75)).unwrap());
//! assert!(!world.run_system_once(fits(0.5)).unwrap());
//! ```

mod casts;
mod error;
mod filter;
mod overlaps;
mod points;
mod rays;

pub use bevy_math::Dir3;
pub use bevy_shape::Ray3d;
pub use casts::CastHit;
pub use error::QueryError;
pub use filter::QueryFilter;
pub use overlaps::Overlap;
pub use points::PointHit;
pub use rays::RayHit;

use crate::body::{BodyState, BodyTable, Pose, Quarantined};
use crate::broadphase::Broadphase;
use crate::settings::PhysicsThreads;
use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;
use parry3d::shape::Shape;

/// See the module's text. In a world without a system at hand it is had by `run_system_once`, or by a `SystemState`.
#[derive(SystemParam)]
pub struct SpatialQuery<'w, 's> {
    broadphase: Res<'w, Broadphase>,
    table: Res<'w, BodyTable>,
    poses: Query<'w, 's, &'static Pose, Without<Quarantined>>,
    threads: Res<'w, PhysicsThreads>,
}

/// A body that may be meant.
#[derive(Clone, Copy)]
struct Target<'a> {
    body: &'a BodyState,
    shape: &'a dyn Shape,
    /// Where it is now, not where it was at the start of the step.
    pose: Pose,
}

impl SpatialQuery<'_, '_> {
    /// The body in a slot, if the filter lets it through and it is still there.
    #[inline]
    fn target(&self, slot: u32, filter: &QueryFilter) -> Option<Target<'_>> {
        let body = self.table.get(slot)?;
        if !filter.admits(body) {
            return None;
        }
        Some(Target {
            body,
            shape: body.shape()?,
            pose: *self.poses.get(body.entity).ok()?,
        })
    }

    /// The nearest of what the tree has found and of what is not in it, where `look` gives by how much it is away.
    fn nearest<H>(
        &self,
        in_tree: Option<(u32, f32)>,
        most: f32,
        distance: impl Fn(u32, f32) -> Option<f32>,
        hit: impl FnOnce(u32) -> Option<H>,
    ) -> Option<H> {
        let (mut best, mut least) = match in_tree {
            Some((slot, distance)) => (Some(slot), distance),
            None => (None, most),
        };
        for slot in self.broadphase.outside() {
            if let Some(distance) = distance(slot, least)
                && distance < least
            {
                (best, least) = (Some(slot), distance);
            }
        }
        hit(best?)
    }

    /// All of what the tree has found and of what is not in it.
    fn all<H>(
        &self,
        in_tree: impl Iterator<Item = u32>,
        hit: impl Fn(u32) -> Option<H>,
    ) -> Vec<(&BodyState, H)> {
        let mut slots: Vec<u32> = in_tree.chain(self.broadphase.outside()).collect();
        // What has left its box may be in both. The order of the tree is that of its history.
        slots.sort_unstable_by_key(|&slot| (self.table.get(slot).map(|body| body.age), slot));
        slots.dedup();
        let hits = slots.into_iter();
        hits.filter_map(|slot| Some((self.table.get(slot)?, hit(slot)?)))
            .collect()
    }
}
