//! The stage **sensors**: which bodies are inside a zone.
//!
//! A collider with the component [`Sensor`] touches nothing. It detects the bodies whose shape overlaps its own, wakes nobody and has no
//! place in the [constraint graph](crate::graph). It may be a body, a part of a body, or stand alone.
//!
//! ```
//! use bevy_ecs::prelude::*;
//! use bevy_transform::components::Transform;
//! use drystone::prelude::*;
//!
//! # let mut app = bevy_app::App::new();
//! # app.add_plugins(DrystonePlugins::default());
//! # let world = app.world_mut();
//! # world.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
//! #[derive(Resource, Default)]
//! struct Score(i32);
//!
//! world.init_resource::<Score>();
//! let goal = world
//!     .spawn((Collider::cuboid(2.0, 2.0, 2.0), Sensor, Transform::from_xyz(0.0, 1.0, 0.0)))
//!     .observe(|_: On<SensorEntered>, mut score: ResMut<Score>| score.0 += 1)
//!     .id();
//! let ball = (RigidBody::Dynamic, Collider::ball(0.2), Transform::from_xyz(0.0, 3.0, 0.0));
//! let ball = world.spawn(ball).id();
//! for _ in 0..90 {
//!     drystone::step(world, 1.0 / 60.0).unwrap();
//! }
//! assert_eq!(world.resource::<Score>().0, 1);
//! let inside = world.get::<SensorOverlaps>(goal).unwrap();
//! assert!(inside.contains(ball));
//! assert_eq!(inside.bodies().count(), 1);
//!
//! world.despawn(ball);
//! drystone::step(world, 1.0 / 60.0).unwrap();
//! assert!(world.get::<SensorOverlaps>(goal).unwrap().is_empty());
//! ```
//!
//! # What a sensor detects
//!
//! - Dynamic and kinematic bodies, asleep or awake, at their poses at the end of the step. Static bodies only if the sensor belongs to a
//!   body that is not static: a zone does not report its floor, a foot does.
//! - Solid colliders, not other sensors, and not those of its own body.
//! - Bodies whose [`CollisionLayers`](crate::collider::CollisionLayers) and [`CollisionExceptions`](crate::collider::CollisionExceptions)
//!   would let them collide with it. The layers are those of the part and of the sensor, or else of their bodies.
//! - Bodies that fly through it within a step, on the straight way between their poses at its start and its end. They are inside for that
//!   step. Bodies that move by less than their thickness cannot.
//!
//! Shapes are compared exactly, and touching counts as overlap. Meshes and height fields are surfaces: they overlap what crosses them.
//! [Spatial queries](crate::query) do not find sensors. [`SensorDepths`] says how deep something is inside.
//!
//! # Cost
//!
//! Only what moved is compared: bodies that moved with the sensors near them, and sensors that moved with the bodies near them. Bodies at
//! rest in a sensor at rest cost nothing, however many they are (`cargo bench --bench sensors`).

mod depth;
mod detect;
mod events;
mod stage;
mod zones;

pub use crate::body::{Sensor, SensorOverlap, SensorOverlaps};
pub use depth::{SensorDepths, sensor_depth};
pub(crate) use events::trigger;
pub use events::{SensorEntered, SensorExited, UntriggeredSensorEvents};
pub use stage::sensors;
pub(crate) use zones::PlacedZone;
pub use zones::Sensors;
