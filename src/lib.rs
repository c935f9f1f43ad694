//! **Drystone** brings rigid-body contact to Bevy that holds without mortar: walls, stacks and arches that stay where they were
//! put, at large time steps and with few solver iterations.
//!
//! Contacts that stick are held by anchors, and normals by a correction that settles them, after Silcowitz-Hansen, Niebe and
//! Erleben, "Normal and Friction Stabilization Techniques for Interactive Rigid Body Constraint-based Contact Force
//! Computations" (VRIPHYS 2010). The paper's own rows and solvers are a preset; the default is
//! [`SoftStep`](solver::SoftStep), which is steadier and faster. Everything is data in an ECS: bodies, contact
//! pairs, manifolds, impulses and anchors are components, a step is a row of systems, and each of them can be seen, timed
//! and replaced.
//!
//! ```
//! use bevy_app::App;
//! use bevy_transform::components::Transform;
//! use drystone::prelude::*;
//!
//! let mut app = App::new();
//! app.add_plugins(DrystonePlugins::default());
//! app.world_mut().spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
//! let brick = app
//!     .world_mut()
//!     .spawn((
//!         RigidBody::Dynamic,
//!         Collider::cuboid(1.0, 0.5, 0.5),
//!         Transform::from_xyz(0.0, 2.0, 0.0),
//!     ))
//!     .id();
//! // A Bevy app steps by itself in `FixedPostUpdate`; without one, step by hand.
//! for _ in 0..120 {
//!     drystone::step(app.world_mut(), 1.0 / 60.0).unwrap();
//! }
//! let height = app.world().get::<Transform>(brick).unwrap().translation.y;
//! assert!((height - 0.25).abs() < 1e-3);
//! ```
//!
//! # The modules, in the order of a step
//!
//! | stage | module | paper | reads | writes |
//! |---|---|---|---|---|
//! | prepare | [`body`] | | `Transform`, all body components | [`Pose`](body::Pose), [`BodyTable`](body::BodyTable) |
//! | broadphase | [`broadphase`] | | `BodyTable` | [`ContactPair`](contact::ContactPair) entities |
//! | narrowphase | [`narrowphase`] | | `BodyTable` | [`Manifold`](contact::Manifold); impulses and anchors in its order |
//! | islands | [`islands`] | | pairs, manifolds | which bodies wake, and which rest; [`Sleeping`](body::Sleeping), [`Resting`](body::Resting) |
//! | friction error | [`stabilization::friction`] | (11)–(15) | manifold, anchors | [`ContactTargets`](contact::ContactTargets) |
//! | normal correction | [`stabilization::normal`] | (1)–(9) | manifold | `ContactTargets` |
//! | forces | [`body`] | | forces, gravity | [`Velocity`](body::Velocity) |
//! | warm start | [`warm_start`] | | pairs, manifolds, last impulses | [`IslandProblems`](warm_start::IslandProblems) |
//! | solve | [`solve`], [`solver`] | (1), (4) | `IslandProblems`, velocities | `Velocity`, [`Motion`](body::Motion), [`ContactImpulses`](contact::ContactImpulses) |
//! | anchors | [`stabilization::anchors`] | (10), (11) | impulses | [`ContactAnchors`](contact::ContactAnchors) |
//! | integration | [`integration`] | | `Velocity` | `Pose`, `Transform` |
//! | sleeping | [`islands`] | | `Velocity` | [`Sleeping`](body::Sleeping) |
//! | contact events | [`contact`] | | pairs | messages, entity events |
//!
//! The order itself stands in [`schedule`]. Between two steps [`refresh`] tells [`query`] what has been edited. Beside the step: [`settings`], [`diagnosis`] of bad input, [`profile`]; what a builder stands on: [`query`]
//! asks the world, [`preview`] says what would happen, [`grab`] holds, [`masonry`] lays, [`collapse`] tells; and behind features of their names
//! `stability`, `gizmos` and `picking`.
//! Scenes by name, experiments and meters are a crate of their own, `drystone-lab` in `lab/`: examples, tests and benches use it.

#![warn(missing_docs)]
#![deny(unsafe_code)]
#![expect(
    clippy::type_complexity,
    reason = "queries are tuples of what a system touches"
)]

pub mod body;
pub mod broadphase;
pub mod collapse;
pub mod collider;
pub mod contact;
pub mod diagnosis;
#[cfg(feature = "diagnostics")]
pub mod diagnostics;
#[cfg(feature = "gizmos")]
pub mod gizmos;
pub mod grab;
pub mod integration;
pub mod islands;
pub mod masonry;
pub mod narrowphase;
#[cfg(feature = "picking")]
pub mod picking;
mod plugin;
pub mod preview;
pub mod profile;
pub mod query;
pub mod schedule;
pub mod settings;
pub mod solve;
pub mod solver;
#[cfg(feature = "stability")]
pub mod stability;
pub mod stabilization;
pub mod warm_start;

pub use plugin::*;
pub use schedule::{advance, refresh, step};

/// What most users need.
pub mod prelude {
    pub use crate::body::{
        Age, AngularInertia, CenterOfMass, Damping, Density, ExternalForce, ExternalImpulse,
        GravityScale, Mass, Motion, Pose, Quarantined, RigidBody, Sleeping, Teleport, Velocity,
    };
    pub use crate::collapse::{Collapse, CollapseEnded, CollapsePlugin, GaveWay, Watch};
    pub use crate::collider::{
        Collider, CollisionLayers, CombineRule, Friction, Restitution, RollingFriction,
    };
    pub use crate::contact::{
        Bearing, ContactEnded, ContactEvents, ContactForce, ContactForceEvents, ContactPair,
        ContactStarted, Contacts, FaceForce, Load, NoBody, Supports,
    };
    pub use crate::diagnosis::{BodyError, StepError};
    pub use crate::grab::{Grab, Grasp, Hand, HandForce, HandPlugin, HeldBy};
    pub use crate::preview::{
        Edit, Moved, Preview, PreviewError, PreviewSettings, Shadow, preview, preview_task,
    };
    pub use crate::profile::Profile;
    pub use crate::query::{
        CastHit, Dir3, Overlap, PointHit, QueryError, QueryFilter, Ray3d, RayHit, SpatialQuery,
    };
    pub use crate::schedule::{PhysicsSchedule, PhysicsSystems};
    pub use crate::settings::{
        ContactSolver, Gravity, NarrowphaseSettings, SleepSettings, SolverSettings, SpeedLimits,
        StabilizationSettings,
    };
    pub use crate::{DrystonePlugins, step};
    pub use glam::{BVec3, Quat, Vec3};
}

/// The README's example, kept true.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
