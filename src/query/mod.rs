//! Spatial queries: ray casts, shape casts, points, closest points, and overlaps.
//!
//! [`SpatialQuery`] is the system parameter, and [`spatial_query`] the function for code that has a world. Queries use the tree of the
//! [`broadphase`](crate::broadphase). They see bodies at their poses after the last step, with the shapes and layers of that step.
//! Despawned bodies are no longer found. Bodies that were spawned, changed or moved since then are found as they are now from the next
//! frame on, in which the plugin [refreshes](crate::refresh()) queries. To find them in the same frame, put [`refresh`](crate::refresh())
//! between the two systems. If two hits have the same distance, their order is arbitrary but the same in every run.
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
mod character;
mod error;
mod filter;
mod overlaps;
mod pieces;
mod points;
mod rays;
mod touches;
mod view;
mod way;

pub use bevy_math::Dir3;
pub use bevy_shape::Ray3d;
pub use casts::CastHit;
pub use character::{CharacterHit, Ground, MoveAndSlide, Slide};
pub use error::QueryError;
pub use filter::QueryFilter;
pub use overlaps::Overlap;
pub use points::PointHit;
pub use rays::RayHit;

use crate::body::{BodyIndex, BodyState, BodyTable, Pending, Pose, RigidBody, Simulated};
use crate::broadphase::Broadphase;
use crate::settings::{PhysicsThreads, StepTime};
use crate::solver::sort;
use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;
use parry3d::partitioning::Bvh;
use parry3d::shape::Shape;
use std::fmt;
use view::View;

/// System parameter for spatial queries; see the [module](self). Outside of a system use [`spatial_query`].
#[derive(SystemParam)]
pub struct SpatialQuery<'w, 's> {
    broadphase: Res<'w, Broadphase>,
    table: Res<'w, BodyTable>,
    pending: Res<'w, Pending>,
    poses: Query<'w, 's, &'static Pose, (With<RigidBody>, Simulated)>,
    slots: Query<'w, 's, &'static BodyIndex, With<RigidBody>>,
    threads: Res<'w, PhysicsThreads>,
    step: Res<'w, StepTime>,
}

impl fmt::Debug for SpatialQuery<'_, '_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("SpatialQuery").finish_non_exhaustive()
    }
}

/// A body that a query may return.
#[derive(Clone, Copy)]
struct Target<'a> {
    body: &'a BodyState,
    shape: &'a dyn Shape,
    /// Its current pose, not that at the start of the step.
    pose: Pose,
}

/// Asks spatial queries of a world outside of a system: calls `ask` with a [`SpatialQuery`] and returns its result.
///
/// It finds all bodies as they are now: each call [refreshes](crate::refresh()) the world, unless a step is running, and builds the
/// parameter. So ask several questions in one closure.
///
/// ```
/// # use bevy_transform::components::Transform;
/// # use drystone::prelude::*;
/// # let mut app = bevy_app::App::new();
/// # app.add_plugins(DrystonePlugins::default());
/// # let world = app.world_mut();
/// let ball = (RigidBody::Static, Collider::ball(0.5), Transform::from_xyz(0.0, 2.0, 0.0));
/// let ball = world.spawn(ball).id();
/// let here = Vec3::new(0.1, 2.1, 0.0);
/// let bodies = spatial_query(world, |query| query.bodies_at(here, &QueryFilter::default()));
/// assert_eq!(bodies, Ok(vec![ball]));
/// ```
///
/// # Panics
/// If [`StepPlugin`](crate::StepPlugin) was not added.
pub fn spatial_query<R>(world: &mut World, ask: impl FnOnce(SpatialQuery) -> R) -> R {
    crate::schedule::refresh_between_steps(world);
    crate::ask::ask::<SpatialQuery, R>(world, ask)
}

impl SpatialQuery<'_, '_> {
    /// The pose for which queries answer about a body: the pose after the last step, or the pose it was moved to since, as of the last
    /// [`refresh`](crate::refresh()). `None` if the entity is not a body, or not known yet.
    pub fn pose(&self, body: Entity) -> Option<Pose> {
        let pose = self.poses.get(body).ok()?;
        let view = self.view();
        match view.pending(body) {
            Some(number) => Some(view.get(number)?.pose),
            None => Some(*pose),
        }
    }

    /// The body as it was at the start of the last step, if it is in the simulation.
    pub(crate) fn state(&self, body: Entity) -> Option<&BodyState> {
        self.table.body(body, *self.slots.get(body).ok()?)
    }

    /// The slot of a body that is in the simulation.
    pub(crate) fn slot(&self, body: Entity) -> Option<u32> {
        self.slots.get(body).ok().map(|index| index.0)
    }

    #[inline]
    fn view(&self) -> View<'_> {
        View::new(&self.table, &self.broadphase, &self.pending)
    }

    /// The body with this number, if it still exists and the filter admits it.
    #[inline]
    fn target(&self, number: u32, filter: &QueryFilter) -> Option<Target<'_>> {
        let view = self.view();
        let body = view.get(number)?;
        if !filter.admits(body) {
            return None;
        }
        let pose = *self.poses.get(body.entity).ok()?;
        Some(Target {
            body,
            shape: body.shape()?,
            pose: if view.is_pending(number) {
                body.pose
            } else {
                pose
            },
        })
    }

    /// The nearest body. `search` finds the nearest one in a tree, whose leaves have the numbers from the given one on; `distance` is the
    /// distance of a body (m), if it is less than the given one.
    fn nearest<H>(
        &self,
        max_distance: f32,
        search: impl Fn(&Bvh, u32, f32) -> Option<(u32, f32)>,
        distance: impl Fn(u32, f32) -> Option<f32>,
        hit: impl FnOnce(u32) -> Option<H>,
    ) -> Option<H> {
        let (mut best, mut least) = (None, max_distance);
        for (tree, first) in self.view().trees() {
            if let Some((leaf, distance)) = search(tree, first, least)
                && (best.is_none() || distance < least)
            {
                (best, least) = (Some(first + leaf), distance);
            }
        }
        self.view().each_outside(&mut |number| {
            if let Some(distance) = distance(number, least)
                && distance < least
            {
                (best, least) = (Some(number), distance);
            }
        });
        hit(best?)
    }

    /// All bodies that the trees have found, and those in no tree, for which `hit` returns something; in order of spawning.
    fn all<H>(
        &self,
        mut numbers: Vec<u32>,
        hit: impl Fn(u32) -> Option<H>,
    ) -> Vec<(&BodyState, H)> {
        let view = self.view();
        view.each_outside(&mut |number| numbers.push(number));
        // A body that has left its box may occur twice. The order of results from the tree depends on its history, so they are sorted.
        sort::by_key(&mut numbers, |&number| {
            (view.get(number).map(|body| body.spawn_order), number)
        });
        numbers.dedup();
        let mut hits = Vec::new();
        for number in numbers {
            if let Some(body) = view.get(number)
                && let Some(hit) = hit(number)
            {
                hits.push((body, hit));
            }
        }
        hits
    }
}
