//! Colliders on child entities.
//!
//! An entity that has a [`Collider`](crate::collider::Collider) but no [`RigidBody`](crate::body::RigidBody) is a part of the nearest body
//! above it in the hierarchy (`ChildOf`). The body's shape is the compound of its own collider, if it has one, and of its parts.
//!
//! ```
//! use bevy_ecs::prelude::*;
//! use bevy_transform::components::Transform;
//! use drystone::children::ColliderOf;
//! use drystone::prelude::*;
//!
//! # let mut app = bevy_app::App::new();
//! # app.add_plugins(DrystonePlugins::default());
//! # let world = app.world_mut();
//! # world.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
//! // A hammer: a wooden handle, and a head of iron.
//! let hammer = world
//!     .spawn((
//!         RigidBody::Dynamic,
//!         Transform::from_xyz(0.0, 1.0, 0.0),
//!         children![
//!             (Collider::cuboid(0.8, 0.04, 0.04), Density(700.0)),
//!             (Collider::cuboid(0.1, 0.1, 0.2), Density(7800.0), Friction::new(0.3), Transform::from_xyz(0.4, 0.0, 0.0)),
//!         ],
//!     ))
//!     .id();
//! // The mass is known at once.
//! let mass = world.get::<MassProperties>(hammer).unwrap();
//! assert!((mass.mass() - 16.5).abs() < 0.1);
//! assert!(mass.local_center.x > 0.35);
//! for _ in 0..120 {
//!     drystone::step(world, 1.0 / 60.0).unwrap();
//! }
//!
//! let head = world.get::<Children>(hammer).unwrap()[1];
//! let down = Ray3d::new(Vec3::new(0.4, 3.0, 0.0), Dir3::NEG_Y);
//! let hit = spatial_query(world, |query| query.cast_ray(down, 10.0, &QueryFilter::default()));
//! let hit = hit.unwrap().unwrap();
//! assert_eq!((hit.entity, hit.collider), (hammer, head));
//! assert_eq!(world.get::<ColliderOf>(head).unwrap().body, hammer);
//! ```
//!
//! # Place and scale
//!
//! A part is where the `Transform`s from the body down to it put it, scale included. `GlobalTransform` is not read, because it may be out
//! of date. The scale of the body itself, and of entities above it, scales its shape too. Shapes that cannot follow an uneven scale become
//! convex hulls; see [`Collider::scaled`](crate::collider::Collider::scaled). Parts may be moved, added, removed, given to another body and
//! despawned at any time. A change takes effect in the next step or [`refresh`](crate::refresh()). It counts as a new shape, so a body
//! whose parts move in every step does not come to rest.
//!
//! # Properties
//!
//! | component on a part | meaning | without it |
//! |---|---|---|
//! | [`Density`](crate::body::Density) | density of the part | density of the body |
//! | [`Mass`](crate::body::Mass) | mass of the part | from its density |
//! | [`Friction`], [`Restitution`], [`RollingFriction`] | surface of the part | those of the body |
//! | [`CollisionLayers`](crate::collider::CollisionLayers) | layers of the part | those of the body |
//! | [`Sensor`](crate::sensor::Sensor) | it detects bodies and touches nothing; it has no mass | |
//!
//! `Mass`, `AngularInertia` and `CenterOfMass` on the body set its total. The sum is known as soon as a part is inserted if there are at
//! most 32 entities below the body; with more of them, and after a part was removed, from the next step or refresh on.
//! `CollisionExceptions` and `ContactEvents` belong to bodies.
//!
//! # Bodies below bodies
//!
//! A body below another one is a body of its own, and lives in the world. Its `Transform` is in the frame of its parent, and each step
//! writes it anew, so that the parent's motion does not take the body along: contacts and joints do. If an entity above a body is moved by
//! its `Transform`, the effect depends on both:
//!
//! | moved | dynamic bodies below | others below |
//! |---|---|---|
//! | a kinematic body | stay where they are | kinematic ones move by a velocity, static ones at once |
//! | a kinematic body with [`Teleport`], or faster than [`SpeedLimits`] allow | are moved at once with it | so are all |
//! | a static or dynamic body, or an entity that is no body | are moved at once with it | static ones too; kinematic ones by a velocity |
//!
//! A kinematic body itself moves by its velocity, and friction takes along what lies on it.
//!
//! [`Friction`]: crate::collider::Friction
//! [`Restitution`]: crate::collider::Restitution
//! [`RollingFriction`]: crate::collider::RollingFriction
//! [`SpeedLimits`]: crate::settings::SpeedLimits
//! [`Teleport`]: crate::body::Teleport
//!
//! So a ship on whose deck things slide, stand and fall is a kinematic body at the top of its hierarchy. A node above both a kinematic deck
//! and dynamic bodies would move these at once, and the deck would push them on by friction: move the deck instead, or take the bodies out
//! of the hierarchy. To fix a child to its parent, use a collider without a `RigidBody`, or a
//! [`FixedJoint`](crate::joint::FixedJoint).
//!
//! # Other colliders
//!
//! A collider without a body above it is static: it becomes a [`RigidBody::Static`](crate::body::RigidBody) with the marker
//! [`ImplicitBody`]. Meshes, height fields, triangles and half-spaces cannot be parts of a compound. Below a static or kinematic body they
//! become bodies of that kind, which its `Transform` carries along; below a dynamic body they are left out and reported. The same is true
//! of all colliders below a body whose own collider is of these kinds. A part with invalid input is left out and
//! [reported](crate::diagnosis::BodyError) until the input is corrected; its body goes on without it.

mod assemble;
mod carry;
mod implicit;
mod observers;
mod stay;

pub use crate::body::parts::{ColliderOf, CompoundCollider, ImplicitBody, Unassembled};
pub use assemble::assemble;
pub(crate) use observers::{child_enabled, child_joined, child_left};
pub use stay::stay;
