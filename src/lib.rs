//! **Drystone** is a rigid-body physics library for [Bevy](https://bevy.org) that is made for dry masonry: walls, stacks, arches and towers
//! stay where they were put, at large time steps and with few solver iterations. It is for games in which players build, load what they
//! built and knock it down: it tells what supports a brick, how much weight is on it, and what falls without it.
//!
//! ```
//! use bevy_app::prelude::*; // in a game: `use bevy::prelude::*;`
//! use bevy_ecs::prelude::*;
//! # use bevy_time::{TimePlugin, TimeUpdateStrategy};
//! use drystone::masonry::{Bond, Wall};
//! use drystone::prelude::*;
//!
//! fn build(mut commands: Commands) {
//!     commands.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
//!     for brick in Wall::new(Bond::Running).blocks().unwrap() {
//!         // `RigidBody::Dynamic`, a `Collider` and a `Transform`; and a component that tells the weight on the brick.
//!         commands.spawn((brick.bundle(), Load::default()));
//!     }
//! }
//!
//! fn watch(bricks: Query<(Entity, &Load)>) {
//!     for (brick, load) in &bricks {
//!         if load.supported_weight > 30_000.0 {
//!             println!("{brick} bears {:.0} N", load.supported_weight);
//!         }
//!     }
//! }
//!
//! # let mut app = App::new();
//! # app.add_plugins(TimePlugin).insert_resource(TimeUpdateStrategy::FixedTimesteps(1));
//! // Steps are taken in `FixedPostUpdate`.
//! app.add_plugins(DrystonePlugins::default()).add_systems(Startup, build).add_systems(Update, watch);
//! # app.finish();
//! # (0..60).for_each(|_| app.update());
//! # let world = app.world_mut();
//! # let most = world.query::<&Load>().iter(world).map(|load| load.supported_weight).fold(0.0, f32::max);
//! # assert!(most > 10_000.0, "{most}");
//! ```
//!
//! # Where to start
//!
//! | you want | read |
//! |---|---|
//! | a game with it | the [quickstart](cookbook::quickstart): ten minutes from `cargo new` to a wall that one shoots at |
//! | one task solved | the [cookbook]: a page for each, from a drawbridge to netcode |
//! | to change from another library | [from Avian](cookbook::from_avian), [from bevy_rapier](cookbook::from_rapier) |
//! | the types for a task | [modules by task](#by-task), [questions about the world](#questions-about-the-world), the [prelude] |
//! | what is promised and what is not | [promises], [limits of the library], [determinism](cookbook::determinism) |
//! | how it works | [the method](#the-method), [the order of a step](#the-modules-in-the-order-of-a-step), [why structures stand] |
//!
//! [promises]: https://docs.rs/crate/drystone/latest/source/docs/promises.md
//! [limits of the library]: https://docs.rs/crate/drystone/latest/source/docs/limits.md
//! [why structures stand]: https://docs.rs/crate/drystone/latest/source/docs/stability.md
//!
//! # By task
//!
//! | to | see |
//! |---|---|
//! | build | [`masonry`] generates structures and undoes edits, [`mortar`] bonds bricks, [`children`] make a body of several colliders |
//! | dig, break | [`voxels`]: bodies of cells; [`fracture`]: bodies that break into pieces at a blow, and debris |
//! | move | [`body`]: velocities, forces, locks, teleports; [`character`]: characters that walk, jump and ride; [`grab`]: hands |
//! | drive | [`vehicle`]: wheels with suspension, steering, engine and brake |
//! | float, blow | [`fluid`]: water and wind, in which bodies float and drift |
//! | join | [`joint`]: doors, chains, bridges, sliders, ropes, springs, motors, and joints that break |
//! | ask | the questions below; [`caster`]: rays and shapes of entities |
//! | react | [`sensor`]: who is inside; [`contact`]: events of hits and forces; [`collapse`]: structures that fail |
//! | see | the features `gizmos`, `picking` and `ui`, a panel; [`profile`] and the feature `diagnostics` for times |
//! | save | [`saving`], with the feature `scenes` or `serde` |
//! | stream | [`streaming`]: regions of a large world are taken out, and put back as they stood |
//! | tune | [`settings`]: gravity, pause and slow motion, solver, sleep, threads; [hooks](contact::ContactHooks) |
//!
//! The feature `mesh` makes colliders from meshes, and from all meshes of a scene. All features are off by default.
//!
//! # Questions about the world
//!
//! Each question has a system parameter and a function. Use the parameter in a system, and the function where you have the world.
//! Queries see edits from the next frame on; [`refresh`] makes them visible in the same frame.
//!
//! | question | in a system | with a world |
//! |---|---|---|
//! | What is here? Does this fit? | [`SpatialQuery`](query::SpatialQuery) | [`spatial_query`](query::spatial_query) |
//! | Which forces act on a body? | [`Contacts`](contact::Contacts) | [`contacts`](contact::contacts()) |
//! | Which joints has a body, and what do they bear? | [`Joints`](joint::Joints) | [`joints_of`](joint::joints_of) |
//! | What supports a body, and what does it support? | [`Supports`](contact::Supports) | [`supports`](contact::supports()) |
//! | What would happen after an edit? | [`Previews`](preview::Previews) | [`preview`](preview::preview()), `preview_task` |
//! | Who is inside a zone? | [`SensorOverlaps`](sensor::SensorOverlaps), a component of the sensor | |
//! | How deep is it inside? | [`SensorDepths`](sensor::SensorDepths) | [`sensor_depth`](sensor::sensor_depth) |
//! | How much load can a structure take? (feature `stability`) | `Stability` | `stability`, `stability_task` |
//!
//! # The method
//!
//! Sticking contacts are held by anchors, and penetration is removed by a correction that lets contacts settle, after Silcowitz-Hansen,
//! Niebe and Erleben, "Normal and Friction Stabilization Techniques for Interactive Rigid Body Constraint-based Contact Force Computations"
//! (VRIPHYS 2010). The paper's own settings and solvers are a [preset](settings::Preset::Paper). The default solver is
//! [`SoftStep`](solver::SoftStep), which is steadier and faster.
//!
//! Everything is data in an ECS. Bodies, contact pairs, manifolds, impulses and anchors are components, and a step is a sequence of
//! systems. Each of them can be inspected, timed and replaced.
//!
//! # The modules, in the order of a step
//!
//! | stage | module | paper | reads | writes |
//! |---|---|---|---|---|
//! | prepare | [`body`] | | `Transform`, all body components | [`Pose`](body::Pose), [`BodyTable`](body::BodyTable) |
//! | joints | [`joint`], [`mortar`] | | joints | edges of the graph |
//! | broadphase | [`broadphase`] | | `BodyTable` | [`ContactPair`](contact::ContactPair) entities |
//! | narrowphase | [`narrowphase`] | | `BodyTable` | [`Manifold`](contact::Manifold); impulses and anchors in its order |
//! | islands | [`graph`] | | pairs, manifolds | [`Sleeping`](body::Sleeping) of bodies that wake, [`Inactive`](body::Inactive) |
//! | friction error | [`stabilization::friction`] | (11)–(15) | manifold, anchors | [`ContactTargets`](contact::ContactTargets) |
//! | normal correction | [`stabilization::normal`] | (1)–(9) | manifold | `ContactTargets` |
//! | forces | [`body`] | | forces, gravity | [`Velocity`](body::Velocity) |
//! | warm start | [`warm_start`] | | pairs, manifolds, last impulses | [`IslandProblems`](warm_start::IslandProblems) |
//! | solve | [`solve`], [`solver`] | (1), (4) | problems, speeds | `Velocity`, `Motion`, [`ContactImpulses`](contact::ContactImpulses) |
//! | anchors | [`stabilization::anchors`] | (10), (11) | impulses | [`ContactAnchors`](contact::ContactAnchors) |
//! | integration | [`integration`] | | `Velocity` | `Pose`, `Transform` |
//! | sleeping | [`graph`] | | `Velocity` | [`Sleeping`](body::Sleeping) |
//! | sensors | [`sensor`] | | `Pose`, [`Sensor`](sensor::Sensor) | [`SensorOverlaps`](sensor::SensorOverlaps), messages, entity events |
//! | contact events | [`contact`] | | pairs | messages, entity events |
//!
//! The order is defined in [`schedule`]. [`settings`] holds the settings, [`diagnosis`] the errors about invalid input, and [`profile`] the
//! time of every system.
//!
//! # Which module knows which
//!
//! [`body`] holds all components of bodies and colliders, `pair` and `joint_types` those of contacts and joints, and [`graph`] connects
//! them. The stages of a step stand on these, and [`schedule`] puts the stages in order. Modules that ask, save, build or draw stand
//! on [`schedule`], and no module that a step needs imports them. The whole list is `docs/layers.md`, and a test compares the imports with
//! it.
//!
//! Named scenes, experiments and meters are in a separate crate, `drystone-lab` in `lab/`, which examples, tests and benches use.

#![deny(missing_debug_implementations)]
#![deny(missing_docs)]
#![deny(unsafe_code)]
#![warn(clippy::too_many_lines)]
#![cfg_attr(
    test,
    allow(clippy::disallowed_methods, reason = "tests compare with tolerances")
)]
#![expect(
    clippy::type_complexity,
    reason = "queries are tuples of the components that a system reads and writes"
)]

mod ask;
pub mod body;
pub mod broadphase;
pub mod caster;
pub mod character;
pub mod children;
pub mod collapse;
mod components;
pub mod contact;
#[cfg(any(doc, doctest))]
pub mod cookbook;
pub mod diagnosis;
#[cfg(feature = "diagnostics")]
pub mod diagnostics;
pub mod fluid;
pub mod fracture;
#[cfg(feature = "gizmos")]
pub mod gizmos;
pub mod grab;
pub mod graph;
pub mod integration;
pub mod joint;
mod joint_types;
pub mod limits;
pub mod masonry;
#[cfg(feature = "mesh")]
pub mod mesh_colliders;
pub mod mortar;
pub mod narrowphase;
mod pair;
#[cfg(feature = "ui")]
pub mod panel;
#[cfg(feature = "picking")]
pub mod picking;
mod plugin;
pub mod preview;
pub mod profile;
pub mod query;
#[cfg(feature = "serde")]
pub mod recording;
#[cfg(feature = "bevy_reflect")]
pub mod reflection;
mod restored;
pub mod revision;
pub mod saving;
mod scatter;
pub mod schedule;
pub mod sensor;
pub mod settings;
pub mod snapshot;
pub mod solve;
#[cfg(feature = "stability")]
pub mod stability;
pub mod stabilization;
pub mod state;
mod stored;
pub mod streaming;
pub mod vehicle;
pub mod voxels;
pub mod warm_start;

#[doc(inline)]
pub use body::collider;
/// The solvers, which are a crate of their own: they know neither the ECS nor shapes.
pub use drystone_solver as solver;
/// The geometry library behind [`Collider`](collider::Collider). Its types appear in a few signatures, such as that of
/// [`Collider::shape`](collider::Collider::shape); use this re-export to name them in the version that drystone uses.
pub use parry3d;
pub use plugin::*;
pub use schedule::{advance, refresh, step};

/// The types and functions that most users need.
pub mod prelude {
    pub use crate::body::{
        AngularInertia, CenterOfMass, ColliderDisabled, Damping, Density, Dominance, ExternalForce,
        ExternalImpulse, Forces, GravityScale, LockedAxes, Mass, MassProperties, MaxAngularSpeed,
        MaxLinearSpeed, Motion, Pose, Quarantined, RigidBody, RigidBodyDisabled, Sleeping,
        SolverEffort, SpawnOrder, Teleport, Velocity,
    };
    pub use crate::caster::{CasterRules, RayCaster, ShapeCaster};
    pub use crate::character::{Character, CharacterState};
    pub use crate::children::{ColliderOf, ImplicitBody};
    pub use crate::collapse::{Collapse, CollapseEnded, CollapsePlugin, FailureMode, Watch};
    pub use crate::collider::{
        Collider, CollisionExceptions, CollisionLayer, CollisionLayers, CombineRule, Friction,
        LayerMask, Restitution, RollingFriction, SurfaceVelocity,
    };
    pub use crate::contact::{
        ActiveContactHooks, Bearing, CollidingEntities, ContactEnded, ContactEvents, ContactForce,
        ContactForceEvents, ContactHook, ContactHooks, ContactModification, ContactPair,
        ContactStarted, Contacts, FaceForce, Load, NotABody, Supports, contacts, supports,
    };
    pub use crate::diagnosis::{BodyError, StepError};
    pub use crate::fluid::{Fluid, FluidField};
    pub use crate::fracture::{Debris, Fracturable, Fractured};
    pub use crate::grab::{Grab, GrabForce, Hand, HandPlugin, HandState, HeldBy};
    pub use crate::joint::{
        BreakForce, JointAnchor, JointBasis, JointBroke, JointDisabled, JointError, JointForces,
        JointFrame, JointLimits, JointMotor, Joints, QuarantinedJoint,
    };
    pub use crate::joint_types::types::*;
    #[cfg(feature = "mesh")]
    pub use crate::mesh_colliders::{MeshColliderError, MeshColliders, MeshCollidersReady};
    pub use crate::mortar::{Mortar, MortarBroke, MortarFailure, MortarJoint, Studs};
    pub use crate::preview::{
        Edit, Moved, Preview, PreviewError, PreviewSettings, Previews, Shadow, preview,
        preview_task,
    };
    pub use crate::profile::Profile;
    pub use crate::query::{
        CastHit, CharacterHit, Dir3, Ground, MoveAndSlide, Overlap, PointHit, QueryError,
        QueryFilter, Ray3d, RayHit, Slide, SpatialQuery, spatial_query,
    };
    pub use crate::schedule::{PhysicsSchedule, PhysicsSystems};
    pub use crate::sensor::{Sensor, SensorEntered, SensorExited, SensorOverlap, SensorOverlaps};
    pub use crate::settings::{
        ContactSolver, Gravity, NarrowphaseSettings, PhysicsTime, SleepSettings, SolverSettings,
        SpeedLimits, StabilizationSettings, Waking,
    };
    pub use crate::vehicle::{Wheel, WheelState};
    pub use crate::voxels::{VoxelChunk, Voxels};
    pub use crate::{DrystonePlugins, step};
    pub use glam::{BVec3, IVec3, Quat, Vec3};
}

/// Compiles the README's example.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
